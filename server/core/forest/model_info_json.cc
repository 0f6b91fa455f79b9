#include "server/core/forest/model_info_json.h"

#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"

namespace treeline::forest {
namespace {

using Json = nlohmann::ordered_json;

Json ConfidenceToJson(const ConfidenceModel& confidence) {
  Json json = {{"threshold", confidence.threshold}};
  if (confidence.focal_sigma_scale != 1) {
    json["focal_sigma_scale"] = confidence.focal_sigma_scale;
  }
  for (size_t i = 0; i < ConfidenceModel::kFeatures; ++i) {
    json["weights"][std::string(ConfidenceModel::FeatureNames()[i])] =
        confidence.weights[i];
  }
  return json;
}

// Of the evidence, what every version knew.
constexpr size_t kFirstFeatures = 7;
constexpr double kMaxFocalSigmaScale = 1e6;

absl::StatusOr<ConfidenceModel> ConfidenceFromJson(const Json& json) {
  ConfidenceModel confidence;
  confidence.threshold = json.at("threshold").get<double>();
  // Earlier versions took features at their word.
  confidence.focal_sigma_scale = json.value("focal_sigma_scale", 1.0);
  if (!(confidence.focal_sigma_scale >= 1 &&
        confidence.focal_sigma_scale <= kMaxFocalSigmaScale)) {
    return absl::DataLossError("focal_sigma_scale is out of range");
  }
  for (size_t i = 0; i < ConfidenceModel::kFeatures; ++i) {
    const std::string name(ConfidenceModel::FeatureNames()[i]);
    const Json& weights = json.at("weights");
    // Earlier versions knew fewer kinds of evidence.
    confidence.weights[i] = i < kFirstFeatures ? weights.at(name).get<double>()
                                               : weights.value(name, 0.0);
  }
  return confidence;
}

constexpr const char* kFastSiftName = "fast";

absl::StatusOr<features::SiftKind> SiftKindFromName(const std::string& name) {
  if (name == kFastSiftName) return features::SiftKind::kFast;
  return absl::DataLossError(absl::StrCat(
      "keyframes have SIFT of a kind unknown to this version: ", name));
}

absl::StatusOr<image::RollingShutter> ShutterFromJson(const Json& json) {
  const image::RollingShutter shutter{
      .readout_s = json.at("readout_s").get<double>(),
      .offset_s = json.at("offset_s").get<double>()};
  if (!(shutter.readout_s >= 0 && shutter.readout_s <= image::kMaxReadout_s) ||
      !(std::abs(shutter.offset_s) <= image::kMaxShutterOffset_s)) {
    return absl::DataLossError("its shutter is out of range");
  }
  return shutter;
}

constexpr int kMaxTrees = 64;

absl::StatusOr<TreePartInfo> PartFromJson(const Json& json) {
  TreePartInfo part;
  part.tree = json.at("tree").get<int>();
  part.trees = json.at("trees").get<int>();
  part.frames_checksum = json.at("frames_checksum").get<std::string>();
  if (part.trees < 1 || part.trees > kMaxTrees || part.tree < 0 ||
      part.tree >= part.trees) {
    return absl::DataLossError("it is no part of a forest of 1 to 64 trees");
  }
  return part;
}

absl::StatusOr<ModelInfo> InfoFromJson(const Json& root) {
  ModelInfo info;
  info.method = root.at("method").get<std::string>();
  info.software_version = root.at("software_version").get<std::string>();
  info.created_utc = root.at("created_utc").get<std::string>();
  info.dataset = root.at("dataset").get<std::string>();
  info.seed = root.at("seed").get<uint64_t>();
  for (const auto& [name, value] : root.at("options").items()) {
    info.options.emplace_back(name, value.get<std::string>());
  }
  TL_ASSIGN_OR_RETURN(info.calibration, camera::CalibrationFromJson(
                                            root.at("calibration").dump()));
  if (root.contains("shutter")) {
    TL_ASSIGN_OR_RETURN(info.shutter, ShutterFromJson(root.at("shutter")));
  }
  if (root.contains("confidence")) {
    TL_ASSIGN_OR_RETURN(info.confidence,
                        ConfidenceFromJson(root.at("confidence")));
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
  if (root.contains("keyframes")) {
    TL_ASSIGN_OR_RETURN(
        info.keyframe_sift,
        SiftKindFromName(root.at("keyframes").at("sift").get<std::string>()));
  }
  if (root.contains("part")) {
    TL_ASSIGN_OR_RETURN(info.part, PartFromJson(root.at("part")));
  }
  const Json& training = root.at("training");
  info.training_frames = training.at("frames").get<int>();
  info.training_samples = training.at("samples").get<int64_t>();
  info.training_s = training.at("seconds").get<double>();
  return info;
}

}  // namespace

std::string ModelInfoToJson(const ModelInfo& info) {
  Json options = Json::object();
  for (const auto& [name, value] : info.options) options[name] = value;
  Json json = {
      {"method", info.method},
      {"software_version", info.software_version},
      {"created_utc", info.created_utc},
      {"dataset", info.dataset},
      {"seed", info.seed},
      {"options", options},
      {"calibration", Json::parse(camera::CalibrationToJson(info.calibration))},
      {"world",
       {{"units_are_metres", info.units_are_metres},
        {"viewing_distance", info.viewing_distance}}},
      {"training",
       {{"frames", info.training_frames},
        {"samples", info.training_samples},
        {"seconds", info.training_s}}}};
  if (info.keyframe_sift == features::SiftKind::kFast) {
    json["keyframes"] = {{"sift", kFastSiftName}};
  }
  if (info.shutter) {
    json["shutter"] = {{"readout_s", info.shutter->readout_s},
                       {"offset_s", info.shutter->offset_s}};
  }
  if (info.part) {
    json["part"] = {{"tree", info.part->tree},
                    {"trees", info.part->trees},
                    {"frames_checksum", info.part->frames_checksum}};
  }
  if (info.confidence) json["confidence"] = ConfidenceToJson(*info.confidence);
  // Names from the command line may hold anything: never throw over them.
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

absl::StatusOr<ModelInfo> ModelInfoFromJson(absl::string_view json) {
  absl::StatusOr<ModelInfo> parsed = absl::UnknownError("");
  try {
    parsed = InfoFromJson(Json::parse(json.begin(), json.end()));
  } catch (const std::exception& error) {
    parsed = absl::DataLossError(error.what());
  }
  if (parsed.ok()) return parsed;
  return absl::DataLossError(absl::StrCat("corrupt model: its information: ",
                                          parsed.status().message()));
}

}  // namespace treeline::forest
