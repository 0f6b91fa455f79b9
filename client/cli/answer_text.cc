#include "client/cli/answer_text.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/error_info.h"
#include "nlohmann/json.hpp"

namespace treeline::client_cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

Json PoseJson(const geometry::Rigid3& pose) {
  const geometry::Rotation3& q = pose.rotation;
  const geometry::Vec3& t = pose.translation;
  return {{"qw", q.w}, {"qx", q.x}, {"qy", q.y}, {"qz", q.z},
          {"tx", t.x}, {"ty", t.y}, {"tz", t.z}};
}

Json VectorJson(geometry::Vec3 v) { return {v.x, v.y, v.z}; }

Json TimingsJson(const relocalizer::ServerTimings& t) {
  return {{"queue_ms", t.queue_ms},       {"decode_ms", t.decode_ms},
          {"sample_ms", t.sample_ms},     {"forest_ms", t.forest_ms},
          {"pose_ms", t.pose_ms},         {"localize_ms", t.localize_ms},
          {"features_ms", t.features_ms}, {"verify_ms", t.verify_ms},
          {"total_ms", t.total_ms}};
}

Json CandidatesJson(
    const std::vector<relocalizer::SceneCandidate>& candidates) {
  Json list = Json::array();
  for (const relocalizer::SceneCandidate& candidate : candidates) {
    Json json = {{"scene", candidate.scene},
                 {"similarity", candidate.similarity},
                 {"tried", candidate.tried}};
    if (candidate.tried) {
      json["outcome"] = candidate.localized ? "LOCALIZED" : "NOT_LOCALIZED";
      json["confidence"] = candidate.confidence;
      json["inliers"] = candidate.inliers;
    }
    list.push_back(std::move(json));
  }
  return list;
}

const char* SensorName(camera::RgbdSensor sensor) {
  return sensor == camera::RgbdSensor::kColor ? "COLOR" : "DEPTH";
}

// Names of files may hold any bytes; JSON holds UTF-8 alone.
std::string Serialized(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json ModelJson(const relocalizer::ModelDescription& model) {
  return {{"method", model.method},
          {"dataset", model.dataset},
          {"created_utc", model.created_utc},
          {"software_version", model.software_version},
          {"checksum", model.checksum},
          {"color_camera", model.calibration.color.ToString()},
          {"depth_camera", model.calibration.depth.ToString()},
          {"color_from_depth", PoseJson(model.calibration.color_from_depth)},
          {"depth_scale", model.calibration.depth_scale},
          {"pose_sensor", SensorName(model.calibration.pose_sensor)},
          {"bounds_min_in_world_m", VectorJson(model.bounds_min_in_world)},
          {"bounds_max_in_world_m", VectorJson(model.bounds_max_in_world)},
          {"training_frames", model.training_frames},
          {"training_s", model.training_s},
          {"trees", model.trees},
          {"leaves", model.leaves},
          {"file_bytes", model.file_bytes}};
}

// The nearest-rank percentile; `values` sorted and not empty.
double Percentile(const std::vector<double>& values, double percent) {
  const double rank =
      std::ceil(percent / 100 * static_cast<double>(values.size()));
  return values[static_cast<size_t>(std::max(rank, 1.0)) - 1];
}

// The largest standard deviation along x, y, z of one half of the covariance.
double LargestSigma(const geometry::PoseCovariance& covariance, size_t first) {
  double variance = 0;
  for (size_t i = first; i < first + 3; ++i) {
    variance = std::max(variance, covariance[7 * i]);
  }
  return std::sqrt(variance);
}

}  // namespace

