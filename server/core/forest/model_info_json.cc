#include "server/core/forest/model_info_json.h"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline {
namespace {

using Json = nlohmann::ordered_json;

Json CameraToJson(const Camera& camera) {
  return {{"width", camera.width()},
          {"height", camera.height()},
          {"model", camera.ToString()}};
}

Json CalibrationToJsonValue(const RgbdCalibration& calibration) {
  const Rotation3& q = calibration.color_from_depth.rotation;
  const Vec3& t = calibration.color_from_depth.translation;
  return {{"color", CameraToJson(calibration.color)},
          {"depth", CameraToJson(calibration.depth)},
          {"color_from_depth",
           {{"qw", q.w},
            {"qx", q.x},
            {"qy", q.y},
            {"qz", q.z},
            {"tx_m", t.x},
            {"ty_m", t.y},
            {"tz_m", t.z}}},
          {"depth_scale", calibration.depth_scale},
          {"pose_sensor",
           calibration.pose_sensor == RgbdSensor::kColor ? "color" : "depth"}};
}

absl::StatusOr<Camera> CameraFromJson(const Json& json) {
  return Camera::Parse(json.at("model").get<std::string>(),
                       json.at("width").get<int>(),
                       json.at("height").get<int>());
}

absl::StatusOr<RgbdCalibration> CalibrationFromJsonValue(const Json& json) {
  RgbdCalibration calibration;
  TL_ASSIGN_OR_RETURN(calibration.color, CameraFromJson(json.at("color")));
  TL_ASSIGN_OR_RETURN(calibration.depth, CameraFromJson(json.at("depth")));
  const Json& pose = json.at("color_from_depth");
  TL_ASSIGN_OR_RETURN(
      calibration.color_from_depth,
      RigidFromQuaternion(
          pose.at("qw").get<double>(), pose.at("qx").get<double>(),
          pose.at("qy").get<double>(), pose.at("qz").get<double>(),
          {pose.at("tx_m").get<double>(), pose.at("ty_m").get<double>(),
           pose.at("tz_m").get<double>()}));
  calibration.depth_scale = json.at("depth_scale").get<double>();
  if (!(calibration.depth_scale >= 0.5 && calibration.depth_scale <= 2)) {
    return absl::InvalidArgumentError(
        absl::StrCat("depth_scale is ", calibration.depth_scale,
                     "; it must be between 0.5 and 2"));
  }
  const std::string sensor = json.at("pose_sensor").get<std::string>();
  if (sensor != "color" && sensor != "depth") {
    return absl::InvalidArgumentError(absl::StrCat(
        "pose_sensor is \"", sensor, "\"; it must be \"color\" or \"depth\""));
  }
  calibration.pose_sensor =
      sensor == "color" ? RgbdSensor::kColor : RgbdSensor::kDepth;
  return calibration;
}

Json ConfidenceToJson(const ConfidenceModel& confidence) {
  Json json = {{"threshold", confidence.threshold}};
  for (size_t i = 0; i < ConfidenceModel::kFeatures; ++i) {
    json["weights"][std::string(ConfidenceModel::FeatureNames()[i])] =
        confidence.weights[i];
  }
  return json;
}

ConfidenceModel ConfidenceFromJson(const Json& json) {
  ConfidenceModel confidence;
  confidence.threshold = json.at("threshold").get<double>();
  for (size_t i = 0; i < ConfidenceModel::kFeatures; ++i) {
    confidence.weights[i] =
        json.at("weights")
            .at(std::string(ConfidenceModel::FeatureNames()[i]))
            .get<double>();
  }
  return confidence;
}

// Runs `parse` on the parsed text; nlohmann's exceptions become `code`.
template <typename T, typename Parse>
absl::StatusOr<T> ParseJson(absl::string_view text, absl::StatusCode code,
                            const Parse& parse) {
  try {
    return parse(Json::parse(text.begin(), text.end()));
  } catch (const std::exception& error) {
    return absl::Status(code, error.what());
  }
}

}  // namespace

std::string ModelInfoToJson(const ModelInfo& info) {
  Json options = Json::object();
  for (const auto& [name, value] : info.options) options[name] = value;
  Json json = {{"method", info.method},
               {"software_version", info.software_version},
               {"created_utc", info.created_utc},
               {"dataset", info.dataset},
               {"seed", info.seed},
               {"options", options},
               {"calibration", CalibrationToJsonValue(info.calibration)},
               {"world",
                {{"units_are_metres", info.units_are_metres},
                 {"viewing_distance", info.viewing_distance}}},
               {"training",
                {{"frames", info.training_frames},
                 {"samples", info.training_samples},
                 {"seconds", info.training_s}}}};
  if (info.confidence) json["confidence"] = ConfidenceToJson(*info.confidence);
  // Names from the command line may hold anything: never throw over them.
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

absl::StatusOr<ModelInfo> ModelInfoFromJson(absl::string_view json) {
  absl::StatusOr<ModelInfo> parsed = ParseJson<ModelInfo>(
      json, absl::StatusCode::kDataLoss,
      [](const Json& root) -> absl::StatusOr<ModelInfo> {
        ModelInfo info;
        info.method = root.at("method").get<std::string>();
        info.software_version = root.at("software_version").get<std::string>();
        info.created_utc = root.at("created_utc").get<std::string>();
        info.dataset = root.at("dataset").get<std::string>();
        info.seed = root.at("seed").get<uint64_t>();
        for (const auto& [name, value] : root.at("options").items()) {
          info.options.emplace_back(name, value.get<std::string>());
        }
        TL_ASSIGN_OR_RETURN(info.calibration,
                            CalibrationFromJsonValue(root.at("calibration")));
        if (root.contains("confidence")) {
          info.confidence = ConfidenceFromJson(root.at("confidence"));
        }
        // Absent in files of earlier versions.
        if (root.contains("world")) {
          const Json& world = root.at("world");
          info.units_are_metres = world.at("units_are_metres").get<bool>();
          info.viewing_distance = world.at("viewing_distance").get<double>();
          if (!(info.viewing_distance >= 0 && info.viewing_distance < 1e9)) {
            return absl::DataLossError("viewing_distance is no distance");
          }
        }
        const Json& training = root.at("training");
        info.training_frames = training.at("frames").get<int>();
        info.training_samples = training.at("samples").get<int64_t>();
        info.training_s = training.at("seconds").get<double>();
        return info;
      });
  if (parsed.ok()) return parsed;
  return absl::DataLossError(absl::StrCat("corrupt model: its information: ",
                                          parsed.status().message()));
}

std::string CalibrationToJson(const RgbdCalibration& calibration) {
  return CalibrationToJsonValue(calibration).dump(2) + "\n";
}

absl::StatusOr<RgbdCalibration> CalibrationFromJson(absl::string_view json) {
  return ParseJson<RgbdCalibration>(
      json, absl::StatusCode::kInvalidArgument,
      [](const Json& root) { return CalibrationFromJsonValue(root); });
}

}  // namespace treeline
