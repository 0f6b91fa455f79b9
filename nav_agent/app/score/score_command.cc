#include "nav_agent/app/score/score_command.h"

#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/trajectory_error.h"
#include "common/geometry/planar_pose.h"
#include "nav_agent/app/map/trajectory_files.h"
#include "nav_agent/mapping/trajectory_score.h"
#include "nav_agent/recording/relations.h"

namespace treeline::score_app {
namespace {

constexpr const char* kFooter = R"(
Trajectories are text, 'time tx ty tz qx qy qz qw' (TUM); a map bundle; a laser
log with poses (JSON, CARMEN); or a recording, 7scenes:DIR or tum:DIR.

With --reference: the absolute trajectory error after the best rigid alignment,
and the relative error (Sturm et al. 2012). With --relations, lines 't1 t2 x y z
roll pitch yaw': the errors of relative poses (Kuemmerle et al. 2009).

Examples:
  treeline-agent score-trajectory --estimate map/trajectory.txt \
      --reference tum:rgbd_dataset_freiburg1_room
  treeline-agent score-trajectory --estimate map --relations intel.relations \
      --json score.json)";

constexpr double kDegPerRad = 180 / std::numbers::pi;

struct ScoreFlags {
  std::string estimate;
  std::string reference;
  std::string poses;
  std::string relations;
  double interval_s = 1;
  double max_gap_s = 0.1;
  std::string json;
};

// A table's line and its JSON.
void Add(const char* name, const char* unit, double scale,
         const base::ErrorSummary& errors, std::string& text,
         std::string& json) {
  absl::StrAppendFormat(
      &text, "%-22s rmse %8.4f  mean %8.4f  median %8.4f  max %8.4f %s\n", name,
      scale * errors.rmse, scale * errors.mean, scale * errors.median,
      scale * errors.max, unit);
  absl::StrAppendFormat(
      &json,
      ",\n  \"%s_%s\": {\"rmse\": %.9g, \"mean\": %.9g, \"median\": %.9g, "
      "\"max\": %.9g}",
      name, unit, scale * errors.rmse, scale * errors.mean,
      scale * errors.median, scale * errors.max);
}

struct Report {
  std::string text;
  std::string json;
};

absl::StatusOr<Report> AgainstReference(
    const ScoreFlags& flags, const std::vector<dataset::TimedPose>& estimate) {
  TL_ASSIGN_OR_RETURN(const std::vector<dataset::TimedPose> reference,
                      map_app::ReadTrajectory(flags.reference, flags.poses));
  TL_ASSIGN_OR_RETURN(
      const dataset::TrajectoryScore error,
      dataset::ScoreTrajectory(estimate, reference,
                               {.max_gap_s = flags.max_gap_s,
                                .max_difference_s = 0.02,
                                .interval_s = flags.interval_s}));
  Report report;
  report.text = absl::StrFormat("%d poses, %d of them with a reference\n",
                                error.poses, error.absolute.poses);
  report.json = absl::StrFormat(
      "{\n  \"poses\": %d,\n  \"associated\": %d,\n  \"pairs\": %d",
      error.poses, error.absolute.poses, error.pairs);
  Add("absolute", "m", 1, error.absolute.position_m, report.text, report.json);
  Add("absolute", "deg", kDegPerRad, error.absolute.rotation_rad, report.text,
      report.json);
  Add("relative", "m", 1, error.relative_m, report.text, report.json);
  Add("relative", "deg", kDegPerRad, error.relative_rad, report.text,
      report.json);
  report.json += "\n}\n";
  return report;
}

std::vector<mapping::TrajectoryPose> FromAbove(
    const std::vector<dataset::TimedPose>& poses) {
  std::vector<mapping::TrajectoryPose> planar;
  for (const dataset::TimedPose& pose : poses) {
    planar.push_back(
        {recording::RecordingTime(std::chrono::nanoseconds(pose.time)),
         geometry::PlanarPose(pose.world_from_camera)});
  }
  return planar;
}

absl::StatusOr<Report> AgainstRelations(
    const ScoreFlags& flags, const std::vector<dataset::TimedPose>& estimate) {
  TL_ASSIGN_OR_RETURN(const std::vector<recording::PoseRelation> relations,
                      recording::ReadRelations(flags.relations));
  const std::vector<mapping::TrajectoryPose> planar = FromAbove(estimate);
  Report report;
  report.json = absl::StrFormat("{\n  \"poses\": %d", estimate.size());
  // All relations, and those whose ends are poses of the estimate, where
  // nothing is interpolated.
  const auto add = [&](const char* which,
                       const mapping::RelationScoreOptions& options) {
    const absl::StatusOr<mapping::RelationScore> score =
        mapping::ScoreRelations(planar, relations, options);
    if (!score.ok()) return score.status();
    absl::StrAppendFormat(&report.text, "%s: %d relations, %d left out\n",
                          which, score->used, score->left_out);
    absl::StrAppendFormat(&report.json, ",\n  \"%s\": %d", which, score->used);
    const std::string name = absl::StrCat(which, "_relations");
    Add(name.c_str(), "m", 1, score->translation_m, report.text, report.json);
    Add(name.c_str(), "deg", kDegPerRad, score->rotation_rad, report.text,
        report.json);
    return absl::OkStatus();
  };
  TL_RETURN_IF_ERROR(add("all", {}));
  // A recording may have none of these.
  const absl::Status exact = add("exact", {.max_gap_s = 1e-3});
  if (!exact.ok() && !absl::IsInvalidArgument(exact)) return exact;
  report.json += "\n}\n";
  return report;
}

absl::Status Score(const ScoreFlags& flags) {
  if (flags.reference.empty() == flags.relations.empty()) {
    return absl::InvalidArgumentError(
        "give --reference FILE or --relations FILE");
  }
  if (!flags.json.empty()) TL_RETURN_IF_ERROR(base::CheckWritable(flags.json));
  TL_ASSIGN_OR_RETURN(const std::vector<dataset::TimedPose> estimate,
                      map_app::ReadTrajectory(flags.estimate));
  TL_ASSIGN_OR_RETURN(const Report report,
                      flags.reference.empty()
                          ? AgainstRelations(flags, estimate)
                          : AgainstReference(flags, estimate));
  std::fputs(report.text.c_str(), stdout);
  return flags.json.empty()
             ? absl::OkStatus()
             : base::WriteFileAtomically(flags.json, report.json);
}

}  // namespace

cli::Command AddScoreTrajectoryCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "score-trajectory", "Compare a trajectory with a reference");
  command->footer(kFooter);
  auto flags = std::make_shared<ScoreFlags>();
  command->add_option("--estimate", flags->estimate, "The trajectory")
      ->type_name("FILE")
      ->required();
  command->add_option("--reference", flags->reference, "The true one")
      ->type_name("FILE");
  command
      ->add_option("--poses", flags->poses,
                   "Of a recording as the reference: these instead of its own, "
                   "as in treeline evaluate")
      ->type_name("FILE");
  command
      ->add_option("--relations", flags->relations,
                   "True relative poses between moments")
      ->type_name("FILE");
  command
      ->add_option("--interval", flags->interval_s,
                   "Relative errors are over so much time")
      ->type_name("S")
      ->capture_default_str();
  command
      ->add_option("--max-gap", flags->max_gap_s,
                   "The reference is interpolated between poses that are at "
                   "most this far apart")
      ->type_name("S")
      ->capture_default_str();
  command->add_option("--json", flags->json, "Write the figures")
      ->type_name("FILE");
  return {command,
          [flags](const std::stop_token& /*stop*/) { return Score(*flags); }};
}

}  // namespace treeline::score_app
