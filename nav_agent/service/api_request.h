// What a browser asks for, as JSON. Safe on any bytes.
#ifndef NAV_AGENT_SERVICE_API_REQUEST_H_
#define NAV_AGENT_SERVICE_API_REQUEST_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/service/agent_commands.h"

namespace treeline::agent_service {

// All: INVALID_ARGUMENT names the field: not JSON, not an object, a field that
// is missing, of another type, not finite, or not known (and those that are).

// {"poses":[{"x","y","yaw","level"}]}; yaw and level are 0 if they are missing.
absl::StatusOr<std::vector<RequestedPose>> ParseGoalRequest(
    absl::string_view body);

// {} or an empty body.
absl::Status ParseEmptyRequest(absl::string_view body);

// {"x","y","yaw","level"} and {"std_m","std_rad"}, which have defaults.
struct InitialPoseRequest {
  RequestedPose pose;
  double std_m = 0.25;
  double std_rad = 0.2;
};
absl::StatusOr<InitialPoseRequest> ParseInitialPoseRequest(
    absl::string_view body);

// {"x","y","yaw","level"}, {"place"}, or {}: anywhere.
struct KidnapRequest {
  std::optional<RequestedPose> pose;
  std::optional<std::string> place;
};
absl::StatusOr<KidnapRequest> ParseKidnapRequest(absl::string_view body);

// {"x","y","level","size_m"}.
struct ObstacleRequest {
  RequestedPose pose;
  double size_m = 0.5;
};
absl::StatusOr<ObstacleRequest> ParseObstacleRequest(absl::string_view body);

// {"name"}.
absl::StatusOr<std::string> ParseNameRequest(absl::string_view body);

// {"target","kind","duration_s","amount"}.
absl::StatusOr<RequestedFault> ParseFaultRequest(absl::string_view body);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_API_REQUEST_H_
