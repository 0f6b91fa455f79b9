#include "nav_agent/bridge/fast_dds/fast_services.h"

#include <arpa/inet.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <ifaddrs.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "common/base/status_macros.h"
#include "nav_agent/bridge/dds/keeping_service.h"
#include "nav_agent/bridge/fast_dds/fast_raw_type.h"

namespace treeline::fast_dds {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using dds::Request;
using dds::RequestId;
using Bytes = std::vector<uint8_t>;

constexpr size_t kTakeAtMost = 256;
// Participants of a machine that are looked for where nothing is told to all.
constexpr uint32_t kParticipantsOfLoopback = 33;
constexpr int32_t kDepth = 10;
constexpr int kMaxDomain = 232;

// Which endpoints of others are matched now. Told by threads of Fast DDS.
class Matched {
 public:
  void Note(int change, const rtps::InstanceHandle_t& handle) {
    const rtps::GUID_t guid = rtps::iHandle2GUID(handle);
    const absl::MutexLock lock(&mutex_);
    if (change > 0) guids_.insert(guid);
    if (change < 0) guids_.erase(guid);
  }
  template <typename Holds>
  bool Any(const Holds& holds) const {
    const absl::MutexLock lock(&mutex_);
    return std::ranges::any_of(guids_, holds);
  }

 private:
  mutable absl::Mutex mutex_;
  std::set<rtps::GUID_t> guids_ ABSL_GUARDED_BY(mutex_);
};

class ReaderListener final : public fast::DataReaderListener {
 public:
  void on_subscription_matched(
      fast::DataReader* /*reader*/,
      const fast::SubscriptionMatchedStatus& status) override {
    writers.Note(status.current_count_change, status.last_publication_handle);
  }
  Matched writers;
};

class WriterListener final : public fast::DataWriterListener {
 public:
  void on_publication_matched(
      fast::DataWriter* /*writer*/,
      const fast::PublicationMatchedStatus& status) override {
    readers.Note(status.current_count_change, status.last_subscription_handle);
  }
  Matched readers;
};

RequestId IdOf(const rtps::GUID_t& guid, const rtps::SequenceNumber_t& number) {
  RequestId id;
  std::copy_n(guid.guidPrefix.value, 12, id.client.begin());
  std::copy_n(guid.entityId.value, 4, id.client.begin() + 12);
  id.sequence = static_cast<int64_t>(number.to64long());
  return id;
}

rtps::GUID_t GuidOf(const RequestId& id) {
  rtps::GUID_t guid;
  std::copy_n(id.client.begin(), 12, guid.guidPrefix.value);
  std::copy_n(id.client.begin() + 12, 4, guid.entityId.value);
  return guid;
}

class FastService final : public dds::KeepingService {
 public:
  FastService(std::string name, fast::DomainParticipant& participant)
      : KeepingService(std::move(name)), participant_(participant) {}
  ~FastService() override;
  FastService(const FastService&) = delete;
  FastService& operator=(const FastService&) = delete;

  absl::Status Open(const std::string& service_type);

 private:
  std::vector<Request> TakeRequests() override;
  Hearing HearingOf(const RequestId& id) const override;
  absl::Status Write(const RequestId& id,
                     std::span<const uint8_t> bytes) override;
  absl::StatusOr<fast::Topic*> MakeTopic(const std::string& topic,
                                         const std::string& type);

