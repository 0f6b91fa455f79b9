#include "evaluation/suites/suite_report.h"

#include <algorithm>
#include <chrono>

#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/json_text.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::suites {
namespace {

// Who came towards whom, and where the robot was touched.
std::string CollisionText(const simulator::SimEvent& event) {
  const geometry::Vec3 in_base =
      event.world_from_base.Inverse() * event.point_in_world;
  return absl::StrFormat(
      ", %sby the robot (%.2f m/s; the other %.2f m/s), at (%.2f, %.2f) of it",
      event.caused_by_robot ? "" : "not ", event.robot_approach_mps,
      event.body_approach_mps, in_base.x, in_base.y);
}

}  // namespace

double NearestQuantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<size_t>(
      share * static_cast<double>(values.size() - 1) + 0.5)];
}

std::string NotRunText(size_t done, int expected, const std::string& runs) {
  const int missing = expected - static_cast<int>(done);
  if (missing <= 0) return {};
  return absl::StrFormat("%d of %d %s were not run.\n", missing, expected,
                         runs);
}

std::string CollisionsText(const SuiteRun& run) {
  if (run.collisions_of_robot == 0) return {};
  return absl::StrFormat("; %d collisions", run.collisions_of_robot);
}

absl::Status WriteRunPicture(const std::string& stem,
                             const worlds::World& world, const SuiteRun& run,
                             const std::string& title) {
  const simulator::Terrain terrain(world);
  TL_ASSIGN_OR_RETURN(
      const std::string png,
      image::EncodePng(runs::DrawPlan(world, terrain, run.record, run.marks)));
  TL_RETURN_IF_ERROR(base::MakeParentFolder(stem + ".png"));
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(stem + ".png", png));
  std::string text = title + "\n";
  // Both in the order of time.
  size_t next = 0;
  const auto add_until = [&](double time_s) {
    for (; next < run.events.size(); ++next) {
      const behavior::NavigatorEvent& event = run.events[next];
      const double at_s =
          std::chrono::duration<double>(event.stamp.time_since_epoch()).count();
      if (at_s > time_s) break;
      absl::StrAppendFormat(&text, "%9.3f s  %s: %s\n", at_s, event.kind,
                            event.text);
    }
  };
  for (const simulator::SimEvent& event : run.record.events) {
    add_until(simulator::Seconds(event.time));
    absl::StrAppendFormat(&text, "%9.3f s  ## %s %s at (%.2f, %.2f, %.2f)%s\n",
                          simulator::Seconds(event.time),
                          simulator::SimEventName(event.kind), event.what,
                          event.point_in_world.x, event.point_in_world.y,
                          event.point_in_world.z,
                          event.kind != simulator::SimEventKind::kCollision
                              ? ""
                              : CollisionText(event));
  }
  add_until(1e18);
  return base::WriteFileAtomically(stem + ".txt", text);
}

std::string StepTimesJson(const StepTimes& times) {
  return absl::StrFormat(
      "{\"count\": %d, \"missed_deadlines\": %d, \"total_ms\": %.1f, "
      "\"p50_below_ms\": %.2f, \"p99_below_ms\": %.2f, \"highest_ms\": %.2f, "
      "\"plans\": %d, \"late_plans\": %d, \"planning_ms\": %.2f, "
      "\"longest_planning_ms\": %.2f}",
      times.steps, times.missed, times.total_ms, times.Percentile_ms(0.5),
      times.Percentile_ms(0.99), times.highest_ms, times.plans.plans,
      times.plans.late, times.plans.total_ms, times.plans.longest_ms);
}

std::string PoseMissJson(const PoseMiss& error) {
  return absl::StrFormat(
      "{\"distance_m\": %.4f, \"turn_deg\": %.3f, \"height_m\": %.3f}",
      error.distance_m, error.turn_deg, error.height_m);
}

std::string PlacementJson(const simulator::RobotPlacement& placement) {
  return absl::StrFormat(
      "{\"x_m\": %.3f, \"y_m\": %.3f, \"yaw_rad\": %.4f, \"height_m\": %.3f}",
      placement.position.x, placement.position.y, placement.yaw_rad,
      placement.height_m);
}

std::string RunHeadJson(const SuiteRun& run,
                        const std::pair<std::string, std::string>& kind,
                        const std::string& outcome, bool is_good) {
  return absl::StrFormat(
      "    {\"world\": %s, \"seed\": %d, \"%s\": %s, \"outcome\": \"%s\", "
      "\"good\": %s, \"cause\": \"%s\", \"why\": %s,\n",
      base::JsonQuoted(run.world), run.seed, kind.first, kind.second, outcome,
      is_good ? "true" : "false", core::NavigationCauseName(run.cause),
      base::JsonQuoted(run.why));
}

std::string DriveJson(const SuiteRun& run) {
  return absl::StrFormat(
      "\"simulated_s\": %.3f, \"path_m\": %.3f, \"collisions\": %d, "
      "\"collisions_by_robot\": %d, \"stair_entries\": %d, "
      "\"edge_entries\": %d",
      run.simulated_s, run.driven_m, run.collisions, run.collisions_of_robot,
      run.stair_entries, run.edge_entries);
}

}  // namespace treeline::suites