std::string AnswerJson(
    const relocalizer::FrameFiles& files,
    const absl::StatusOr<relocalizer::LocalizeAnswer>& answer) {
  Json json;
  if (!files.stem.empty()) json["stem"] = files.stem;
  json["color"] = files.color;
  if (!answer.ok()) {
    json["outcome"] = "ERROR";
    json["code"] = absl::StatusCodeToString(answer.status().code());
    json["reason"] = std::string(answer.status().message());
    if (const base::ErrorInfo info = base::ErrorInfoOf(answer.status());
        !info.reason.empty()) {
      json["error_reason"] = info.reason;
      json["error_metadata"] = info.metadata;
    }
    return Serialized(json);
  }
  json["outcome"] = answer->localized ? "LOCALIZED" : "NOT_LOCALIZED";
  json["reason"] = answer->localized ? Json(nullptr) : Json(answer->reason);
  json["world_from_camera"] = nullptr;
  json["covariance"] = nullptr;
  json["pose_sensor"] = nullptr;
  if (answer->localized) {
    json["world_from_camera"] = PoseJson(answer->world_from_camera);
    json["covariance"] = answer->covariance;
    json["pose_sensor"] = SensorName(answer->pose_sensor);
  }
  json["inliers"] = answer->inliers;
  json["samples"] = answer->samples;
  json["inlier_ratio"] = answer->inlier_ratio;
  json["focal_scale"] = answer->focal_scale;
  json["camera"] =
      answer->camera ? Json(answer->camera->ToString()) : Json(nullptr);
  json["depth_scale"] = answer->depth_scale;
  json["confidence"] = answer->confidence;
  json["confidence_threshold"] = answer->confidence_threshold;
  json["round_trip_ms"] = answer->round_trip_ms;
  json["server"] = TimingsJson(answer->server);
  json["scene"] = answer->scene;
  json["version"] = answer->model_version;
  if (!answer->candidates.empty()) {
    json["candidates"] = CandidatesJson(answer->candidates);
  }
  return Serialized(json);
}

std::string AnswerText(const relocalizer::LocalizeAnswer& answer) {
  std::string text;
  if (answer.localized) {
    const geometry::Rotation3& q = answer.world_from_camera.rotation;
    const geometry::Vec3& t = answer.world_from_camera.translation;
    text = absl::StrFormat(
        "LOCALIZED in %s, version %s: %s camera\n"
        "  position         %.4f %.4f %.4f m  (x y z, sigma %.1f mm)\n"
        "  rotation         %.6f %.6f %.6f %.6f  (qw qx qy qz, sigma %.2f deg)"
        "\n",
        answer.scene, answer.model_version,
        answer.pose_sensor == camera::RgbdSensor::kColor ? "colour" : "depth",
        t.x, t.y, t.z, 1e3 * LargestSigma(answer.covariance, 0), q.w, q.x, q.y,
        q.z, kDegreesPerRadian * LargestSigma(answer.covariance, 3));
  } else {
    text = absl::StrFormat("NOT LOCALIZED in %s, version %s: %s\n",
                           answer.scene, answer.model_version, answer.reason);
  }
  const relocalizer::ServerTimings& s = answer.server;
  absl::StrAppendFormat(
      &text,
      "  inliers          %d of %d samples (%.1f %%)\n"
      "  round trip       %.1f ms; server %.1f ms: queue %.1f, decode %.1f, "
      "localize %.1f\n",
      answer.inliers, answer.samples, 100 * answer.inlier_ratio,
      answer.round_trip_ms, s.total_ms, s.queue_ms, s.decode_ms, s.localize_ms);
  if (answer.focal_scale != 1) {
    absl::StrAppendFormat(&text,
                          "  focal length     %.3f times the stated one\n",
                          answer.focal_scale);
  }
  if (answer.camera) {
    absl::StrAppendFormat(&text, "  camera           %s, as none was stated\n",
                          answer.camera->ToString());
  }
  if (answer.depth_scale != 1) {
    absl::StrAppendFormat(&text,
                          "  depth            %.3f times what was sent\n",
                          answer.depth_scale);
  }
  for (const relocalizer::SceneCandidate& candidate : answer.candidates) {
    absl::StrAppendFormat(&text, "  candidate        %s: similarity %.3f",
                          candidate.scene, candidate.similarity);
    if (candidate.tried) {
      absl::StrAppendFormat(&text, ", %s, %d inliers, confidence %.2f",
                            candidate.localized ? "localized" : "not localized",
                            candidate.inliers, candidate.confidence);
    }
    text.push_back('\n');
  }
  return text;
}

