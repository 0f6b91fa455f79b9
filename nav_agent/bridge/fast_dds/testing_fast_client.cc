#include "nav_agent/bridge/fast_dds/testing_fast_client.h"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <map>

#include "nav_agent/bridge/dds/topic_names.h"
#include "nav_agent/bridge/fast_dds/fast_raw_type.h"

namespace treeline::fast_dds {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

fast::DomainParticipantQos LoopbackAlone() {
  fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
  qos.transport().use_builtin_transports = false;
  auto udp =
      std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  udp->maxInitialPeersRange = 33;
  qos.transport().user_transports.push_back(udp);
  rtps::Locator_t local;
  rtps::IPLocator::setIPv4(local, "127.0.0.1");
  qos.wire_protocol().builtin.initialPeersList.push_back(local);
  return qos;
}

template <typename T>
T* Needed(T* made) {
  if (made == nullptr) std::abort();
  return made;
}

fast::DomainParticipant* Join(int domain) {
  return Needed(
      fast::DomainParticipantFactory::get_instance()->create_participant(
          static_cast<uint32_t>(domain), LoopbackAlone()));
}

void Leave(fast::DomainParticipant* participant) {
  participant->delete_contained_entities();
  fast::DomainParticipantFactory::get_instance()->delete_participant(
      participant);
}

fast::Topic* TopicOf(fast::DomainParticipant* participant,
                     const std::string& name, const std::string& type) {
  fast::TypeSupport(new FastRawType(type)).register_type(participant);
  return Needed(participant->create_topic(name, type, fast::TOPIC_QOS_DEFAULT));
}

// As rmw_fastrtps_cpp makes them.
fast::DataReaderQos ReaderQos() {
  fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.endpoint().history_memory_policy =
      rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.history().depth = 10;
  return qos;
}

}  // namespace

struct TestingFastClient::Parts {
  fast::DomainParticipant* participant = nullptr;
  fast::DataWriter* writer = nullptr;
  fast::DataReader* reader = nullptr;
  std::map<int64_t, std::vector<uint8_t>> replies = {};
};

TestingFastClient::TestingFastClient(int domain, const std::string& service,
                                     const std::string& service_type)
    : parts_(std::make_unique<Parts>()) {
  parts_->participant = Join(domain);
  fast::DataWriterQos writer_qos = fast::DATAWRITER_QOS_DEFAULT;
  writer_qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  writer_qos.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  writer_qos.endpoint().history_memory_policy =
      rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  writer_qos.history().depth = 10;
  parts_->reader = Needed(
      Needed(
          parts_->participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT))
          ->create_datareader(
              TopicOf(parts_->participant, dds::DdsReplyTopicName(service),
                      dds::DdsTypeName(service_type + "_Response")),
              ReaderQos()));
  parts_->writer = Needed(
      Needed(parts_->participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT))
          ->create_datawriter(
              TopicOf(parts_->participant, dds::DdsRequestTopicName(service),
                      dds::DdsTypeName(service_type + "_Request")),
              writer_qos));
}

TestingFastClient::~TestingFastClient() { Leave(parts_->participant); }

bool TestingFastClient::IsMatched() const {
  fast::PublicationMatchedStatus out;
  fast::SubscriptionMatchedStatus in;
  parts_->writer->get_publication_matched_status(out);
  parts_->reader->get_subscription_matched_status(in);
  return out.current_count > 0 && in.current_count > 0;
}

// rmw_request.cpp's __rmw_send_request.
int64_t TestingFastClient::Ask(std::span<const uint8_t> bytes,
                               bool names_reader) {
  std::vector<uint8_t> request(bytes.begin(), bytes.end());
  rtps::WriteParams parameters;
  if (names_reader) {
    parameters.related_sample_identity().writer_guid() = parts_->reader->guid();
  }
  if (!parts_->writer->write(&request, parameters)) std::abort();
  return static_cast<int64_t>(
      parameters.sample_identity().sequence_number().to64long());
}

// rmw_response.cpp's __rmw_take_response.
std::optional<std::vector<uint8_t>> TestingFastClient::ReplyTo(
    int64_t sequence) {
  std::vector<uint8_t> bytes;
  fast::SampleInfo info;
  while (parts_->reader->take_next_sample(&bytes, &info) ==
         ReturnCode_t::RETCODE_OK) {
    const rtps::SampleIdentity& asked = info.related_sample_identity;
    if (!info.valid_data || (asked.writer_guid() != parts_->reader->guid() &&
                             asked.writer_guid() != parts_->writer->guid())) {
      continue;
    }
    parts_->replies[static_cast<int64_t>(asked.sequence_number().to64long())] =
        bytes;
  }
  const auto found = parts_->replies.find(sequence);
  if (found == parts_->replies.end()) return std::nullopt;
  return found->second;
}

struct TestingFastSubscription::Parts {
  fast::DomainParticipant* participant = nullptr;
  fast::DataReader* reader = nullptr;
};

TestingFastSubscription::TestingFastSubscription(
    int domain, const std::string& topic, const std::string& message_name,
    bool is_latched)
    : parts_(std::make_unique<Parts>()) {
  parts_->participant = Join(domain);
  fast::DataReaderQos qos = ReaderQos();
  qos.durability().kind = is_latched ? fast::TRANSIENT_LOCAL_DURABILITY_QOS
                                     : fast::VOLATILE_DURABILITY_QOS;
  parts_->reader =
      Needed(Needed(parts_->participant->create_subscriber(
                        fast::SUBSCRIBER_QOS_DEFAULT))
                 ->create_datareader(
                     TopicOf(parts_->participant, dds::DdsTopicName(topic),
                             dds::DdsTypeName(message_name)),
                     qos));
}

TestingFastSubscription::~TestingFastSubscription() {
  Leave(parts_->participant);
}

std::vector<std::vector<uint8_t>> TestingFastSubscription::Take() {
  std::vector<std::vector<uint8_t>> samples;
  std::vector<uint8_t> bytes;
  fast::SampleInfo info;
  while (parts_->reader->take_next_sample(&bytes, &info) ==
         ReturnCode_t::RETCODE_OK) {
    if (info.valid_data) samples.push_back(bytes);
  }
  return samples;
}

}  // namespace treeline::fast_dds
