#include "simulation/runs/simulation_run.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "nav_agent/recording/agent_log.h"
#include "simulation/simulator/scenario_player.h"

namespace treeline::runs {
namespace {

constexpr simulator::SimTime kChunk = std::chrono::milliseconds(25);
// A robot that is stuck on its tour does not drive for ever.
constexpr double kSlowestTour_mps = 0.1;
constexpr double kTourPatience_s = 60;

double ProcessorSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) +
         1e-9 * static_cast<double>(now.tv_nsec);
}

std::string TextOf(const simulator::SimEvent& event) {
  const geometry::Vec3& at = event.point_in_world;
  std::string text =
      absl::StrFormat("%s at (%.2f, %.2f, %.2f)",
                      simulator::SimEventName(event.kind), at.x, at.y, at.z);
  if (event.what != simulator::SimEventName(event.kind)) {
    absl::StrAppend(&text, ": ", event.what);
  }
  if (event.kind == simulator::SimEventKind::kCollision) {
    absl::StrAppend(
        &text, event.caused_by_robot ? ", by the robot" : ", not by the robot");
  }
  return text;
}

// Writes what the sensors say, and the truth.
class Recorder {
 public:
  static absl::StatusOr<std::unique_ptr<Recorder>> Open(
      simulator::Simulator& simulator, const SimulationRunOptions& options) {
    auto recorder = std::make_unique<Recorder>();
    recorder->jpeg_quality_ = options.jpeg_quality;
    if (options.record_path.empty()) return recorder;
    TL_ASSIGN_OR_RETURN(recorder->log_,
                        recording::AgentLogWriter::Open(
                            options.record_path, false, recorder->clock_));
    const simulator::SimulatorOptions& sim = simulator.options();
    TL_RETURN_IF_ERROR(recorder->Write(recording::LogInformation{
        absl::StrCat("treeline-agent simulate, world ", simulator.world().name,
                     ", seed ", sim.seed)}));
    TL_RETURN_IF_ERROR(recorder->Write(sim.robot));
    TL_RETURN_IF_ERROR(recorder->Write(simulator.laser().Info()));
    if (sim.sensors.camera_hz > 0) {
      TL_RETURN_IF_ERROR(recorder->Write(simulator.camera().Calibration()));
    }
    return recorder;
  }

  bool is_open() const { return log_ != nullptr; }
  absl::Status Write(const recording::LogEntry& entry) {
    return log_ == nullptr ? absl::OkStatus() : log_->Write(entry);
  }
  absl::Status WriteFrame(const core::RgbdFrame& frame) {
    if (log_ == nullptr) return absl::OkStatus();
    TL_ASSIGN_OR_RETURN(recording::LogFrame encoded,
                        recording::EncodeLogFrame(frame, jpeg_quality_));
    return log_->Write(std::move(encoded));
  }
  absl::Status Close() {
    return log_ == nullptr ? absl::OkStatus() : log_->Flush();
  }

 private:
  base::SteadyClock clock_;
  int jpeg_quality_ = 92;
  std::unique_ptr<recording::AgentLogWriter> log_;
};

absl::Status TakeAll(simulator::Simulator& simulator, Recorder& recorder,
                     SimulationResult& result) {
  for (const core::BaseReading& reading : simulator.odometry().TakeReadings()) {
    ++result.readings;
    TL_RETURN_IF_ERROR(recorder.Write(reading));
  }
  for (core::LaserScan& scan : simulator.laser().TakeScans()) {
    ++result.scans;
    TL_RETURN_IF_ERROR(recorder.Write(std::move(scan)));
  }
  // Rendered only because somebody asks.
  for (const core::RgbdFrame& frame : simulator.camera().TakeFrames()) {
    ++result.frames;
    TL_RETURN_IF_ERROR(recorder.WriteFrame(frame));
  }
  const simulator::TrueState state = simulator.state();
  TL_RETURN_IF_ERROR(recorder.Write(recording::LogTruePose{
      simulator::SimClock::StampOf(state.time), state.world_from_base}));
  for (simulator::SimEvent& event : simulator.TakeEvents()) {
    if (event.kind == simulator::SimEventKind::kPlaced)
      result.track.emplace_back();
    TL_RETURN_IF_ERROR(recorder.Write(recording::LogEvent{
        simulator::SimClock::StampOf(event.time), TextOf(event)}));
    result.events.push_back(std::move(event));
  }
  result.track.back().push_back(state.world_from_base.translation);
  return absl::OkStatus();
}

}  // namespace

int SimulationResult::Count(simulator::SimEventKind kind) const {
  return static_cast<int>(
      std::ranges::count(events, kind, &simulator::SimEvent::kind));
}

int SimulationResult::CollisionsOfRobot() const {
  return static_cast<int>(
      std::ranges::count_if(events, [](const simulator::SimEvent& e) {
        return e.kind == simulator::SimEventKind::kCollision &&
               e.caused_by_robot;
      }));
}

