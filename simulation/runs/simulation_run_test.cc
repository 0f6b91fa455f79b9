#include "simulation/runs/simulation_run.h"

#include <unistd.h>

#include <string>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/recording/agent_log.h"
#include "simulation/runs/plan_picture.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/scenario_reader.h"

namespace treeline::runs {
namespace {

using testing::HasSubstr;

struct Ran {
  SimulationResult result;
  std::unique_ptr<simulator::Simulator> simulator;
};

// Five seconds straight ahead from the cafe's tour, with a kidnap in between.
Ran RunInCafe(const std::string& record_path) {
  SimulationRunOptions run;
  run.scenario = *simulator::ParseScenario(
      "world: cafe\nseed: 4\npeople: false\nduration_s: 5\nactions:\n"
      "  - {at_s: 0, drive: {forward_mps: 0.4, for_s: 5}}\n"
      "  - {at_s: 3, kidnap: {place: terrace}}\n",
      "test");
  run.record_path = record_path;
  worlds::World world = *worlds::MakeWorld(
      "cafe", {.with_people = false, .threads = 1, .paint = false});
  run.scenario.options.start = *simulator::StartOf(run.scenario, world);
  auto simulator =
      *simulator::Simulator::Create(std::move(world), run.scenario.options);
  auto result = RunSimulation(*simulator, run, [](double) {}, {});
  EXPECT_TRUE(result.ok()) << result.status();
  return {*std::move(result), std::move(simulator)};
}

TEST(SimulationRun, RecordsWhatIsMeasuredAndWhatIsTrue) {
  const std::string path =
      absl::StrCat(testing::TempDir(), "/simulation_run_", getpid());
  unlink(path.c_str());
  const SimulationResult result = RunInCafe(path).result;
  auto reader = recording::AgentLogReader::Open(path);
  ASSERT_TRUE(reader.ok()) << reader.status();
  int64_t scans = 0;
  int64_t readings = 0;
  int64_t events = 0;
  geometry::Vec3 last_position;
  while (const auto entry = reader->Next()) {
    scans += std::holds_alternative<core::LaserScan>(*entry) ? 1 : 0;
    readings += std::holds_alternative<core::BaseReading>(*entry) ? 1 : 0;
    events += std::holds_alternative<recording::LogEvent>(*entry) ? 1 : 0;
    if (const auto* truth = std::get_if<recording::LogTruePose>(&*entry)) {
      last_position = truth->world_from_base.translation;
    }
  }
  unlink(path.c_str());
  // 200 of 5 s; the last is on its way.
  EXPECT_EQ(scans, 200);
  EXPECT_EQ(scans, result.scans);
  EXPECT_EQ(readings, result.readings);
  EXPECT_EQ(events, static_cast<int64_t>(result.events.size()));
  EXPECT_EQ(last_position, result.final_state.world_from_base.translation);
  EXPECT_EQ(reader->damaged_bytes(), 0);
}

TEST(SimulationRun, IsTheSameEachTimeButForTheProcessor) {
  SimulationResult a = RunInCafe("").result;
  SimulationResult b = RunInCafe("").result;
  a.processor_s = 1;
  b.processor_s = 1;
  EXPECT_EQ(SimulationJson(a), SimulationJson(b));
  EXPECT_EQ(SimulationSummary(a), SimulationSummary(b));
  EXPECT_THAT(SimulationJson(a), HasSubstr("\"kind\": \"placed\""));
  EXPECT_THAT(SimulationSummary(a), HasSubstr("factor 5"));
  // The kidnap begins a new line of the track.
  EXPECT_EQ(a.track.size(), 2u);
}

TEST(SimulationRun, StopsWhenAskedTo) {
  std::stop_source stop;
  SimulationRunOptions run;
  run.scenario.duration = std::chrono::seconds(1000);
  worlds::World world =
      *worlds::MakeWorld("cafe", {.threads = 1, .paint = false});
  run.scenario.options.start = *simulator::StartOf(run.scenario, world);
  auto simulator =
      *simulator::Simulator::Create(std::move(world), run.scenario.options);
  const auto result = RunSimulation(
      *simulator, run, [&](double) { stop.request_stop(); }, stop.get_token());
  EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled);
  EXPECT_LT(simulator::Seconds(simulator->now()), 1);
}

TEST(PlanPicture, ShowsTheTrackInTheWorld) {
  const Ran ran = RunInCafe("");
  const image::ColorImage plan =
      DrawPlan(ran.simulator->world(), ran.simulator->terrain(), ran.result);
  // 13 x 10 m and a margin, at most 1600 pixels.
  EXPECT_GT(plan.width, 1200);
  EXPECT_LE(plan.width, 1600);
  int track = 0;
  int ramp = 0;
  for (size_t i = 0; i + 2 < plan.rgb.size(); i += 3) {
    track += plan.rgb[i] == 30 && plan.rgb[i + 2] == 220 ? 1 : 0;
    ramp += plan.rgb[i] > 190 && plan.rgb[i + 2] < 130 ? 1 : 0;
  }
  // 2 m of 3 pixels at a centimetre each, twice; a ramp of 5.1 x 1.5 m.
  EXPECT_GT(track, 500);
  EXPECT_GT(ramp, 40000);
}

}  // namespace
}  // namespace treeline::runs