std::string AnswerLine(
    const relocalizer::FrameFiles& files,
    const absl::StatusOr<relocalizer::LocalizeAnswer>& answer) {
  if (!answer.ok()) {
    return absl::StrCat(files.stem, "  ERROR ",
                        absl::StatusCodeToString(answer.status().code()), ": ",
                        answer.status().message());
  }
  if (!answer->localized) {
    return absl::StrFormat("%s  NOT_LOCALIZED %s  %d/%d  %.1f ms", files.stem,
                           answer->reason, answer->inliers, answer->samples,
                           answer->round_trip_ms);
  }
  const geometry::Rotation3& q = answer->world_from_camera.rotation;
  const geometry::Vec3& t = answer->world_from_camera.translation;
  return absl::StrFormat(
      "%s  %.4f %.4f %.4f m  %.6f %.6f %.6f %.6f  %d/%d  %.1f ms", files.stem,
      t.x, t.y, t.z, q.w, q.x, q.y, q.z, answer->inliers, answer->samples,
      answer->round_trip_ms);
}

void AnswerSummary::Add(
    const absl::StatusOr<relocalizer::LocalizeAnswer>& answer) {
  ++queries_;
  if (!answer.ok()) {
    ++failed_;
    return;
  }
  localized_ += answer->localized;
  round_trip_ms_.push_back(answer->round_trip_ms);
}

std::string AnswerSummary::Text() const {
  std::string text =
      absl::StrFormat("%d frames: %d localized, %d not, %d failed", queries_,
                      localized_, queries_ - localized_ - failed_, failed_);
  if (!round_trip_ms_.empty()) {
    std::vector<double> sorted = round_trip_ms_;
    std::sort(sorted.begin(), sorted.end());
    absl::StrAppendFormat(
        &text, "; round trip p50 %.1f ms, p95 %.1f ms, p99 %.1f ms",
        Percentile(sorted, 50), Percentile(sorted, 95), Percentile(sorted, 99));
  }
  return text;
}

std::string ScenesJson(
    const std::vector<relocalizer::SceneDescription>& scenes) {
  Json list = Json::array();
  for (const relocalizer::SceneDescription& scene : scenes) {
    list.push_back(
        {{"scene", scene.name},
         {"state", scene.state},
         {"failure",
          scene.failure.empty() ? Json(nullptr) : Json(scene.failure)},
         {"version", scene.model_version.empty() ? Json(nullptr)
                                                 : Json(scene.model_version)},
         {"versions", scene.versions},
         {"display_name", scene.display_name},
         {"resident_bytes", scene.resident_bytes},
         {"model", scene.model ? ModelJson(*scene.model) : Json(nullptr)}});
  }
  return Serialized({{"scenes", list}});
}

std::string ScenesText(
    const std::vector<relocalizer::SceneDescription>& scenes) {
  if (scenes.empty()) return "no scenes\n";
  size_t width = 5;
  for (const relocalizer::SceneDescription& scene : scenes) {
    width = std::max(width, scene.name.size());
  }
  const int w = static_cast<int>(width);
  std::string text =
      absl::StrFormat("%-*s  %-8s  %-10s  %-8s  %8s  %s\n", w, "SCENE", "STATE",
                      "VERSION", "METHOD", "MB", "TRAINED");
  std::string failures;
  for (const relocalizer::SceneDescription& scene : scenes) {
    absl::StrAppendFormat(&text, "%-*s  %-8s  %-10s", w, scene.name,
                          scene.state, scene.model_version);
    if (scene.model) {
      absl::StrAppendFormat(&text, "  %-8s  %8.1f  %s", scene.model->method,
                            1e-6 * static_cast<double>(scene.model->file_bytes),
                            scene.model->created_utc);
    }
    text.push_back('\n');
    if (!scene.failure.empty()) {
      absl::StrAppend(&failures, scene.name, ": ", scene.failure, "\n");
    }
  }
  return text + failures;
}

}  // namespace treeline::client_cli