absl::StatusOr<SimulationResult> RunSimulation(
    simulator::Simulator& simulator, const SimulationRunOptions& options,
    const std::function<void(double simulated_s)>& progress,
    const std::stop_token& stop) {
  SimulationResult result;
  result.world = simulator.world().name;
  result.seed = simulator.options().seed;
  result.track.emplace_back();
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<Recorder> recorder,
                      Recorder::Open(simulator, options));
  simulator::ScenarioPlayer player(options.scenario, simulator);
  simulator::SimTime duration = options.scenario.duration;
  const bool until_tour_ends =
      options.tour.has_value() && duration == simulator::SimTime(0);
  if (options.tour.has_value()) player.DriveTour(*options.tour);
  if (until_tour_ends && player.tour() != nullptr) {
    const simulator::TourDriver& tour = *player.tour();
    duration = simulator::FromSeconds(kTourPatience_s +
                                      tour.length_m() / kSlowestTour_mps);
    if (const double every_m = tour.options().look_around_every_m;
        every_m > 0) {
      duration +=
          simulator::FromSeconds((2 + tour.length_m() / every_m) *
                                 (3 + 7 / tour.options().look_around_radps));
    }
  }
  const double begin_s = ProcessorSeconds();
  while (simulator.now() < duration) {
    if (stop.stop_requested()) return absl::CancelledError();
    player.Step(std::min(kChunk, duration - simulator.now()));
    TL_RETURN_IF_ERROR(TakeAll(simulator, *recorder, result));
    progress(simulator::Seconds(simulator.now()));
    if (until_tour_ends &&
        (player.is_tour_done() || simulator.state().is_fallen)) {
      break;
    }
  }
  result.processor_s = ProcessorSeconds() - begin_s;
  result.simulated_s = simulator::Seconds(simulator.now());
  result.final_state = simulator.state();
  result.tour_done = player.is_tour_done();
  TL_RETURN_IF_ERROR(recorder->Close());
  return result;
}

std::string SimulationSummary(const SimulationResult& result) {
  std::string text = absl::StrFormat(
      "World '%s', seed %d: %.1f s simulated in %.2f s of processor time "
      "(factor %.0f)\n",
      result.world, result.seed, result.simulated_s, result.processor_s,
      result.Factor());
  absl::StrAppendFormat(
      &text,
      "Driven %.2f m, turned %.0f degrees; %d scans, %d readings, %d "
      "frames\n",
      result.final_state.distance_m,
      result.final_state.turned_rad * 57.29577951308232, result.scans,
      result.readings, result.frames);
  absl::StrAppendFormat(
      &text,
      "Collisions: %d, of them by the robot: %d. Falls: %d. Stairs: %d. "
      "Tipped over: %d\n",
      result.Count(simulator::SimEventKind::kCollision),
      result.CollisionsOfRobot(), result.Count(simulator::SimEventKind::kFall),
      result.Count(simulator::SimEventKind::kStairs),
      result.Count(simulator::SimEventKind::kTipped));
  for (const simulator::SimEvent& event : result.events) {
    absl::StrAppendFormat(&text, "%9.3f s  %s\n",
                          simulator::Seconds(event.time), TextOf(event));
  }
  return text;
}

std::string SimulationJson(const SimulationResult& result) {
  const geometry::Rigid3& pose = result.final_state.world_from_base;
  std::string json = absl::StrFormat(
      "{\n  \"world\": %s,\n  \"seed\": %d,\n  \"simulated_s\": %.3f,\n"
      "  \"processor_s\": %.4f,\n  \"factor\": %.2f,\n",
      base::JsonQuoted(result.world), result.seed, result.simulated_s,
      result.processor_s, result.Factor());
  absl::StrAppendFormat(
      &json,
      "  \"distance_m\": %.4f,\n  \"turned_rad\": %.4f,\n  \"scans\": %d,\n"
      "  \"readings\": %d,\n  \"frames\": %d,\n",
      result.final_state.distance_m, result.final_state.turned_rad,
      result.scans, result.readings, result.frames);
  absl::StrAppendFormat(
      &json,
      "  \"collisions\": %d,\n  \"collisions_by_robot\": %d,\n"
      "  \"falls\": %d,\n  \"stairs\": %d,\n  \"tipped\": %d,\n"
      "  \"tour_done\": %s,\n",
      result.Count(simulator::SimEventKind::kCollision),
      result.CollisionsOfRobot(), result.Count(simulator::SimEventKind::kFall),
      result.Count(simulator::SimEventKind::kStairs),
      result.Count(simulator::SimEventKind::kTipped),
      result.tour_done ? "true" : "false");
  absl::StrAppendFormat(&json,
                        "  \"final\": {\"x_m\": %.4f, \"y_m\": %.4f, "
                        "\"z_m\": %.4f, \"yaw_rad\": %.5f},\n  \"events\": [",
                        pose.translation.x, pose.translation.y,
                        pose.translation.z, geometry::Yaw_rad(pose.rotation));
  const char* separator = "\n";
  for (const simulator::SimEvent& event : result.events) {
    const geometry::Vec3& at = event.point_in_world;
    absl::StrAppendFormat(
        &json,
        "%s    {\"time_s\": %.3f, \"kind\": %s, \"what\": %s, \"x_m\": %.3f, "
        "\"y_m\": %.3f, \"z_m\": %.3f, \"by_robot\": %s, \"robot_mps\": %.3f, "
        "\"body_mps\": %.3f}",
        separator, simulator::Seconds(event.time),
        base::JsonQuoted(simulator::SimEventName(event.kind)),
        base::JsonQuoted(event.what), at.x, at.y, at.z,
        event.caused_by_robot ? "true" : "false", event.robot_approach_mps,
        event.body_approach_mps);
    separator = ",\n";
  }
  return json + "\n  ]\n}\n";
}

}  // namespace treeline::runs
