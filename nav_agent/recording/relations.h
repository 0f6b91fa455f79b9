// Reference relative poses of the SLAM benchmark.
#ifndef NAV_AGENT_RECORDING_RELATIONS_H_
#define NAV_AGENT_RECORDING_RELATIONS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/recording/recording_time.h"

namespace treeline::recording {

// Where the robot was at `to`, as seen from where it was at `from`. Height,
// roll and pitch of the files are read over: they are 0 in those of robots on
// a floor.
struct PoseRelation {
  RecordingTime from;
  RecordingTime to;
  geometry::Rigid2 from_base_from_to_base;
};

// Lines "t1 t2 x y z roll pitch yaw" (s, m, rad), as R. Kuemmerle and others
// publish them; empty lines and those that begin with # are passed over.
// INVALID_ARGUMENT with `name` and line.
absl::StatusOr<std::vector<PoseRelation>> ParseRelations(
    absl::string_view text, const std::string& name);
absl::StatusOr<std::vector<PoseRelation>> ReadRelations(
    const std::string& path);

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_RELATIONS_H_
