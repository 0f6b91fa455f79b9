#include "server/tools/evaluation_json.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"
#include "nlohmann/json.hpp"
#include "server/core/forest/model_info_json.h"

namespace treeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegreesPerRadian = 57.29577951308232;

Json Text(absl::string_view text) { return std::string(text); }

Json Number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json Number(const std::optional<double>& value) {
  return value.has_value() ? Number(*value) : Json(nullptr);
}

Json Vector(Vec3 v) { return {Number(v.x), Number(v.y), Number(v.z)}; }

Json Pose(const Rigid3& pose) {
  const Rotation3& q = pose.rotation;
  const Vec3& t = pose.translation;
  return {{"qw", Number(q.w)}, {"qx", Number(q.x)}, {"qy", Number(q.y)},
          {"qz", Number(q.z)}, {"tx", Number(t.x)}, {"ty", Number(t.y)},
          {"tz", Number(t.z)}};
}

Json PercentilesJson(const std::optional<Percentiles>& values) {
  if (!values) return {{"p50", nullptr}, {"p95", nullptr}, {"p99", nullptr}};
  return {{"p50", Number(values->p50)},
          {"p95", Number(values->p95)},
          {"p99", Number(values->p99)}};
}

// The keys of a frame's answer, null where there was none.
void AddEstimate(const FrameResult& result, Json& json) {
  const PoseEstimate& estimate = result.estimate;
  const bool answered = result.status.ok();
  if (!answered) {
    json["outcome"] = "ERROR";
    json["reason"] = Text(result.status.message());
    for (const char* key :
         {"inliers", "samples", "inlier_ratio", "confidence", "evidence"}) {
      json[key] = nullptr;
    }
  } else {
    json["outcome"] = Text(OutcomeName(estimate.outcome));
    json["reason"] =
        result.localized() ? Json(nullptr) : Text(ReasonName(estimate.reason));
    json["inliers"] = estimate.inliers;
    json["samples"] = estimate.samples;
    json["inlier_ratio"] = Number(estimate.inlier_ratio);
    json["confidence"] = Number(estimate.confidence);
    const PoseEvidence& evidence = estimate.evidence;
    json["evidence"] = {{"inlier_ratio", Number(evidence.inlier_ratio)},
                        {"correlation", Number(evidence.correlation)},
                        {"agreement", Number(evidence.agreement)},
                        {"visible", evidence.visible},
                        {"overlap", Number(evidence.overlap)},
                        {"depth_agreement", Number(evidence.depth_agreement)},
                        {"moved_m", Number(evidence.moved_m)}};
  }
  json["world_from_camera"] =
      result.localized() ? Pose(estimate.world_from_camera) : Json(nullptr);
}

Json Stages(const FrameResult& result) {
  if (!result.status.ok()) return nullptr;
  const LocalizeTimings& timings = result.estimate.timings;
  return {{"sample_ms", Number(timings.sample_ms)},
          {"forest_ms", Number(timings.forest_ms)},
          {"pose_ms", Number(timings.pose_ms)},
          {"total_ms", Number(timings.total_ms)}};
}

Json PerFrame(const FrameResult& result) {
  Json json{{"stem", Text(result.stem)}};
  AddEstimate(result, json);
  json["true_world_from_camera"] = result.true_world_from_camera
                                       ? Pose(*result.true_world_from_camera)
                                       : Json(nullptr);
  json["translation_error_m"] =
      result.error ? Number(result.error->translation_m) : Json(nullptr);
  json["rotation_error_deg"] =
      result.error ? Number(result.error->rotation_rad * kDegreesPerRadian)
                   : Json(nullptr);
  json["latency_ms"] = Number(result.latency_ms);
  json["cpu_ms"] = Number(result.cpu_ms);
  json["decode_ms"] = Number(result.decode_ms);
  json["stages"] = Stages(result);
  return json;
}

// What the trainer stated, and what the file itself tells.
Json ModelJson(const ModelInfo& model) {
  Json json = Json::parse(ModelInfoToJson(model));
  json["format_version"] = model.format_version;
  json["bounds_min_in_world"] = Vector(model.bounds_min_in_world);
  json["bounds_max_in_world"] = Vector(model.bounds_max_in_world);
  json["trees"] = model.trees;
  json["nodes"] = model.nodes;
  json["leaves"] = model.leaves;
  json["file_bytes"] = model.file_bytes;
  json["checksum"] = Text(model.checksum);
  return json;
}

// Names from files may hold any bytes; JSON holds UTF-8 alone.
std::string Serialized(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json OrNull(const std::string& text) {
  return text.empty() ? Json(nullptr) : Text(text);
}

}  // namespace

std::string EvaluationJson(const std::vector<FrameResult>& results,
                           const EvaluationRun& run, const ModelInfo& model) {
  const EvaluationSummary summary = Summarize(results);
  Json json{
      {"frames", summary.frames},
      {"scored", summary.scored},
      {"localized", summary.localized},
      {"errors", summary.errors},
      {"correct_5cm_5deg", Number(summary.correct_5cm_5deg)},
      {"correct_2cm_2deg", Number(summary.correct_2cm_2deg)},
      {"median_translation_m", Number(summary.median_translation_m)},
      {"median_rotation_deg", Number(summary.median_rotation_deg)},
      {"latency_ms", PercentilesJson(summary.latency_ms)},
      {"cpu_ms", PercentilesJson(summary.cpu_ms)},
      {"decode_ms", PercentilesJson(summary.decode_ms)},
      {"model_bytes", model.file_bytes},
      {"method", Text(model.method)},
      {"seed", run.seed},
      {"threads", run.threads},
      {"cpu", Text(run.cpu)},
      {"software_version", Text(run.software_version)},
      {"peak_memory_bytes", run.peak_memory_bytes},
      {"started_utc", Text(run.started_utc)},
      {"command", Text(run.command)},
      {"dataset", Text(run.dataset_uri)},
      {"frame_list", OrNull(run.frame_list)},
      {"pose_file", OrNull(run.pose_file)},
      {"model_path", OrNull(run.model_path)},
      {"model", ModelJson(model)},
  };
  Json frames = Json::array();
  for (const FrameResult& result : results) frames.push_back(PerFrame(result));
  json["per_frame"] = std::move(frames);
  return Serialized(json);
}

std::string ModelInfoJson(const ModelInfo& model) {
  return Serialized(ModelJson(model));
}

}  // namespace treeline