  fast::DomainParticipant& participant_;
  ReaderListener requests_listener_;
  WriterListener replies_listener_;
  fast::Subscriber* subscriber_ = nullptr;
  fast::Publisher* publisher_ = nullptr;
  fast::Topic* request_topic_ = nullptr;
  fast::Topic* reply_topic_ = nullptr;
  fast::DataReader* reader_ = nullptr;
  fast::DataWriter* writer_ = nullptr;
};

absl::StatusOr<fast::Topic*> FastService::MakeTopic(const std::string& topic,
                                                    const std::string& type) {
  fast::TypeSupport(new FastRawType(type)).register_type(&participant_);
  fast::Topic* made =
      participant_.create_topic(topic, type, fast::TOPIC_QOS_DEFAULT);
  if (made == nullptr) {
    return absl::UnavailableError("Fast DDS: no topic " + topic);
  }
  return made;
}

absl::Status FastService::Open(const std::string& service_type) {
  TL_ASSIGN_OR_RETURN(
      request_topic_,
      MakeTopic(dds::DdsRequestTopicName(name()),
                dds::DdsTypeName(absl::StrCat(service_type, "_Request"))));
  TL_ASSIGN_OR_RETURN(
      reply_topic_,
      MakeTopic(dds::DdsReplyTopicName(name()),
                dds::DdsTypeName(absl::StrCat(service_type, "_Response"))));
  subscriber_ = participant_.create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  publisher_ = participant_.create_publisher(fast::PUBLISHER_QOS_DEFAULT);
  if (subscriber_ == nullptr || publisher_ == nullptr) {
    return absl::UnavailableError("Fast DDS: " + name());
  }
  fast::DataWriterQos writer_qos = fast::DATAWRITER_QOS_DEFAULT;
  writer_qos.endpoint().history_memory_policy =
      rtps::DYNAMIC_RESERVE_MEMORY_MODE;
  writer_qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  writer_qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  writer_qos.history().depth = kDepth;
  writer_qos.data_sharing().off();
  fast::DataReaderQos reader_qos = fast::DATAREADER_QOS_DEFAULT;
  reader_qos.endpoint().history_memory_policy =
      rtps::DYNAMIC_RESERVE_MEMORY_MODE;
  reader_qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  reader_qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  reader_qos.history().depth = kDepth;
  reader_qos.data_sharing().off();
  // Replies can be given before requests can come.
  writer_ = publisher_->create_datawriter(
      reply_topic_, writer_qos, &replies_listener_,
      fast::StatusMask::publication_matched());
  reader_ = subscriber_->create_datareader(
      request_topic_, reader_qos, &requests_listener_,
      fast::StatusMask::subscription_matched());
  if (writer_ == nullptr || reader_ == nullptr) {
    return absl::UnavailableError("Fast DDS: " + name());
  }
  return absl::OkStatus();
}

FastService::~FastService() {
  if (reader_ != nullptr) subscriber_->delete_datareader(reader_);
  if (writer_ != nullptr) publisher_->delete_datawriter(writer_);
  if (subscriber_ != nullptr) participant_.delete_subscriber(subscriber_);
  if (publisher_ != nullptr) participant_.delete_publisher(publisher_);
  if (request_topic_ != nullptr) participant_.delete_topic(request_topic_);
  if (reply_topic_ != nullptr) participant_.delete_topic(reply_topic_);
}

std::vector<Request> FastService::TakeRequests() {
  std::vector<Request> requests;
  Bytes bytes;
  fast::SampleInfo info;
  while (requests.size() < kTakeAtMost &&
         reader_->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data) continue;
    // The reader that the reply is for; ROS 2's clients name it.
    const rtps::GUID_t& reader = info.related_sample_identity.writer_guid();
    if (reader == rtps::GUID_t::unknown()) {
      CountNotUnderstood();
      continue;
    }
    requests.push_back(
        {.id = IdOf(reader, info.sample_identity.sequence_number()),
         .bytes = bytes});
  }
  return requests;
}

dds::KeepingService::Hearing FastService::HearingOf(const RequestId& id) const {
  const rtps::GUID_t reader = GuidOf(id);
  if (replies_listener_.readers.Any(
          [&](const rtps::GUID_t& guid) { return guid == reader; })) {
    return Hearing::kHears;
  }
  // Its writer went with its participant, or before it.
  const bool asks =
      requests_listener_.writers.Any([&](const rtps::GUID_t& guid) {
        return guid.guidPrefix == reader.guidPrefix;
      });
  return asks ? Hearing::kNotYet : Hearing::kGone;
}

absl::Status FastService::Write(const RequestId& id,
                                std::span<const uint8_t> bytes) {
  Bytes reply(bytes.begin(), bytes.end());
  rtps::WriteParams parameters;
  parameters.related_sample_identity().writer_guid(GuidOf(id));
  parameters.related_sample_identity().sequence_number() =
      rtps::SequenceNumber_t(static_cast<int32_t>(id.sequence >> 32),
                             static_cast<uint32_t>(id.sequence));
  if (!writer_->write(&reply, parameters)) {
    return absl::UnavailableError("Fast DDS: replying for " + name());
  }
  return absl::OkStatus();
}

