#include "tests/robot/testing_lost_robot.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "common/geometry/planar_pose.h"
#include "gtest/gtest.h"
#include "simulation/runs/localize_world.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/worlds/world.h"

namespace treeline {
namespace {

constexpr simulator::SimTime kStep = std::chrono::milliseconds(25);
constexpr localization::PoseCovariance2 kTold = {0.01, 0, 0, 0,     0.01,
                                                 0,    0, 0, 0.0025};

double FreeAhead_m(const std::vector<geometry::Vec2>& ends,
                   const core::RobotModel& robot) {
  double free_m = 3;
  for (const geometry::Vec2 end : ends) {
    if (std::abs(end.y) > robot.half_width_m + 0.05) continue;
    if (end.x > 0) free_m = std::min(free_m, end.x - robot.front_m - 0.05);
  }
  return std::max(0.0, free_m);
}

}  // namespace

const LostPlace& LostPlaceOf(const std::string& world) {
  static std::map<std::string, LostPlace> places;
  const auto found = places.find(world);
  if (found != places.end()) return found->second;
  const worlds::World made = *worlds::MakeWorld(
      world, {.with_people = false, .threads = 1, .paint = false});
  LostPlace place;
  place.world = world;
  place.voxels = *runs::VoxelsOfWorld(made, 0.05);
  place.levels = *traversability::ExtractTraversableMap(place.voxels);
  place.map = std::make_shared<const traversability::NavigationMap>(
      *traversability::NavigationMap::Make(place.levels));
  return places.emplace(world, std::move(place)).first->second;
}

void ScriptedServer::Ask(const core::RgbdFrame& frame, double timeout_s) {
  frame_ = frame;
  timeout_s_ = timeout_s;
  asked_at_ = clock_.Now();
  ++asked;
}

std::optional<ScriptedServer::Answer> ScriptedServer::TakeAnswer() {
  if (!frame_.has_value()) return std::nullopt;
  const double waited_s =
      std::chrono::duration<double>(clock_.Now() - asked_at_).count();
  if (waited_s >= timeout_s_) {
    frame_.reset();
    return Answer(absl::DeadlineExceededError("too slow"));
  }
  if (waited_s < delay_s) return std::nullopt;
  Answer answer = answers(*frame_);
  frame_.reset();
  return answer;
}

LostRobot::LostRobot(const LostPlace& place, uint64_t seed, bool with_people,
                     const behavior::RelocalizationBehaviorOptions& options,
                     bool with_server)
    : place_(place), random_(seed, 5) {
  simulator::Scenario scenario;
  scenario.world = place.world;
  scenario.options.seed = seed;
  worlds::World world = *worlds::MakeWorld(
      place.world, {.with_people = with_people, .threads = 1, .paint = false});
  scenario.options.start = *simulator::StartOf(scenario, world);
  simulator_ =
      *simulator::Simulator::Create(std::move(world), scenario.options);
  simulator_->Step(std::chrono::milliseconds(200));
  tracker_ = *localization::RobotTracker::Create(
      place.voxels, place.levels, simulator_->options().robot,
      simulator_->laser().Info(), {}, seed);
  server_ = std::make_unique<ScriptedServer>(simulator_->clock());
  server_->answers = [this](const core::RgbdFrame& frame) {
    return TrueAnswer(frame, 0.97);
  };
  lost_ = *behavior::RelocalizationBehavior::Create(
      place.map, simulator_->options().robot, *tracker_,
      with_server ? server_.get() : nullptr, options);
}

geometry::Rigid3 LostRobot::TruthAt(base::MonotonicTime stamp) const {
  return simulator_->WorldFromBaseAt(
      std::chrono::duration_cast<simulator::SimTime>(
          stamp - simulator::SimClock::StampOf(simulator::SimTime(0))));
}

core::LevelPose LostRobot::Truth() const {
  const geometry::Rigid3 pose = simulator_->state().world_from_base;
  return {.map_from_base = geometry::PlanarPose(pose),
          .place = {.level = 0, .height_m = pose.translation.z}};
}

core::RelocalizationAnswer LostRobot::AnswerFor(
    const geometry::Rigid3& map_from_base, const core::RgbdFrame& frame,
    double confidence) {
  core::RelocalizationAnswer answer;
  answer.stamp = frame.stamp;
  answer.localized = true;
  answer.confidence = confidence;
  answer.inliers = 200;
  answer.samples = 300;
  answer.scene = place_.world;
  answer.map_from_camera =
      map_from_base * simulator_->options().robot.base_from_camera;
  geometry::Vec3& at = answer.map_from_camera.translation;
  at = at + geometry::Vec3{0.03 * random_.NextGaussian(),
                           0.03 * random_.NextGaussian(),
                           0.03 * random_.NextGaussian()};
  answer.map_from_camera.rotation =
      geometry::Rotation3::FromAxisAngle({0.008 * random_.NextGaussian(),
                                          0.008 * random_.NextGaussian(),
                                          0.015 * random_.NextGaussian()}) *
      answer.map_from_camera.rotation;
  for (size_t i = 0; i < 36; i += 7)
    answer.covariance[i] = i < 21 ? 9e-4 : 2e-4;
  return answer;
}

core::RelocalizationAnswer LostRobot::TrueAnswer(const core::RgbdFrame& frame,
                                                 double confidence) {
  // The robot stands; the frame is not long ago.
  return AnswerFor(simulator_->state().world_from_base, frame, confidence);
}

void LostRobot::Feed() {
  for (const core::BaseReading& reading :
       simulator_->odometry().TakeReadings()) {
    EXPECT_TRUE(tracker_->AddReading(reading).ok());
  }
  for (const core::LaserScan& scan : simulator_->laser().TakeScans()) {
    EXPECT_TRUE(tracker_->AddScan(scan).ok());
  }
}

void LostRobot::TellTruth() {
  Feed();
  const absl::Status told = tracker_->SetPose(Truth(), kTold, Now());
  EXPECT_TRUE(told.ok()) << told;
}

bool LostRobot::CarryAway(uint64_t seed) {
  base::Random random(seed, 3);
  for (int i = 0; i < 2000; ++i) {
    const int level = static_cast<int>(
        random.NextBelow(static_cast<uint32_t>(place_.map->levels())));
    const core::OccupancyGrid& grid = place_.map->grid(level);
    const core::CellIndex cell = {
        static_cast<int>(random.NextBelow(static_cast<uint32_t>(grid.width))),
        static_cast<int>(random.NextBelow(static_cast<uint32_t>(grid.height)))};
    const double yaw_rad =
        random.NextUniform(-std::numbers::pi, std::numbers::pi);
    if (place_.map->ClearanceAt_m(level, cell) < 0.5) continue;
    const geometry::Vec2 at = grid.CenterInMap(cell);
    const auto ground = place_.map->GroundOf(at, level);
    if (!ground.has_value()) continue;
    if (simulator_
            ->Kidnap({.position = at,
                      .yaw_rad = yaw_rad,
                      .height_m = ground->height_m})
            .ok()) {
      return true;
    }
  }
  return false;
}

behavior::RelocalizationBehavior::Output LostRobot::Step(
    const core::VelocityCommand& drives) {
  simulator_->Step(kStep);
  Feed();
  // A camera of 10 Hz, whose pictures nobody looks at.
  if (++steps_ % 4 == 0) {
    core::RgbdFrame frame;
    frame.stamp = Now();
    frame.sequence = steps_ / 4;
    lost_->AddFrame(frame);
  }
  const std::vector<geometry::Vec2> ends = tracker_->ScanInBase();
  const core::RobotModel& robot = simulator_->options().robot;
  behavior::RelocalizationInput input;
  input.now = Now();
  input.drives_straight = drives.forward_mps > 0;
  input.free_ahead_m = FreeAhead_m(ends, robot);
  const double round_m = robot.Circumradius_m() + 0.03;
  input.can_turn = std::ranges::none_of(
      ends,
      [round_m](const geometry::Vec2& end) { return Norm(end) < round_m; });
  const behavior::RelocalizationBehavior::Output output = lost_->Step(input);
  for (behavior::RelocalizationNote& note : lost_->TakeNotes())
    notes.push_back(std::move(note));
  const core::VelocityCommand command =
      lost_->IsActive() ? output.wanted : drives;
  simulator_->base().SetVelocity(command).IgnoreError();
  return output;
}

behavior::RelocalizationState LostRobot::StepUntilDone(double at_most_s) {
  for (int i = 0; i < 40 * at_most_s; ++i) {
    const behavior::RelocalizationState state = Step().state;
    if (state == behavior::RelocalizationState::kFound ||
        state == behavior::RelocalizationState::kNeedHelp) {
      return state;
    }
  }
  return lost_->state();
}

double LostRobot::Error_m() const {
  const auto pose = tracker_->Pose();
  if (!pose.has_value()) return 1e9;
  return Norm(pose->pose.map_from_base.translation -
              Truth().map_from_base.translation);
}

double LostRobot::Error_rad() const {
  const auto pose = tracker_->Pose();
  if (!pose.has_value()) return 1e9;
  return std::abs(geometry::NormalizedAngle_rad(
      pose->pose.map_from_base.yaw_rad - Truth().map_from_base.yaw_rad));
}

bool LostRobot::IsRight() const {
  const auto pose = tracker_->Pose();
  return pose.has_value() && Error_m() < 0.5 && Error_rad() < 0.35 &&
         std::abs(pose->pose.place.height_m - Truth().place.height_m) < 0.5;
}

}  // namespace treeline
