#include "nav_agent/bridge/dds/node.h"

#include <array>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "dds/dds.h"
#include "dds/ddsi/ddsi_serdata.h"
#include "nav_agent/bridge/dds/raw_type.h"

namespace treeline::dds {
namespace {

// Taken at once by one call of Cyclone.
constexpr uint32_t kTakeAtOnce = 16;
// By one call of Take.
constexpr size_t kTakeAtMost = 256;
// A reliable writer waits at most so long for slow readers.
constexpr dds_duration_t kMaxBlocking = DDS_MSECS(100);

// An entity of Cyclone, with all that hangs on it.
class Entity {
 public:
  explicit Entity(dds_entity_t id = 0) : id_(id) {}
  ~Entity() {
    if (id_ > 0) dds_delete(id_);
  }
  Entity(Entity&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  dds_entity_t id() const { return id_; }

 private:
  dds_entity_t id_;
};

absl::StatusOr<Entity> Made(dds_entity_t id, const std::string& what) {
  if (id > 0) return Entity(id);
  return absl::UnavailableError(
      absl::StrCat("DDS: ", what, ": ", dds_strretcode(id)));
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

Qos QosOf(const Quality& quality) {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(),
                       quality.is_reliable ? DDS_RELIABILITY_RELIABLE
                                           : DDS_RELIABILITY_BEST_EFFORT,
                       kMaxBlocking);
  dds_qset_durability(qos.get(), quality.is_latched
                                     ? DDS_DURABILITY_TRANSIENT_LOCAL
                                     : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  if (quality.is_latched) {
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST,
                                quality.depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  // A writer that ends takes nothing back.
  dds_qset_writer_data_lifecycle(qos.get(), false);
  const dds_data_representation_id_t representation =
      DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &representation);
  return qos;
}

class CyclonePublisher final : public Publisher {
 public:
  CyclonePublisher(std::string topic, Entity topic_entity,
                   const ddsi_sertype* type, Entity writer)
      : topic_(std::move(topic)),
        topic_entity_(std::move(topic_entity)),
        type_(type),
        writer_(std::move(writer)) {}

  absl::Status Publish(std::span<const uint8_t> bytes) override {
    const dds_return_t result =
        dds_writecdr(writer_.id(), NewRawSample(type_, bytes));
    if (result >= 0) return absl::OkStatus();
    return absl::UnavailableError(
        absl::StrCat("DDS: writing to ", topic_, ": ", dds_strretcode(result)));
  }
  int matched() const override {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_.id(), &status);
    return static_cast<int>(status.current_count);
  }
  const std::string& topic() const override { return topic_; }

 private:
  const std::string topic_;
  const Entity topic_entity_;
  // Of the topic; lives as long.
  const ddsi_sertype* const type_;
  const Entity writer_;
};

class CycloneSubscription final : public Subscription {
 public:
  CycloneSubscription(std::string topic, Entity topic_entity, Entity reader)
      : topic_(std::move(topic)),
        topic_entity_(std::move(topic_entity)),
        reader_(std::move(reader)) {}

  std::vector<Sample> Take() override {
    std::vector<Sample> samples;
    std::array<ddsi_serdata*, kTakeAtOnce> data{};
    std::array<dds_sample_info_t, kTakeAtOnce> infos{};
    while (samples.size() + kTakeAtOnce <= kTakeAtMost) {
      const dds_return_t count = dds_takecdr(
          reader_.id(), data.data(), kTakeAtOnce, infos.data(), DDS_ANY_STATE);
      if (count <= 0) break;
      for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
        if (infos[i].valid_data) {
          const std::span<const uint8_t> bytes = BytesOf(data[i]);
          samples.push_back({.bytes = {bytes.begin(), bytes.end()},
                             .written_ns = infos[i].source_timestamp});
        }
        ddsi_serdata_unref(data[i]);
      }
    }
    return samples;
  }
  int matched() const override {
    dds_subscription_matched_status_t status{};
    dds_get_subscription_matched_status(reader_.id(), &status);
    return static_cast<int>(status.current_count);
  }
  int64_t lost() const override {
    dds_sample_lost_status_t status{};
    dds_get_sample_lost_status(reader_.id(), &status);
    return status.total_count;
  }
  const std::string& topic() const override { return topic_; }

