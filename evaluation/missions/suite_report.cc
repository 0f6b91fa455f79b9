#include "evaluation/missions/suite_report.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::missions {
namespace {

struct Tally {
  int runs = 0;
  int good = 0;
  int arrived = 0;
  int collisions_of_robot = 0;
  int collisions = 0;
  int stairs = 0;
  int edges = 0;
  int false_losses = 0;
  double driven_m = 0;
  double simulated_s = 0;
  double way_m = 0;
  double goal_error_m = 0;
  suites::StepTimes times;

  void Add(const MissionRun& run) {
    ++runs;
    good += run.IsGood() ? 1 : 0;
    arrived += run.outcome == MissionOutcome::kArrived ? 1 : 0;
    collisions_of_robot += run.collisions_of_robot;
    collisions += run.collisions;
    stairs += run.stair_entries;
    edges += run.edge_entries;
    false_losses += run.false_losses;
    driven_m += run.driven_m;
    simulated_s += run.simulated_s;
    way_m += run.mission.way_m;
    if (run.outcome == MissionOutcome::kArrived) {
      goal_error_m = std::max(goal_error_m, run.goal_error.distance_m);
    }
    times.Add(run.times);
  }
};

std::string Row(const std::string& name, const Tally& tally) {
  return absl::StrFormat(
      "%-14s %5d %8d %6.1f %% %6d /%4d %6d %6d %7.0f %8.0f %6.2f\n", name,
      tally.runs, tally.good,
      tally.runs > 0 ? 100.0 * tally.good / tally.runs : 0.0,
      tally.collisions_of_robot, tally.collisions, tally.stairs, tally.edges,
      tally.driven_m, tally.simulated_s,
      tally.way_m > 0 ? tally.driven_m / tally.way_m : 0.0);
}

// Worlds in the order in which they come.
std::vector<std::pair<std::string, Tally>> TalliesOf(
    const std::vector<MissionRun>& runs) {
  std::vector<std::pair<std::string, Tally>> tallies;
  for (const MissionRun& run : runs) {
    const std::string name =
        run.scene.empty() ? run.world : absl::StrCat("scene ", run.scene);
    auto it =
        std::ranges::find(tallies, name, &std::pair<std::string, Tally>::first);
    if (it == tallies.end()) {
      it = tallies.insert(tallies.end(), {name, Tally()});
    }
    it->second.Add(run);
  }
  return tallies;
}

// Who came towards whom, and where the robot was touched.
std::string CollisionText(const simulator::SimEvent& event) {
  const geometry::Vec3 in_base =
      event.world_from_base.Inverse() * event.point_in_world;
  return absl::StrFormat(
      ", %sby the robot (%.2f m/s; the other %.2f m/s), at (%.2f, %.2f) of it",
      event.caused_by_robot ? "" : "not ", event.robot_approach_mps,
      event.body_approach_mps, in_base.x, in_base.y);
}

std::string RunJson(const MissionRun& run) {
  std::string json = absl::StrFormat(
      "    {\"world\": %s, \"seed\": %d, \"scene\": %s, \"outcome\": \"%s\", "
      "\"good\": %s, \"cause\": \"%s\", \"why\": %s,\n",
      JsonQuoted(run.world), run.seed, JsonQuoted(run.scene),
      MissionOutcomeName(run.outcome), run.IsGood() ? "true" : "false",
      core::NavigationCauseName(run.cause), JsonQuoted(run.why));
  absl::StrAppendFormat(
      &json,
      "     \"start\": %s, \"goal\": %s, \"shortest_way_m\": %.3f, "
      "\"surprise\": %s, \"passers\": %d,\n",
      PlacementJson(run.mission.start), PlacementJson(run.mission.goal),
      run.mission.way_m, JsonQuoted(run.surprise), run.mission.passers);
  absl::StrAppendFormat(
      &json,
      "     \"simulated_s\": %.3f, \"path_m\": %.3f, \"collisions\": %d, "
      "\"collisions_by_robot\": %d, \"stair_entries\": %d, "
      "\"edge_entries\": %d, \"replans\": %d, \"recoveries\": %d, "
      "\"false_losses\": %d,\n",
      run.simulated_s, run.driven_m, run.collisions, run.collisions_of_robot,
      run.stair_entries, run.edge_entries, run.replans, run.recoveries,
      run.false_losses);
  absl::StrAppendFormat(
      &json,
      "     \"goal_error\": %s, \"estimate_error\": %s,\n     \"steps\": %s}",
      PoseMissJson(run.goal_error), PoseMissJson(run.estimate_error),
      StepTimesJson(run.times));
  return json;
}

}  // namespace

