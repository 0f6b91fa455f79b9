#include "nav_agent/service/api_request.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"

namespace treeline::agent_service {
namespace {

using Json = nlohmann::json;

// Names of places, obstacles and faults are short.
constexpr size_t kMaxName = 200;

absl::Status Bad(const std::string& field, absl::string_view problem) {
  return absl::InvalidArgumentError(absl::StrCat(field, ": ", problem));
}

absl::Status CheckFields(const Json& object, const std::string& where,
                         std::initializer_list<const char*> known) {
  if (!object.is_object()) return Bad(where, "is not an object");
  for (const auto& [name, value] : object.items()) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      return Bad(where,
                 absl::StrCat("has a field that is not known; there are ",
                              absl::StrJoin(known, ", ")));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<Json> ParseObject(absl::string_view body,
                                 std::initializer_list<const char*> known) {
  Json json = Json::parse(body.begin(), body.end(), nullptr,
                          /*allow_exceptions=*/false);
  if (json.is_discarded()) return Bad("the body", "is not JSON");
  TL_RETURN_IF_ERROR(CheckFields(json, "the body", known));
  return json;
}

// `value` keeps what it has if there is no such field.
absl::Status ReadNumber(const Json& object, const char* name,
                        const std::string& where, double& value) {
  const auto field = object.find(name);
  if (field == object.end()) return absl::OkStatus();
  const std::string path = absl::StrCat(where, name);
  if (!field->is_number()) return Bad(path, "is not a number");
  value = field->get<double>();
  if (!std::isfinite(value)) return Bad(path, "is not finite");
  return absl::OkStatus();
}

absl::Status ReadLevel(const Json& object, const std::string& where,
                       int& level) {
  const auto field = object.find("level");
  if (field == object.end()) return absl::OkStatus();
  if (!field->is_number_integer()) {
    return Bad(where + "level", "is not a whole number");
  }
  constexpr int64_t kHighest = 1000;
  if (field->is_number_unsigned() &&
      field->get<uint64_t>() > static_cast<uint64_t>(kHighest)) {
    return Bad(where + "level", "is above 1000");
  }
  const auto value = field->get<int64_t>();
  if (value < 0) return Bad(where + "level", "is below 0");
  level = static_cast<int>(value);
  return absl::OkStatus();
}

absl::Status ReadText(const Json& object, const char* name,
                      std::string& value) {
  const auto field = object.find(name);
  if (field == object.end()) return absl::OkStatus();
  if (!field->is_string()) return Bad(name, "is not a text");
  value = field->get<std::string>();
  if (value.size() > kMaxName) return Bad(name, "is too long");
  return absl::OkStatus();
}

absl::Status Need(const Json& object, const char* name,
                  const std::string& where) {
  if (object.contains(name)) return absl::OkStatus();
  return Bad(where + name, "is missing");
}

absl::StatusOr<RequestedPose> ReadPose(const Json& object,
                                       const std::string& where) {
  RequestedPose pose;
  TL_RETURN_IF_ERROR(Need(object, "x", where));
  TL_RETURN_IF_ERROR(Need(object, "y", where));
  TL_RETURN_IF_ERROR(ReadNumber(object, "x", where, pose.x_m));
  TL_RETURN_IF_ERROR(ReadNumber(object, "y", where, pose.y_m));
  TL_RETURN_IF_ERROR(ReadNumber(object, "yaw", where, pose.yaw_rad));
  TL_RETURN_IF_ERROR(ReadLevel(object, where, pose.level));
  return pose;
}

}  // namespace

absl::StatusOr<std::vector<RequestedPose>> ParseGoalRequest(
    absl::string_view body) {
  TL_ASSIGN_OR_RETURN(const Json json, ParseObject(body, {"poses"}));
  TL_RETURN_IF_ERROR(Need(json, "poses", ""));
  const Json& list = json["poses"];
  if (!list.is_array()) return Bad("poses", "is not a list");
  if (list.empty()) return Bad("poses", "is empty");
  if (list.size() > kMaxGoalPoses) {
    return Bad("poses", absl::StrCat("has more than ", kMaxGoalPoses));
  }
  std::vector<RequestedPose> poses;
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string where = absl::StrCat("poses[", i, "]");
    TL_RETURN_IF_ERROR(CheckFields(list[i], where, {"x", "y", "yaw", "level"}));
    TL_ASSIGN_OR_RETURN(const RequestedPose pose,
                        ReadPose(list[i], where + "."));
    poses.push_back(pose);
  }
  return poses;
}

absl::Status ParseEmptyRequest(absl::string_view body) {
  if (body.empty()) return absl::OkStatus();
  return ParseObject(body, {}).status();
}

absl::StatusOr<InitialPoseRequest> ParseInitialPoseRequest(
    absl::string_view body) {
  TL_ASSIGN_OR_RETURN(
      const Json json,
      ParseObject(body, {"x", "y", "yaw", "level", "std_m", "std_rad"}));
  InitialPoseRequest request;
  TL_ASSIGN_OR_RETURN(request.pose, ReadPose(json, ""));
  TL_RETURN_IF_ERROR(ReadNumber(json, "std_m", "", request.std_m));
  TL_RETURN_IF_ERROR(ReadNumber(json, "std_rad", "", request.std_rad));
  return request;
}

absl::StatusOr<KidnapRequest> ParseKidnapRequest(absl::string_view body) {
  TL_ASSIGN_OR_RETURN(const Json json,
                      ParseObject(body, {"x", "y", "yaw", "level", "place"}));
  KidnapRequest request;
  if (json.contains("place")) {
    if (json.size() > 1) return Bad("place", "comes with a pose: give one");
    TL_RETURN_IF_ERROR(ReadText(json, "place", request.place.emplace()));
  } else if (!json.empty()) {
    TL_ASSIGN_OR_RETURN(request.pose, ReadPose(json, ""));
  }
  return request;
}

absl::StatusOr<ObstacleRequest> ParseObstacleRequest(absl::string_view body) {
  TL_ASSIGN_OR_RETURN(const Json json,
                      ParseObject(body, {"x", "y", "yaw", "level", "size_m"}));
  ObstacleRequest request;
  TL_ASSIGN_OR_RETURN(request.pose, ReadPose(json, ""));
  TL_RETURN_IF_ERROR(ReadNumber(json, "size_m", "", request.size_m));
  return request;
}

absl::StatusOr<std::string> ParseNameRequest(absl::string_view body) {
  TL_ASSIGN_OR_RETURN(const Json json, ParseObject(body, {"name"}));
  TL_RETURN_IF_ERROR(Need(json, "name", ""));
  std::string name;
  TL_RETURN_IF_ERROR(ReadText(json, "name", name));
  return name;
}

absl::StatusOr<RequestedFault> ParseFaultRequest(absl::string_view body) {
  TL_ASSIGN_OR_RETURN(
      const Json json,
      ParseObject(body, {"target", "kind", "duration_s", "amount"}));
  TL_RETURN_IF_ERROR(Need(json, "target", ""));
  TL_RETURN_IF_ERROR(Need(json, "kind", ""));
  RequestedFault fault;
  TL_RETURN_IF_ERROR(ReadText(json, "target", fault.target));
  TL_RETURN_IF_ERROR(ReadText(json, "kind", fault.kind));
  TL_RETURN_IF_ERROR(ReadNumber(json, "duration_s", "", fault.duration_s));
  TL_RETURN_IF_ERROR(ReadNumber(json, "amount", "", fault.amount));
  if (fault.duration_s < 0 || fault.duration_s > 1e6) {
    return Bad("duration_s", "must be 0..1000000");
  }
  return fault;
}

}  // namespace treeline::agent_service
