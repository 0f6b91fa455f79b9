#include "nav_agent/bridge/dds/cyclone_parts.h"

#include <array>
#include <memory>
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
// By one call of TakeRaw.
constexpr size_t kTakeAtMost = 256;
// A reliable writer waits at most so long for slow readers.
constexpr dds_duration_t kMaxBlocking = DDS_MSECS(100);

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

Qos QosOf(const Quality& quality, const std::string& user_data) {
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
  if (!user_data.empty()) {
    dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  }
  return qos;
}

}  // namespace

Entity::~Entity() {
  if (id_ > 0) dds_delete(id_);
}

Entity::Entity(Entity&& other) noexcept : id_(std::exchange(other.id_, 0)) {}

Entity& Entity::operator=(Entity&& other) noexcept {
  std::swap(id_, other.id_);
  return *this;
}

absl::StatusOr<Entity> Made(int32_t id, const std::string& what) {
  if (id > 0) return Entity(id);
  return absl::UnavailableError(
      absl::StrCat("DDS: ", what, ": ", dds_strretcode(id)));
}

absl::StatusOr<RawTopic> MakeRawTopic(const Entity& participant,
                                      const std::string& topic,
                                      const std::string& type) {
  ddsi_sertype* made = NewRawType(type);
  const dds_entity_t id = dds_create_topic_sertype(
      participant.id(), topic.c_str(), &made, nullptr, nullptr, nullptr);
  if (id < 0) ddsi_sertype_unref(made);
  TL_ASSIGN_OR_RETURN(Entity entity, Made(id, "the topic " + topic));
  return RawTopic{.entity = std::move(entity), .type = made};
}

absl::StatusOr<Entity> MakeWriter(const Entity& participant,
                                  const RawTopic& topic, const Quality& quality,
                                  const std::string& user_data) {
  return Made(dds_create_writer(participant.id(), topic.entity.id(),
                                QosOf(quality, user_data).get(), nullptr),
              "a writer");
}

absl::StatusOr<Entity> MakeReader(const Entity& participant,
                                  const Entity& waitset, const RawTopic& topic,
                                  const Quality& quality,
                                  const std::string& user_data) {
  TL_ASSIGN_OR_RETURN(
      Entity reader,
      Made(dds_create_reader(participant.id(), topic.entity.id(),
                             QosOf(quality, user_data).get(), nullptr),
           "a reader"));
  // Goes with the reader.
  const dds_entity_t condition =
      dds_create_readcondition(reader.id(), DDS_ANY_STATE);
  const dds_return_t attached =
      condition < 0 ? condition
                    : dds_waitset_attach(waitset.id(), condition, 0);
  if (attached < 0) {
    return absl::UnavailableError(
        absl::StrCat("DDS: waiting for a reader: ", dds_strretcode(attached)));
  }
  return reader;
}

absl::Status WriteRaw(const Entity& writer, const RawTopic& topic,
                      std::span<const uint8_t> bytes) {
  const dds_return_t result =
      dds_writecdr(writer.id(), NewRawSample(topic.type, bytes));
  if (result >= 0) return absl::OkStatus();
  return absl::UnavailableError(dds_strretcode(result));
}

void TakeRaw(const Entity& reader, const OnRaw& on_raw) {
  std::array<ddsi_serdata*, kTakeAtOnce> data{};
  std::array<dds_sample_info_t, kTakeAtOnce> infos{};
  size_t taken = 0;
  while (taken + kTakeAtOnce <= kTakeAtMost) {
    const dds_return_t count = dds_takecdr(
        reader.id(), data.data(), kTakeAtOnce, infos.data(), DDS_ANY_STATE);
    if (count <= 0) break;
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      if (infos[i].valid_data) {
        ++taken;
        on_raw(BytesOf(data[i]), infos[i].source_timestamp,
               infos[i].publication_handle);
      }
      ddsi_serdata_unref(data[i]);
    }
  }
}

}  // namespace treeline::dds