// Of a network interface, by its name.
std::vector<std::string> AddressesOf(const std::string& interface) {
  std::vector<std::string> addresses;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return addresses;
  for (const ifaddrs* at = all; at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET ||
        interface != at->ifa_name) {
      continue;
    }
    sockaddr_in address{};
    std::memcpy(&address, at->ifa_addr, sizeof(address));
    std::array<char, INET_ADDRSTRLEN> text{};
    if (inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size()) !=
        nullptr) {
      addresses.emplace_back(text.data());
    }
  }
  freeifaddrs(all);
  return addresses;
}

absl::StatusOr<fast::DomainParticipantQos> ParticipantQosOf(
    const dds::DomainOptions& options) {
  fast::DomainParticipantQos qos =
      fast::DomainParticipantFactory::get_instance()
          ->get_default_participant_qos();
  constexpr absl::string_view kUserData = "enclave=/;";
  qos.user_data().setValue({kUserData.begin(), kUserData.end()});
  if (options.interface.empty() && !qos.transport().user_transports.empty()) {
    return qos;
  }
  auto udp =
      std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  if (!options.interface.empty()) {
    udp->interfaceWhiteList = AddressesOf(options.interface);
    if (udp->interfaceWhiteList.empty()) {
      return absl::UnavailableError(absl::StrCat(
          "the network interface ", options.interface,
          " has no IPv4 address; `ip addr` lists those of this machine"));
    }
  }
  if (options.interface == "lo") {
    udp->maxInitialPeersRange = kParticipantsOfLoopback;
    rtps::Locator_t local;
    rtps::IPLocator::setIPv4(local, "127.0.0.1");
    qos.wire_protocol().builtin.initialPeersList.push_back(local);
  }
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports = {udp};
  return qos;
}

class Participant final : public FastServices {
 public:
  Participant(dds::NodeName name, fast::DomainParticipant* participant)
      : name_(std::move(name)), participant_(participant) {}
  ~Participant() override {
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(
        participant_);
  }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  absl::StatusOr<std::unique_ptr<dds::Service>> Serve(
      const std::string& service, const std::string& service_type) override {
    TL_ASSIGN_OR_RETURN(const std::string full,
                        dds::FullTopicName(service, name_));
    auto made = std::make_unique<FastService>(full, *participant_);
    TL_RETURN_IF_ERROR(made->Open(service_type));
    return made;
  }

 private:
  const dds::NodeName name_;
  fast::DomainParticipant* const participant_;
};

// What it has to say goes to standard error: standard output is the program's.
void LogToStandardError() {
  static const bool is_done = [] {
    fast::Log::ClearConsumers();
    auto consumer = std::make_unique<fast::StdoutErrConsumer>();
    consumer->stderr_threshold(fast::Log::Kind::Info);
    fast::Log::RegisterConsumer(std::move(consumer));
    return true;
  }();
  static_cast<void>(is_done);
}

}  // namespace

absl::StatusOr<std::unique_ptr<FastServices>> FastServices::Join(
    const dds::DomainOptions& options, const dds::NodeName& name) {
  if (options.id < 0 || options.id > kMaxDomain) {
    return absl::InvalidArgumentError(
        absl::StrCat("domain ", options.id, ": it must be in 0..", kMaxDomain));
  }
  TL_RETURN_IF_ERROR(dds::FullTopicName("~/x", name).status());
  LogToStandardError();
  auto* factory = fast::DomainParticipantFactory::get_instance();
  factory->load_profiles();
  TL_ASSIGN_OR_RETURN(const fast::DomainParticipantQos qos,
                      ParticipantQosOf(options));
  fast::DomainParticipant* participant =
      factory->create_participant(static_cast<uint32_t>(options.id), qos);
  if (participant == nullptr) {
    return absl::UnavailableError(
        absl::StrCat("Fast DDS: domain ", options.id));
  }
  return std::make_unique<Participant>(name, participant);
}

}  // namespace treeline::fast_dds
