// Keeps an elastic band along the next metres of a path: sets it up, carries it
// on, mends it, and says where it cannot be mended.
#ifndef NAV_AGENT_CONTROL_BAND_FOLLOWER_H_
#define NAV_AGENT_CONTROL_BAND_FOLLOWER_H_

#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/elastic_band.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/control/local_search.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/control/path_progress.h"
#include "nav_agent/control/track_point.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::control {

struct BandFollowerOptions {
  ElasticBandOptions band;
  LocalSearchOptions search;
  // The band follows the next metres of the path, as long as they are in the
  // costmap's window, this far from its edge: half of the robot, with what the
  // guard keeps to what it sees (m).
  double horizon_m = kHorizon_m;
  double inset_m = core::RobotModel().half_width_m + kPointMargin_m;
  // New bubbles on the path are this far apart (m).
  double spacing_m = kFourCells_m;
  // A place on the path is taken if its footprint has less room (m).
  double room_m = kFreeRoom_m;
  // So far aside a way is looked for past what stands at the path's last
  // sight: past what is as wide as the robot, which goes beside it (m).
  double aside_m = 4 * core::RobotModel().half_width_m;
  // A robot that is further off has left its band (m).
  double lost_band_m = kLostBand_m;
  // What a metre of path that is left out costs the search for a way around:
  // it may come back to the path late, but not for nothing.
  double skip_cost = kSkipCost;

  // For a robot, whose band keeps inflation_m beside it where there is room.
  static BandFollowerOptions For(const core::RobotModel& robot,
                                 double inflation_m);
};

// The line to drive along, from the robot on.
struct BandTrack {
  std::vector<TrackPoint> points;
  bool ends_at_goal = false;
  // Where the way ends that should go on.
  std::optional<geometry::Vec2> broken_at;
};

// Not thread-safe.
class BandFollower {
 public:
  BandFollower(std::shared_ptr<const traversability::NavigationMap> map,
               const BandFollowerOptions& options)
      : map_(std::move(map)), options_(options), band_(options.band) {}

  void SetPath(const std::vector<core::LevelPose>& path);
  const PathProgress& progress() const { return progress_; }
  const std::vector<BandBubble>& bubbles() const { return band_.bubbles(); }

  // The robot is here, and this is around it.
  BandTrack Update(const core::LevelPose& pose, const LocalCostmap& costmap);
  // How often a band was mended by a search.
  int mended() const { return mended_; }

 private:
  // A place on the path.
  struct Stop {
    double along_m = 0;
    geometry::Rigid2 map_from_base;
    bool is_free = false;
  };

  std::vector<Stop> StopsAhead(const LocalCostmap& costmap) const;
  void Renew(const core::LevelPose& pose, const std::vector<Stop>& stops);
  void CarryOn(const std::vector<Stop>& stops);
  bool Mend(const core::LevelPose& pose, const std::vector<Stop>& stops,
            const LocalCostmap& costmap);
  BandTrack TrackOf(size_t whole_bubbles, const LocalCostmap& costmap) const;

  std::shared_ptr<const traversability::NavigationMap> map_;
  BandFollowerOptions options_;
  PathProgress progress_;
  ElasticBand band_;
  // Of the band's last bubble, along the path.
  double end_along_m_ = 0;
  int rest_ = 0;
  int mended_ = 0;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_BAND_FOLLOWER_H_
