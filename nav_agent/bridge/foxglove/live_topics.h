// The robot's state as the messages that ROS 2's tools draw.
#ifndef NAV_AGENT_BRIDGE_FOXGLOVE_LIVE_TOPICS_H_
#define NAV_AGENT_BRIDGE_FOXGLOVE_LIVE_TOPICS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav_agent/bridge/foxglove/foxglove_protocol.h"
#include "nav_agent/service/agent_hub.h"
#include "nav_agent/service/agent_info.h"
#include "nav_agent/service/device_taps.h"

namespace treeline::foxglove {

// In the order of their channels' ids, which begin with 0.
enum class LiveTopic : uint8_t {
  kFrames,       // /tf: map to base_link, base_link to laser
  kPose,         // /pose, with covariance
  kPlan,         // /plan, the global path
  kBand,         // /band, the elastic band's bubbles
  kScan,         // /scan_points: where the newest scan ends, in the map
  kParticles,    // /particles: x, y, z, weight
  kMap,          // /map: the level that the robot is on
  kCostmap,      // /local_costmap
  kCommand,      // /cmd_vel, stamped
  kDiagnostics,  // /diagnostics, once a second and when the mode changes
  kEvents,       // /rosout
  kCamera,       // /camera/color/image_raw/compressed
  kCount
};
inline constexpr size_t kLiveTopics = static_cast<size_t>(LiveTopic::kCount);

// One for each LiveTopic.
const std::vector<Channel>& LiveChannels();

// What one viewer is told. For one thread.
class LiveTopics {
 public:
  // camera: null: there is none. All must outlive it.
  LiveTopics(const agent_service::AgentInfo& info,
             const agent_service::AgentHub& hub,
             const agent_service::PictureKeeper* camera)
      : info_(info), hub_(hub), camera_(camera) {}

  // The topic begins anew: what stays the same is told once more.
  void Begin(LiveTopic topic);

  // CDR of what the topic has to say at `state` that it has not said; none:
  // nothing. All stamps are `now_ns`, since 1970: the robot's own clock may
  // stand on any time.
  std::vector<std::vector<uint8_t>> Next(LiveTopic topic,
                                         const agent_service::AgentState& state,
                                         int64_t now_ns);

 private:
  // Whether the topic has told of no state, or of another one than `mark`.
  bool IsNew(LiveTopic topic, uint64_t mark);
  std::vector<std::vector<uint8_t>> Map(int level, int64_t now_ns);
  std::vector<std::vector<uint8_t>> Events(int64_t now_ns);
  std::vector<std::vector<uint8_t>> Picture(int64_t now_ns);

  const agent_service::AgentInfo& info_;
  const agent_service::AgentHub& hub_;
  const agent_service::PictureKeeper* const camera_;
  // Of what was told last, whatever tells it from the next.
  std::array<std::optional<uint64_t>, kLiveTopics> told_;
  std::vector<core::LevelPose> path_;
  std::shared_ptr<const std::string> picture_;
};

}  // namespace treeline::foxglove

#endif  // NAV_AGENT_BRIDGE_FOXGLOVE_LIVE_TOPICS_H_
