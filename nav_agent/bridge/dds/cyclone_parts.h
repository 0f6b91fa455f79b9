// What topics and services over Cyclone DDS have in common. For the sources of
// this folder.
#ifndef NAV_AGENT_BRIDGE_DDS_CYCLONE_PARTS_H_
#define NAV_AGENT_BRIDGE_DDS_CYCLONE_PARTS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/bridge/dds/node.h"

struct ddsi_sertype;

namespace treeline::dds {

// An entity of Cyclone, with all that hangs on it.
class Entity {
 public:
  explicit Entity(int32_t id = 0) : id_(id) {}
  ~Entity();
  Entity(Entity&& other) noexcept;
  Entity& operator=(Entity&& other) noexcept;
  int32_t id() const { return id_; }

 private:
  int32_t id_;
};

// UNAVAILABLE, with what Cyclone says, if `id` is an error.
absl::StatusOr<Entity> Made(int32_t id, const std::string& what);

struct RawTopic {
  Entity entity;
  // Of the topic; lives as long.
  const ddsi_sertype* type = nullptr;
};
// The names as DDS sees them: "rt/scan", "sensor_msgs::msg::dds_::LaserScan_".
absl::StatusOr<RawTopic> MakeRawTopic(const Entity& participant,
                                      const std::string& topic,
                                      const std::string& type);

// user_data: what ROS 2 writes beside an endpoint; "": nothing.
absl::StatusOr<Entity> MakeWriter(const Entity& participant,
                                  const RawTopic& topic, const Quality& quality,
                                  const std::string& user_data = "");
// What comes wakes whoever waits for `waitset`.
absl::StatusOr<Entity> MakeReader(const Entity& participant,
                                  const Entity& waitset, const RawTopic& topic,
                                  const Quality& quality,
                                  const std::string& user_data = "");

absl::Status WriteRaw(const Entity& writer, const RawTopic& topic,
                      std::span<const uint8_t> bytes);

// Of a sample: its bytes, its writer's clock (ns since 1970) and which writer
// it was, as long as that is known.
using OnRaw = std::function<void(std::span<const uint8_t> bytes,
                                 int64_t written_ns, uint64_t writer)>;
// What has come, oldest first, and not more than 256; never waits.
void TakeRaw(const Entity& reader, const OnRaw& on_raw);

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_CYCLONE_PARTS_H_
