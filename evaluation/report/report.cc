#include "evaluation/report/report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "evaluation/accuracy/evaluation_json.h"
#include "evaluation/accuracy/method_spec.h"
#include "evaluation/accuracy/published_results.h"
#include "evaluation/accuracy/training_distance.h"
#include "evaluation/report/view_axes.h"
#include "nlohmann/json.hpp"
#include "server/tools/model_description.h"

namespace treeline::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kRampColors = 12;
// The curve of scene-coordinate errors ends at 40 cm, in steps of 2 mm.
constexpr int kSceneErrorSteps = 200;
constexpr double kSceneErrorStep_m = 0.002;

Json Number(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

Json Vector(geometry::Vec3 v) {
  return {Number(v.x), Number(v.y), Number(v.z)};
}

Json ImageUri(const std::string& jpeg) {
  return absl::StrCat("data:image/jpeg;base64,", absl::Base64Escape(jpeg));
}

const char* KindName(accuracy::PictureKind kind) {
  switch (kind) {
    case accuracy::PictureKind::kWorst:
      return "worst";
    case accuracy::PictureKind::kMedian:
      return "median";
    case accuracy::PictureKind::kBest:
      return "best";
  }
  return "";
}

// Along which axis of the camera a position error lies, where one stands out.
Json ErrorDirection(const accuracy::FrameResult& result) {
  if (!result.error) return nullptr;
  const geometry::Rigid3& truth = *result.true_world_from_camera;
  const geometry::Vec3 error =
      truth.rotation.Inverse() *
      (result.estimate.world_from_camera.translation - truth.translation);
  const double share_of_depth = std::abs(error.z) / geometry::Norm(error);
  if (share_of_depth > 0.85) return "depth";
  if (share_of_depth < 0.4) return "sideways";
  return nullptr;
}

// The standard deviation of the position that the answer states.
Json ClaimedDeviation(const accuracy::FrameResult& result) {
  if (!result.localized()) return nullptr;
  const geometry::PoseCovariance& c = result.estimate.covariance;
  const double deviation_m = std::sqrt(c[0] + c[7] + c[14]);
  return deviation_m > 0 ? Number(deviation_m) : Json(nullptr);
}

Json Pixels(const std::vector<localizer::Correspondence>& correspondences,
            bool inlier) {
  Json pixels = Json::array();
  for (const localizer::Correspondence& c : correspondences) {
    if (c.inlier != inlier) continue;
    pixels.push_back(std::lround(c.color_pixel.x));
    pixels.push_back(std::lround(c.color_pixel.y));
  }
  return pixels;
}

Json PicturesJson(const accuracy::EvaluatedMethod& method) {
  Json json = Json::array();
  for (const accuracy::ReportPicture& picture : method.pictures) {
    const accuracy::FrameResult& result =
        method.results[static_cast<size_t>(picture.choice.frame)];
    json.push_back({{"frame", picture.choice.frame},
                    {"kind", KindName(picture.choice.kind)},
                    {"width", picture.width},
                    {"height", picture.height},
                    {"photo", ImageUri(picture.jpeg)},
                    {"inliers", Pixels(picture.correspondences, true)},
                    {"outliers", Pixels(picture.correspondences, false)},
                    {"error_direction", ErrorDirection(result)},
                    {"claimed_deviation_m", ClaimedDeviation(result)}});
  }
  return json;
}

Json HeatMapsJson(const std::vector<accuracy::ErrorHeatMap>& maps) {
  Json json = Json::array();
  for (const accuracy::ErrorHeatMap& map : maps) {
    json.push_back({{"stem", map.stem},
                    {"width", map.width},
                    {"height", map.height},
                    {"photo", ImageUri(map.photo_jpeg)},
                    {"map", ImageUri(map.map_jpeg)},
                    {"predictions", map.predictions},
                    {"median_error_m", Number(map.median_error_m)}});
  }
  return json;
}

// Of ascending errors.
Json SceneErrorCurve(const std::vector<double>& errors_m) {
  Json json = Json::array();
  for (int step = 0; step <= kSceneErrorSteps && !errors_m.empty(); ++step) {
    const double within_m = kSceneErrorStep_m * step;
    const auto end = std::ranges::upper_bound(errors_m, within_m);
    json.push_back({within_m, static_cast<double>(end - errors_m.begin()) /
                                  static_cast<double>(errors_m.size())});
  }
  return json;
}

Json ModelDescription(const forest::ModelInfo& model) {
  Json json = Json::array();
  for (const tools::DescriptionSection& section : tools::DescribeModel(model)) {
    Json rows = Json::array();
    for (const auto& [name, value] : section.rows) {
      rows.push_back(Json::array({name, value}));
    }
    json.push_back({{"title", section.title}, {"rows", std::move(rows)}});
  }
  return json;
}

Json AxesJson(const std::vector<accuracy::FrameResult>& results) {
  std::vector<geometry::Rigid3> poses;
  for (const accuracy::FrameResult& result : results) {
    if (result.true_world_from_camera) {
      poses.push_back(*result.true_world_from_camera);
    }
  }
  const ViewAxes axes = AxesOfCameras(poses);
  return {{"right", Vector(axes.right_in_world)},
          {"forward", Vector(axes.forward_in_world)},
          {"up", Vector(axes.up_in_world)}};
}

Json PageJson(const accuracy::EvaluatedMethod& method) {
  Json json = Json::object();
  const accuracy::MethodInputs inputs =
      accuracy::InputsOfMethod(method.model.method);
  json["inputs"] = inputs.query.empty() ? Json(nullptr)
                                        : Json{{"training", inputs.training},
                                               {"query", inputs.query}};
  json["model_description"] = ModelDescription(method.model);
  json["axes"] = AxesJson(method.results);
  json["training_positions"] = Json::array();
  for (const geometry::Rigid3& pose : method.training_poses) {
    json["training_positions"].push_back(Vector(pose.translation));
  }
  json["pictures"] = PicturesJson(method);
  json["heat_maps"] = HeatMapsJson(method.heat_maps);
  json["splits"] = Json::array();
  for (const accuracy::LevelSplits& level : method.splits) {
    json["splits"].push_back(
        {{"splits", level.splits}, {"by_left_share", level.by_left_share}});
  }
  json["scene_error_curve"] = SceneErrorCurve(method.scene_errors_m);
  return json;
}

Json TrainingDistanceJson(const accuracy::FrameResult& result,
                          const std::vector<geometry::Rigid3>& training_poses) {
  if (!result.true_world_from_camera) return nullptr;
  const auto nearest = accuracy::DistanceToTraining(
      *result.true_world_from_camera, training_poses);
  if (!nearest) return nullptr;
  return {{"translation_m", nearest->translation_m},
          {"rotation_deg", nearest->rotation_deg},
          {"combined_m", nearest->combined_m}};
}

Json ResultsJson(const std::vector<accuracy::PublishedResult>& results) {
  Json json = Json::array();
  for (const accuracy::PublishedResult& result : results) {
    json.push_back({{"method", result.method},
                    {"training", result.training},
                    {"query", result.query},
                    {"source", result.source},
                    {"note", result.note},
                    {"correct_percent", Number(result.correct_percent)},
                    {"median_cm", Number(result.median_cm)},
                    {"median_deg", Number(result.median_deg)}});
  }
  return json;
}

Json PublishedJson(const std::string& dataset_uri) {
  const std::optional<accuracy::PublishedTable> table =
      accuracy::PublishedFor(dataset_uri);
  if (!table) return nullptr;
  const std::string scene = accuracy::SceneOf(*table, dataset_uri);
  return {{"dataset", table->dataset},
          {"protocol", table->protocol},
          {"scene", scene.empty() ? Json(nullptr) : Json(scene)},
          {"scene_results",
           scene.empty() ? Json::array()
                         : ResultsJson(accuracy::ResultsFor(*table, scene))},
          {"average_results",
           ResultsJson(accuracy::ResultsFor(*table, "average"))}};
}

Json HeatMapScale() {
  Json colors = Json::array();
  for (int k = 0; k < kRampColors; ++k) {
    colors.push_back(accuracy::HeatColor((k + 0.5) / kRampColors));
  }
  return {{"max_m", accuracy::kHeatMapMax_m}, {"colors", std::move(colors)}};
}

}  // namespace

std::string ReportJson(const ReportContents& contents) {
  Json json{{"kind", "evaluation"}};
  json.update(accuracy::ComparisonDocument(contents.methods, contents.sweeps,
                                           contents.run));
  for (size_t i = 0; i < contents.methods.size(); ++i) {
    const accuracy::EvaluatedMethod& method = contents.methods[i];
    if (!method.status.ok()) continue;
    Json& entry = json["methods"][i];
    for (size_t frame = 0; frame < method.results.size(); ++frame) {
      entry["per_frame"][frame]["training_distance"] =
          TrainingDistanceJson(method.results[frame], method.training_poses);
    }
    entry["page"] = PageJson(method);
  }
  size_t line = 0;
  for (const accuracy::Sweep& sweep : contents.sweeps) {
    for (size_t i = 0; i < sweep.lines.size(); ++i) {
      json["sweeps"][line++]["axis"] = accuracy::SweepAxis(sweep.variable);
    }
  }
  json["published"] = PublishedJson(contents.run.dataset_uri);
  json["heat_map_scale"] = HeatMapScale();
  // Names from files may hold any bytes; JSON holds UTF-8 alone.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace treeline::report