 private:
  const std::string topic_;
  const Entity topic_entity_;
  const Entity reader_;
};

class CycloneNode final : public Node {
 public:
  CycloneNode(NodeName name, Entity participant, Entity waitset)
      : name_(std::move(name)),
        participant_(std::move(participant)),
        waitset_(std::move(waitset)) {}

  absl::StatusOr<std::unique_ptr<Publisher>> Advertise(
      const std::string& topic, const std::string& message_name,
      const Quality& quality) override {
    TL_ASSIGN_OR_RETURN(Topic made, MakeTopic(topic, message_name));
    TL_ASSIGN_OR_RETURN(
        Entity writer,
        Made(dds_create_writer(participant_.id(), made.entity.id(),
                               QosOf(quality).get(), nullptr),
             "a writer of " + made.name));
    return std::make_unique<CyclonePublisher>(made.name, std::move(made.entity),
                                              made.type, std::move(writer));
  }

  absl::StatusOr<std::unique_ptr<Subscription>> Subscribe(
      const std::string& topic, const std::string& message_name,
      const Quality& quality) override {
    TL_ASSIGN_OR_RETURN(Topic made, MakeTopic(topic, message_name));
    TL_ASSIGN_OR_RETURN(
        Entity reader,
        Made(dds_create_reader(participant_.id(), made.entity.id(),
                               QosOf(quality).get(), nullptr),
             "a reader of " + made.name));
    // Goes with the reader.
    const dds_entity_t condition =
        dds_create_readcondition(reader.id(), DDS_ANY_STATE);
    const dds_return_t attached =
        condition < 0 ? condition
                      : dds_waitset_attach(waitset_.id(), condition, 0);
    if (attached < 0) {
      return absl::UnavailableError(absl::StrCat(
          "DDS: waiting for ", made.name, ": ", dds_strretcode(attached)));
    }
    return std::make_unique<CycloneSubscription>(
        made.name, std::move(made.entity), std::move(reader));
  }

  bool Wait(std::chrono::nanoseconds at_most) override {
    return dds_waitset_wait(waitset_.id(), nullptr, 0, at_most.count()) > 0;
  }

 private:
  struct Topic {
    std::string name;
    Entity entity;
    const ddsi_sertype* type = nullptr;
  };

  absl::StatusOr<Topic> MakeTopic(const std::string& topic,
                                  const std::string& message_name);

  const NodeName name_;
  const Entity participant_;
  const Entity waitset_;
};

absl::StatusOr<CycloneNode::Topic> CycloneNode::MakeTopic(
    const std::string& topic, const std::string& message_name) {
  TL_ASSIGN_OR_RETURN(const std::string full, FullTopicName(topic, name_));
  ddsi_sertype* type = NewRawType(DdsTypeName(message_name));
  const dds_entity_t id =
      dds_create_topic_sertype(participant_.id(), DdsTopicName(full).c_str(),
                               &type, nullptr, nullptr, nullptr);
  if (id < 0) ddsi_sertype_unref(type);
  TL_ASSIGN_OR_RETURN(Entity entity, Made(id, "the topic " + full));
  return Topic{.name = full, .entity = std::move(entity), .type = type};
}

}  // namespace

absl::StatusOr<std::unique_ptr<Node>> Node::Create(const Domain& domain,
                                                   const NodeName& name) {
  // That the names are good.
  TL_RETURN_IF_ERROR(FullTopicName("~/x", name).status());
  // What ROS 2 looks for in a participant: its enclave of security.
  constexpr char kUserData[] = "enclave=/;";
  const Qos qos(dds_create_qos());
  dds_qset_userdata(qos.get(), kUserData, sizeof(kUserData) - 1);
  TL_ASSIGN_OR_RETURN(
      Entity participant,
      Made(dds_create_participant(static_cast<dds_domainid_t>(domain.id()),
                                  qos.get(), nullptr),
           absl::StrCat("domain ", domain.id())));
  TL_ASSIGN_OR_RETURN(Entity waitset,
                      Made(dds_create_waitset(participant.id()), "a waitset"));
  return std::make_unique<CycloneNode>(name, std::move(participant),
                                       std::move(waitset));
}

}  // namespace treeline::dds
