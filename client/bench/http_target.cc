#include "client/bench/http_target.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/camera/camera.h"
#include "common/image/decode.h"
#include "common/wire/status.h"
#include "google/rpc/status.pb.h"
#include "nlohmann/json.hpp"

namespace treeline::bench {
namespace {

using Json = nlohmann::json;

constexpr double kMillimetre_m = 0.001;
// The GeoPose Protocol's "no pose", with a reason why.
constexpr long kUnprocessable = 422;

struct TargetFacts {
  const char* name;
  const char* path;
  const char* content_type;
  const char* accept;
};

// In the order of Target.
constexpr char kLocalizePath[] = "/treeline.v1.RelocalizationService/Localize";
constexpr std::array<TargetFacts, 4> kTargets = {{
    {"grpc", "", "", ""},
    {"connect", kLocalizePath, "application/proto", "application/proto"},
    {"connect-json", kLocalizePath, "application/json", "application/json"},
    {"geopose", "/geopose", "application/json",
     "application/vnd.oscp+json;version=2.0"},
}};

const TargetFacts& FactsOf(Target target) {
  return kTargets[static_cast<size_t>(target)];
}

absl::Status NotSaid(absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("the GeoPose Protocol has no way to say it: ", what));
}

std::string BytesOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string bytes;
  if (!buffer.Dump(&slices).ok()) return bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

// COLMAP's, whose first pixel has its centre at (0.5, 0.5).
absl::StatusOr<Json> CameraParams(const v1::Camera& camera) {
  TL_ASSIGN_OR_RETURN(const camera::CameraModel model,
                      camera::ParseCameraModel(camera.model()));
  std::vector<double> parameters(camera.parameters().begin(),
                                 camera.parameters().end());
  const auto at = static_cast<size_t>(camera::CameraPrincipalPointIndex(model));
  if (parameters.size() < at + 2) {
    return absl::InvalidArgumentError("the camera has too few parameters");
  }
  parameters[at] += 0.5;
  parameters[at + 1] += 0.5;
  return Json{{"model", camera.model()}, {"modelParams", parameters}};
}

absl::StatusOr<Json> CameraReading(const char* sensor, const char* format,
                                   const std::string& bytes) {
  TL_ASSIGN_OR_RETURN(const image::ImageSize size,
                      image::ReadImageSize(bytes, {}));
  return Json{{"timestamp", 0},
              {"sensorId", sensor},
              {"sequenceNumber", 0},
              {"imageFormat", format},
              {"size", {size.width, size.height}},
              {"imageBytes", absl::Base64Escape(bytes)}};
}

absl::StatusOr<std::string> GeoPoseBody(const v1::LocalizeRequest& request) {
  const v1::Frame& frame = request.frame();
  if (!frame.color().has_encoded()) return NotSaid("raw colour");
  TL_ASSIGN_OR_RETURN(Json color,
                      CameraReading("color", "JPG", frame.color().encoded()));
  if (frame.has_camera()) {
    TL_ASSIGN_OR_RETURN(color["params"], CameraParams(frame.camera()));
  }
  Json readings = Json::array({std::move(color)});
  Json sensors = {{{"id", "color"}, {"type", "camera"}}};
  if (frame.has_depth()) {
    const v1::DepthImage& depth = frame.depth();
    if (depth.data_case() != v1::DepthImage::kPng) return NotSaid("raw depth");
    if (std::abs(depth.unit_m() - kMillimetre_m) > 1e-12) {
      return NotSaid("depth that is not in millimetres");
    }
    const bool registered =
        depth.registration() == v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR;
    if (registered != frame.has_camera()) {
      return NotSaid(
          "depth is registered exactly if the camera is stated (--registered "
          "goes with --camera)");
    }
    TL_ASSIGN_OR_RETURN(Json reading,
                        CameraReading("depth", "DEPTH", depth.png()));
    readings.push_back(std::move(reading));
    sensors.push_back({{"id", "depth"}, {"type", "camera"}});
  }
  const Json body = {{"id", "bench"},
                     {"timestamp", 0},
                     {"type", "geopose"},
                     {"sensors", std::move(sensors)},
                     {"sensorReadings", {{"cameraReadings", readings}}}};
  return body.dump();
}

absl::StatusCode CodeOf(const std::string& name) {
  // The Connect protocol's names, by the numbers of google.rpc.Code.
  static constexpr std::array<const char*, 17> kNames = {"ok",
                                                         "canceled",
                                                         "unknown",
                                                         "invalid_argument",
                                                         "deadline_exceeded",
                                                         "not_found",
                                                         "already_exists",
                                                         "permission_denied",
                                                         "resource_exhausted",
                                                         "failed_precondition",
                                                         "aborted",
                                                         "out_of_range",
                                                         "unimplemented",
                                                         "internal",
                                                         "unavailable",
                                                         "data_loss",
                                                         "unauthenticated"};
  const auto* const found = std::find(kNames.begin(), kNames.end(), name);
  return found == kNames.end()
             ? absl::StatusCode::kUnknown
             : static_cast<absl::StatusCode>(found - kNames.begin());
}

std::string StringOf(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>()
                                                   : std::string();
}

// {code, message, details: [{type, value}]}.
absl::Status ParseError(long http_status, const std::string& body) {
  const Json json = Json::parse(body, nullptr, false);
  const std::string code = json.is_object() ? StringOf(json, "code") : "";
  if (code.empty()) {
    return absl::UnknownError(absl::StrCat("HTTP status ", http_status,
                                           " without an error of Treeline's"));
  }
  google::rpc::Status error;
  error.set_code(static_cast<int>(CodeOf(code)));
  error.set_message(StringOf(json, "message"));
  const auto details = json.find("details");
  if (details != json.end() && details->is_array()) {
    for (const Json& detail : *details) {
      std::string value;
      if (!detail.is_object() ||
          !absl::Base64Unescape(StringOf(detail, "value"), &value)) {
        continue;
      }
      google::protobuf::Any& any = *error.add_details();
      any.set_type_url(
          absl::StrCat("type.googleapis.com/", StringOf(detail, "type")));
      any.set_value(std::move(value));
    }
  }
  return wire::FromProto(error);
}

double NumberOf(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>()
                                                   : std::nan("");
}

absl::StatusOr<v1::LocalizeResponse> ParseGeoPose(const std::string& body) {
  const Json json = Json::parse(body, nullptr, false);
  const auto part = [](const Json& of, const char* key) {
    return of.is_object() ? of.value(key, Json::object()) : Json::object();
  };
  const Json pose = part(json, "geopose");
  const Json position = part(pose, "position");
  const Json quaternion = part(pose, "quaternion");
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_LOCALIZED);
  v1::Vector3& at =
      *response.mutable_world_from_camera()->mutable_translation_m();
  at.set_x(NumberOf(position, "lat"));
  at.set_y(NumberOf(position, "lon"));
  at.set_z(NumberOf(position, "h"));
  v1::Quaternion& rotation =
      *response.mutable_world_from_camera()->mutable_rotation();
  rotation.set_w(NumberOf(quaternion, "w"));
  rotation.set_x(NumberOf(quaternion, "x"));
  rotation.set_y(NumberOf(quaternion, "y"));
  rotation.set_z(NumberOf(quaternion, "z"));
  for (const double value : {at.x(), at.y(), at.z(), rotation.w(), rotation.x(),
                             rotation.y(), rotation.z()}) {
    if (!std::isfinite(value)) {
      return absl::UnknownError("the answer is no GeoPose");
    }
  }
  return response;
}

