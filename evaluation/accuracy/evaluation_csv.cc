#include "evaluation/accuracy/evaluation_csv.h"

#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"

namespace treeline::accuracy {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

constexpr const char* kHeader =
    "method,frame,outcome,reason,confidence,inliers,samples,inlier_ratio,"
    "translation_error_m,rotation_error_deg,latency_ms,cpu_ms,decode_ms,"
    "sample_ms,forest_ms,pose_ms,qw,qx,qy,qz,tx,ty,tz,"
    "true_qw,true_qx,true_qy,true_qz,true_tx,true_ty,true_tz,perturbation\n";

std::string Quoted(absl::string_view text) {
  if (text.find_first_of(",\"\r\n") == absl::string_view::npos) {
    return std::string(text);
  }
  return absl::StrCat("\"", absl::StrReplaceAll(text, {{"\"", "\"\""}}), "\"");
}

std::string Number(const std::optional<double>& value) {
  if (!value || !std::isfinite(*value)) return "";
  return absl::StrFormat("%.9g", *value);
}

void AddPose(const std::optional<geometry::Rigid3>& pose,
             std::vector<std::string>& fields) {
  if (!pose) {
    fields.insert(fields.end(), 7, "");
    return;
  }
  const geometry::Rotation3& q = pose->rotation;
  const geometry::Vec3& t = pose->translation;
  for (double value : {q.w, q.x, q.y, q.z, t.x, t.y, t.z}) {
    fields.push_back(Number(value));
  }
}

std::string Line(const std::string& method, const FrameResult& result,
                 const std::string& perturbation) {
  const localizer::PoseEstimate& estimate = result.estimate;
  const bool answered = result.status.ok();
  std::vector<std::string> fields{Quoted(method), Quoted(result.stem)};
  if (answered) {
    fields.emplace_back(localizer::OutcomeName(estimate.outcome));
    fields.emplace_back(result.localized()
                            ? absl::string_view()
                            : localizer::ReasonName(estimate.reason));
    fields.insert(
        fields.end(),
        {Number(estimate.confidence), absl::StrCat(estimate.inliers),
         absl::StrCat(estimate.samples), Number(estimate.inlier_ratio)});
  } else {
    fields.emplace_back("ERROR");
    fields.push_back(Quoted(result.status.message()));
    fields.insert(fields.end(), 4, "");
  }
  const auto& error = result.error;
  fields.push_back(error ? Number(error->translation_m) : "");
  fields.push_back(error ? Number(error->rotation_rad * kDegreesPerRadian)
                         : "");
  for (const auto& time_ms :
       {result.latency_ms, result.cpu_ms, result.decode_ms}) {
    fields.push_back(Number(time_ms));
  }
  const localizer::LocalizeTimings& stages = estimate.timings;
  for (double time_ms : {stages.sample_ms, stages.forest_ms, stages.pose_ms}) {
    fields.push_back(answered ? Number(time_ms) : "");
  }
  AddPose(result.localized()
              ? std::optional<geometry::Rigid3>(estimate.world_from_camera)
              : std::nullopt,
          fields);
  AddPose(result.true_world_from_camera, fields);
  fields.push_back(Quoted(perturbation));
  return absl::StrJoin(fields, ",") + "\n";
}

}  // namespace

std::string EvaluationCsv(const std::vector<EvaluatedMethod>& methods) {
  std::string csv = kHeader;
  for (const EvaluatedMethod& method : methods) {
    for (const FrameResult& result : method.results) {
      csv += Line(method.name, result, "");
    }
    for (const PerturbedResults& perturbed : method.perturbed) {
      for (const FrameResult& result : perturbed.results) {
        csv += Line(method.name, result, perturbed.perturbation.Name());
      }
    }
  }
  return csv;
}

}  // namespace treeline::accuracy