std::string JsonQuoted(absl::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      absl::StrAppendFormat(&out, "\\u%04x", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string StepTimesJson(const suites::StepTimes& times) {
  return absl::StrFormat(
      "{\"count\": %d, \"missed_deadlines\": %d, \"total_ms\": %.1f, "
      "\"p50_below_ms\": %.2f, \"p99_below_ms\": %.2f, \"highest_ms\": %.2f, "
      "\"plans\": %d, \"late_plans\": %d, \"planning_ms\": %.2f, "
      "\"longest_planning_ms\": %.2f}",
      times.steps, times.missed, times.total_ms, times.Percentile_ms(0.5),
      times.Percentile_ms(0.99), times.highest_ms, times.plans.plans,
      times.plans.late, times.plans.total_ms, times.plans.longest_ms);
}

std::string PoseMissJson(const suites::PoseMiss& error) {
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

double GoodShare(const std::vector<MissionRun>& runs) {
  if (runs.empty()) return 0;
  return static_cast<double>(std::ranges::count_if(
             runs, [](const MissionRun& run) { return run.IsGood(); })) /
         static_cast<double>(runs.size());
}

std::string MissionSummary(const std::vector<MissionRun>& runs, int expected) {
  std::string text =
      "                               good  collisions            edges  "
      "driven     time driven/\n"
      "world           runs     good  share   robot / all stairs (falls)     "
      "(m)      (s) shortest\n";
  Tally all;
  for (const auto& [name, tally] : TalliesOf(runs)) {
    text += Row(name, tally);
  }
  for (const MissionRun& run : runs) all.Add(run);
  text += Row("all", all);
  absl::StrAppendFormat(
      &text,
      "Furthest from a goal at which it said that it had arrived: %.2f m. "
      "Believed to be lost, and was not: %d times.\n"
      "A step of the navigator took up to %.2f ms (p99), %.1f ms at worst; %d "
      "of %d took longer than 25 ms.\n"
      "%d plans beside them: %.1f ms each, %.1f ms at worst; %d would have "
      "been later than %d steps.\n",
      all.goal_error_m, all.false_losses, all.times.Percentile_ms(0.99),
      all.times.highest_ms, all.times.missed, all.times.steps,
      all.times.plans.plans,
      all.times.plans.total_ms / std::max(1, all.times.plans.plans),
      all.times.plans.longest_ms, all.times.plans.late,
      suites::kSuitePlanSteps);
  if (static_cast<int>(runs.size()) < expected) {
    absl::StrAppendFormat(&text, "%d of %d missions were not run.\n",
                          expected - static_cast<int>(runs.size()), expected);
  }
  for (const MissionRun& run : runs) {
    if (run.IsGood()) continue;
    absl::StrAppendFormat(
        &text, "  %s%s seed %d: %s (%s) after %.0f s%s%s%s\n", run.world,
        run.scene.empty() ? "" : absl::StrCat(", scene ", run.scene), run.seed,
        MissionOutcomeName(run.outcome), core::NavigationCauseName(run.cause),
        run.simulated_s, run.why.empty() ? "" : ": ", run.why,
        run.collisions_of_robot > 0
            ? absl::StrFormat("; %d collisions", run.collisions_of_robot)
            : "");
  }
  return text;
}

std::string MissionJson(const std::vector<MissionRun>& runs, int expected,
                        bool people) {
  Tally all;
  for (const MissionRun& run : runs) all.Add(run);
  std::string json = absl::StrFormat(
      "{\n  \"suite\": \"missions\",\n  \"people\": %s,\n  \"expected\": %d,\n"
      "  \"runs\": %d,\n  \"good\": %d,\n  \"arrived\": %d,\n"
      "  \"collisions\": %d,\n  \"collisions_by_robot\": %d,\n"
      "  \"stair_entries\": %d,\n  \"edge_entries\": %d,\n"
      "  \"missed_deadlines\": %d,\n  \"missions\": [",
      people ? "true" : "false", expected, all.runs, all.good, all.arrived,
      all.collisions, all.collisions_of_robot, all.stairs, all.edges,
      all.times.missed);
  const char* separator = "\n";
  for (const MissionRun& run : runs) {
    absl::StrAppend(&json, separator, RunJson(run));
    separator = ",\n";
  }
  return json + "\n  ]\n}\n";
}

absl::Status WriteRunPicture(
    const std::string& stem, const worlds::World& world,
    const runs::SimulationResult& record, const runs::PlanMarks& marks,
    const std::vector<behavior::NavigatorEvent>& events,
    const std::string& title) {
  const simulator::Terrain terrain(world);
  TL_ASSIGN_OR_RETURN(
      const std::string png,
      image::EncodePng(runs::DrawPlan(world, terrain, record, marks)));
  TL_RETURN_IF_ERROR(base::MakeParentFolder(stem + ".png"));
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(stem + ".png", png));
  std::string text = title + "\n";
  // Both in the order of time.
  size_t next = 0;
  const auto add_until = [&](double time_s) {
    for (; next < events.size(); ++next) {
      const behavior::NavigatorEvent& event = events[next];
      const double at_s =
          std::chrono::duration<double>(event.stamp.time_since_epoch()).count();
      if (at_s > time_s) break;
      absl::StrAppendFormat(&text, "%9.3f s  %s: %s\n", at_s, event.kind,
                            event.text);
    }
  };
  for (const simulator::SimEvent& event : record.events) {
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

}  // namespace treeline::missions