// "Not localized" travels as an error there; whether it is one.
absl::StatusOr<v1::LocalizeResponse> GeoPoseOfError(long http_status,
                                                    absl::Status error) {
  const std::string reason = base::ErrorInfoOf(error).reason;
  v1::NotLocalizedReason why = v1::NOT_LOCALIZED_REASON_UNSPECIFIED;
  if (http_status != kUnprocessable ||
      !v1::NotLocalizedReason_Parse(
          absl::StrCat("NOT_LOCALIZED_REASON_", reason), &why)) {
    return error;
  }
  v1::LocalizeResponse response;
  response.set_outcome(v1::OUTCOME_NOT_LOCALIZED);
  response.set_reason(why);
  return response;
}

}  // namespace

absl::StatusOr<Target> ParseTarget(absl::string_view name) {
  for (size_t i = 0; i < kTargets.size(); ++i) {
    if (name == kTargets[i].name) return static_cast<Target>(i);
  }
  return absl::InvalidArgumentError(
      absl::StrCat("no target \"", name,
                   "\": there are grpc, connect, connect-json and geopose"));
}

const char* Name(Target target) { return FactsOf(target).name; }
const char* PathOf(Target target) { return FactsOf(target).path; }
const char* ContentTypeOf(Target target) {
  return FactsOf(target).content_type;
}
const char* AcceptOf(Target target) { return FactsOf(target).accept; }

absl::StatusOr<std::string> HttpBody(Target target, const WorkItem& item) {
  std::string bytes = BytesOf(item.request);
  if (target == Target::kConnect) return bytes;
  v1::LocalizeRequest request;
  if (!request.ParseFromString(bytes)) {
    return absl::InternalError("a query does not parse");
  }
  if (target == Target::kGeoPose) {
    absl::StatusOr<std::string> body = GeoPoseBody(request);
    if (!body.ok()) return base::Annotate(body.status(), item.stem);
    return body;
  }
  std::string json;
  if (!google::protobuf::util::MessageToJsonString(request, &json).ok()) {
    return absl::InternalError("a query does not become JSON");
  }
  return json;
}

absl::StatusOr<v1::LocalizeResponse> ParseHttpAnswer(Target target,
                                                     long http_status,
                                                     const std::string& body) {
  if (http_status != 200) {
    absl::Status error = ParseError(http_status, body);
    if (target == Target::kGeoPose) {
      return GeoPoseOfError(http_status, std::move(error));
    }
    return error;
  }
  if (target == Target::kGeoPose) return ParseGeoPose(body);
  v1::LocalizeResponse response;
  const bool parsed =
      target == Target::kConnect
          ? response.ParseFromString(body)
          : google::protobuf::util::JsonStringToMessage(body, &response).ok();
  if (!parsed) return absl::UnknownError("the answer is no LocalizeResponse");
  return response;
}

}  // namespace treeline::bench
