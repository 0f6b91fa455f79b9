// Requests of browsers to an agent as arbitrary bytes: no crash, and what is
// accepted is finite and within its bounds.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "nav_agent/service/api_request.h"

namespace {

void Check(bool holds) {
  if (!holds) std::abort();
}

void CheckPose(const treeline::agent_service::RequestedPose& pose) {
  Check(std::isfinite(pose.x_m) && std::isfinite(pose.y_m) &&
        std::isfinite(pose.yaw_rad) && pose.level >= 0);
}

void CheckRefusal(const absl::Status& status) {
  Check(absl::IsInvalidArgument(status) && !status.message().empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view body(reinterpret_cast<const char*>(data), size);
  if (const auto poses = treeline::agent_service::ParseGoalRequest(body);
      poses.ok()) {
    Check(!poses->empty() &&
          poses->size() <= treeline::agent_service::kMaxGoalPoses);
    for (const treeline::agent_service::RequestedPose& pose : *poses)
      CheckPose(pose);
  } else {
    CheckRefusal(poses.status());
  }
  if (const auto pose = treeline::agent_service::ParseInitialPoseRequest(body);
      pose.ok()) {
    CheckPose(pose->pose);
    Check(std::isfinite(pose->std_m) && std::isfinite(pose->std_rad));
  }
  if (const auto kidnap = treeline::agent_service::ParseKidnapRequest(body);
      kidnap.ok()) {
    Check(!kidnap->pose.has_value() || !kidnap->place.has_value());
    if (kidnap->pose.has_value()) CheckPose(*kidnap->pose);
  }
  if (const auto obstacle = treeline::agent_service::ParseObstacleRequest(body);
      obstacle.ok()) {
    CheckPose(obstacle->pose);
    Check(std::isfinite(obstacle->size_m));
  }
  if (const auto fault = treeline::agent_service::ParseFaultRequest(body);
      fault.ok()) {
    Check(fault->duration_s >= 0 && std::isfinite(fault->amount));
  }
  treeline::agent_service::ParseEmptyRequest(body).IgnoreError();
  treeline::agent_service::ParseNameRequest(body).status().IgnoreError();
  return 0;
}
