#include "evaluation/accuracy/evaluation_json.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"
#include "evaluation/accuracy/answer_counts.h"
#include "evaluation/accuracy/camera_rows.h"
#include "evaluation/accuracy/confidence_report.h"
#include "evaluation/accuracy/perturbation_table.h"
#include "evaluation/accuracy/training_distance.h"
#include "evaluation/accuracy/trajectory_error.h"
#include "nlohmann/json.hpp"
#include "server/core/forest/model_info_json.h"

namespace treeline::accuracy {
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

Json Vector(geometry::Vec3 v) {
  return {Number(v.x), Number(v.y), Number(v.z)};
}

Json Pose(const geometry::Rigid3& pose) {
  const geometry::Rotation3& q = pose.rotation;
  const geometry::Vec3& t = pose.translation;
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
  const localizer::PoseEstimate& estimate = result.estimate;
  const bool answered = result.status.ok();
  if (!answered) {
    json["outcome"] = "ERROR";
    json["reason"] = Text(result.status.message());
    for (const char* key : {"inliers", "samples", "inlier_ratio", "confidence",
                            "focal_scale", "depth_scale", "evidence"}) {
      json[key] = nullptr;
    }
  } else {
    json["outcome"] = Text(localizer::OutcomeName(estimate.outcome));
    json["reason"] = result.localized()
                         ? Json(nullptr)
                         : Text(localizer::ReasonName(estimate.reason));
    json["inliers"] = estimate.inliers;
    json["samples"] = estimate.samples;
    json["inlier_ratio"] = Number(estimate.inlier_ratio);
    json["confidence"] = Number(estimate.confidence);
    json["focal_scale"] = Number(estimate.focal_scale);
    json["depth_scale"] = Number(estimate.depth_scale);
    const forest::PoseEvidence& evidence = estimate.evidence;
    json["evidence"] = {{"inlier_ratio", Number(evidence.inlier_ratio)},
                        {"correlation", Number(evidence.correlation)},
                        {"agreement", Number(evidence.agreement)},
                        {"visible", evidence.visible},
                        {"overlap", Number(evidence.overlap)},
                        {"depth_agreement", Number(evidence.depth_agreement)},
                        {"contradicted", Number(evidence.contradicted)},
                        {"moved_m", Number(evidence.moved_m)},
                        {"matches", evidence.matches},
                        {"distinct", Number(evidence.distinct)},
                        {"sigma_m", Number(evidence.sigma_m)}};
  }
  json["world_from_camera"] =
      result.localized() ? Pose(estimate.world_from_camera) : Json(nullptr);
}

void AddError(const std::optional<geometry::PoseError>& error, Json& json) {
  json["translation_error_m"] =
      error ? Number(error->translation_m) : Json(nullptr);
  json["rotation_error_deg"] =
      error ? Number(error->rotation_rad * kDegreesPerRadian) : Json(nullptr);
}

// The best pose of a frame that was not localized.
Json Refused(const FrameResult& result) {
  if (!result.refused_pose()) return nullptr;
  Json json{{"world_from_camera", Pose(result.estimate.world_from_camera)}};
  AddError(result.refused_error, json);
  return json;
}

Json Stages(const FrameResult& result) {
  if (!result.status.ok()) return nullptr;
  const localizer::LocalizeTimings& timings = result.estimate.timings;
  return {{"sample_ms", Number(timings.sample_ms)},
          {"forest_ms", Number(timings.forest_ms)},
          {"pose_ms", Number(timings.pose_ms)},
          {"features_ms", Number(timings.features_ms)},
          {"verify_ms", Number(timings.verify_ms)},
          {"total_ms", Number(timings.total_ms)}};
}

Json PerFrame(const FrameResult& result) {
  Json json{{"stem", Text(result.stem)}};
  AddEstimate(result, json);
  json["true_world_from_camera"] = result.true_world_from_camera
                                       ? Pose(*result.true_world_from_camera)
                                       : Json(nullptr);
  AddError(result.error, json);
  json["refused"] = Refused(result);
  json["latency_ms"] = Number(result.latency_ms);
  json["cpu_ms"] = Number(result.cpu_ms);
  json["decode_ms"] = Number(result.decode_ms);
  json["stages"] = Stages(result);
  return json;
}

// What the trainer stated, and what the file itself tells.
Json ModelJson(const forest::ModelInfo& model) {
  Json json = Json::parse(forest::ModelInfoToJson(model));
  json["format_version"] = model.format_version;
  json["bounds_min_in_world"] = Vector(model.bounds_min_in_world);
  json["bounds_max_in_world"] = Vector(model.bounds_max_in_world);
  json["trees"] = model.trees;
  json["nodes"] = model.nodes;
  json["leaves"] = model.leaves;
  json["file_bytes"] = model.file_bytes;
  json["memory_bytes"] = model.memory_bytes;
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

// Accuracy and counts: what stands first.
void AddHeadline(const EvaluationSummary& summary, Json& json) {
  json["frames"] = summary.frames;
  json["scored"] = summary.scored;
  json["localized"] = summary.localized;
  json["errors"] = summary.errors;
  json["correct_5cm_5deg"] = Number(summary.correct_5cm_5deg);
  json["correct_2cm_2deg"] = Number(summary.correct_2cm_2deg);
  json["median_translation_m"] = Number(summary.median_translation_m);
  json["median_rotation_deg"] = Number(summary.median_rotation_deg);
  json["latency_ms"] = PercentilesJson(summary.latency_ms);
  json["cpu_ms"] = PercentilesJson(summary.cpu_ms);
  json["decode_ms"] = PercentilesJson(summary.decode_ms);
  json["stages_ms"] = {{"sample_ms", PercentilesJson(summary.sample_ms)},
                       {"forest_ms", PercentilesJson(summary.forest_ms)},
                       {"pose_ms", PercentilesJson(summary.pose_ms)}};
}

Json ThresholdsJson(const std::vector<FrameResult>& results,
                    const std::vector<ThresholdRequest>& requests) {
  const std::optional<double> size_m = SceneSize_m(results);
  Json json = Json::array();
  for (const ThresholdRequest& request : requests) {
    const std::optional<PoseThreshold> threshold = Resolve(request, size_m);
    json.push_back(
        {{"name", ThresholdText(request)},
         {"translation_m",
          threshold ? Number(threshold->translation_m) : Json(nullptr)},
         {"rotation_deg", request.rotation_deg},
         {"correct", threshold ? Number(CorrectShare(results, *threshold))
                               : Json(nullptr)}});
  }
  return json;
}

Json TrajectoryJson(const std::vector<FrameResult>& results) {
  const std::vector<dataset::PosePair> pairs = PosePairs(results);
  const auto rmse = [&](dataset::TrajectoryAlignment alignment) {
    const auto error = dataset::AbsoluteTrajectoryError(pairs, alignment);
    return error ? Number(error->position_m.rmse) : Json(nullptr);
  };
  const auto similar = dataset::AlignTrajectory(
      pairs, dataset::TrajectoryAlignment::kSimilarity);
  return {{"rmse_m", rmse(dataset::TrajectoryAlignment::kNone)},
          {"aligned_rmse_m", rmse(dataset::TrajectoryAlignment::kRigid)},
          {"aligned_with_scale_rmse_m",
           rmse(dataset::TrajectoryAlignment::kSimilarity)},
          {"scale", similar ? Number(similar->scale) : Json(nullptr)}};
}

Json ConfidenceJson(const std::vector<FrameResult>& results, double threshold) {
  const ConfidenceReport report = AssessConfidence(results, {}, threshold);
  Json bins = Json::array();
  for (const ReliabilityBin& bin : report.bins) {
    const bool any = report.stated && bin.frames > 0;
    bins.push_back({{"low", bin.low},
                    {"high", bin.high},
                    {"frames", bin.frames},
                    {"confidence", any ? Json(bin.confidence) : Json(nullptr)},
                    {"correct", any ? Json(bin.correct) : Json(nullptr)}});
  }
  return {
      {"stated", report.stated},
      {"threshold", report.threshold},
      {"precision", Number(report.Precision())},
      {"recall", Number(report.Recall())},
      {"expected_calibration_error", Number(report.expected_calibration_error)},
      {"bins", std::move(bins)}};
}

Json ForeignJson(const std::vector<NegativeTally>& tallies) {
  Json json = Json::array();
  for (const NegativeTally& tally : tallies) {
    Json names = Json::array();
    for (const std::string& name : tally.accepted_names) {
      names.push_back(Text(name));
    }
    Json problems = Json::array();
    for (const std::string& problem : tally.problems) {
      problems.push_back(Text(problem));
    }
    json.push_back({{"source", Text(tally.source)},
                    {"with_depth", tally.with_depth},
                    {"images", tally.images},
                    {"accepted", tally.accepted},
                    {"confident", tally.confident},
                    {"not_localized", tally.not_localized},
                    {"refused", tally.refused},
                    {"unreadable", tally.unreadable},
                    {"accepted_names", std::move(names)},
                    {"problems", std::move(problems)}});
  }
  return json;
}

// Adds the counts of a group of frames, and what follows from them.
void AddCounts(const AnswerCounts& counts, Json& json) {
  json["frames"] = counts.frames;
  json["answered"] = counts.answered;
  json["right"] = counts.right;
  json["found"] = counts.found;
  json["relied_on"] = counts.relied_on;
  json["wrong"] = counts.wrong;
  json["gross"] = counts.gross;
  json["share_right"] = Number(counts.ShareRight());
  json["share_answered"] = Number(counts.ShareAnswered());
  json["share_found"] = Number(counts.ShareFound());
  json["coverage"] = Number(counts.Coverage());
  json["precision"] = Number(counts.Precision());
  json["calibration_error"] = Number(counts.calibration_error);
  json["latency_ms"] = PercentilesJson(counts.latency_ms);
  json["cpu_ms"] = PercentilesJson(counts.cpu_ms);
}

Json AnswersJson(const EvaluatedMethod& method, double threshold) {
  Json json = Json::object();
  AddCounts(
      CountAnswers(method.results,
                   RightWithin(method.results, method.model.units_are_metres),
                   threshold),
      json);
  return json;
}

Json BinsJson(const std::vector<TrainingDistanceBin>& bins) {
  Json json = Json::array();
  for (const TrainingDistanceBin& bin : bins) {
    Json entry{{"low", bin.low}, {"high", Number(bin.high)}};
    AddCounts(bin.counts, entry);
    json.push_back(std::move(entry));
  }
  return json;
}

Json TrainingDistanceJson(const EvaluatedMethod& method, double threshold) {
  const TrainingDistanceBins bins = BinByTrainingDistance(method, threshold);
  return {{"by_view_gap", BinsJson(bins.by_view_gap)},
          {"by_distance_m", BinsJson(bins.by_distance_m)},
          {"by_angle_deg", BinsJson(bins.by_angle_deg)}};
}

Json CamerasJson(const EvaluatedMethod& method, double threshold) {
  Json json = Json::array();
  for (const CameraRow& row : CameraRows(method, threshold)) {
    Json entry{{"camera", Text(row.camera)}};
    AddCounts(row.counts, entry);
    json.push_back(std::move(entry));
  }
  return json;
}

Json PerturbationsJson(const EvaluatedMethod& method, double threshold) {
  Json json = Json::array();
  for (const PerturbationRow& row : PerturbationRows(method, threshold)) {
    Json entry{{"name", row.name}, {"is_foreign", row.is_foreign}};
    AddCounts(row.counts, entry);
    json.push_back(std::move(entry));
  }
  return json;
}

// Of ascending values.
Json SceneErrorsJson(const std::vector<double>& errors_m) {
  Json json{{"predictions", errors_m.size()},
            {"median_m", Number(Percentile(errors_m, 50))}};
  Json curve = Json::array();
  for (int step = 1; step <= 20 && !errors_m.empty(); ++step) {
    const double within_m = 0.02 * step;
    const auto end = std::ranges::upper_bound(errors_m, within_m);
    curve.push_back({{"within_m", within_m},
                     {"share", static_cast<double>(end - errors_m.begin()) /
                                   static_cast<double>(errors_m.size())}});
  }
  json["cumulative"] = std::move(curve);
  return json;
}

// All of a method but its name.
void AddMethod(const EvaluatedMethod& method, const EvaluationRun& run,
               Json& json) {
  const std::vector<FrameResult>& results = method.results;
  AddHeadline(Summarize(results), json);
  json["thresholds"] = ThresholdsJson(results, run.thresholds);
  json["trajectory"] = TrajectoryJson(results);
  json["answers"] = AnswersJson(method, run.confidence_threshold);
  json["confidence"] = ConfidenceJson(results, run.confidence_threshold);
  json["foreign"] = ForeignJson(method.foreign);
  json["training_distance"] =
      TrainingDistanceJson(method, run.confidence_threshold);
  json["cameras"] = CamerasJson(method, run.confidence_threshold);
  json["perturbations"] = PerturbationsJson(method, run.confidence_threshold);
  json["scene_coordinate_errors"] = SceneErrorsJson(method.scene_errors_m);
  json["model_bytes"] = method.model.file_bytes;
  json["training_s"] = Number(method.model.training_s);
  json["evaluation_peak_memory_bytes"] = method.peak_memory_bytes;
  json["method"] = Text(method.model.method);
  json["model_path"] = OrNull(method.model_path);
  json["model"] = ModelJson(method.model);
}

void AddRun(const EvaluationRun& run, Json& json) {
  json["seed"] = run.seed;
  json["threads"] = run.threads;
  json["min_confidence"] = Number(run.min_confidence);
  json["cpu"] = Text(run.cpu);
  json["software_version"] = Text(run.software_version);
  json["peak_memory_bytes"] = run.peak_memory_bytes;
  json["started_utc"] = Text(run.started_utc);
  json["command"] = Text(run.command);
  json["dataset"] = Text(run.dataset_uri);
  json["frame_list"] = OrNull(run.frame_list);
  json["pose_file"] = OrNull(run.pose_file);
}

Json FramesJson(const std::vector<FrameResult>& results) {
  Json frames = Json::array();
  for (const FrameResult& result : results) frames.push_back(PerFrame(result));
  return frames;
}

Json SweepsJson(const std::vector<Sweep>& sweeps) {
  Json json = Json::array();
  for (const Sweep& sweep : sweeps) {
    for (const SweepLine& line : sweep.lines) {
      Json points = Json::array();
      for (const SweepPoint& point : line.points) {
        Json entry{{"value", point.value}};
        AddHeadline(point.summary, entry);
        entry["training_s"] = Number(point.training_s);
        entry["model_bytes"] = point.model_bytes;
        points.push_back(std::move(entry));
      }
      json.push_back({{"option", SweepName(sweep.variable)},
                      {"name", Text(line.method)},
                      {"points", std::move(points)}});
    }
  }
  return json;
}

}  // namespace

std::string EvaluationJson(const EvaluatedMethod& method,
                           const std::vector<Sweep>& sweeps,
                           const EvaluationRun& run) {
  Json json = Json::object();
  AddMethod(method, run, json);
  AddRun(run, json);
  json["sweeps"] = SweepsJson(sweeps);
  json["per_frame"] = FramesJson(method.results);
  return Serialized(json);
}

Json ComparisonDocument(const std::vector<EvaluatedMethod>& methods,
                        const std::vector<Sweep>& sweeps,
                        const EvaluationRun& run) {
  Json json = Json::object();
  AddRun(run, json);
  json["methods"] = Json::array();
  for (const EvaluatedMethod& method : methods) {
    Json entry{{"name", Text(method.name)}};
    if (method.status.ok()) {
      AddMethod(method, run, entry);
      entry["per_frame"] = FramesJson(method.results);
    } else {
      entry["error"] = Text(method.status.message());
    }
    json["methods"].push_back(std::move(entry));
  }
  json["sweeps"] = SweepsJson(sweeps);
  return json;
}

std::string ComparisonJson(const std::vector<EvaluatedMethod>& methods,
                           const std::vector<Sweep>& sweeps,
                           const EvaluationRun& run) {
  return Serialized(ComparisonDocument(methods, sweeps, run));
}

std::string ModelInfoJson(const forest::ModelInfo& model) {
  return Serialized(ModelJson(model));
}

}  // namespace treeline::accuracy
