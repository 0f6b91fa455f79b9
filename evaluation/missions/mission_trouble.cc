#include "evaluation/missions/mission_trouble.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/random.h"
#include "evaluation/suites/suite_people.h"

namespace treeline::missions {
namespace {

constexpr const char* kSurpriseObject = "surprise";
constexpr worlds::Float3 kCrateScale = {0.4f, 0.4f, 0.8f};
constexpr double kCrateRadius_m = 0.29;
// Up to so far ahead something is put onto the path.
constexpr double kFurthest_m = 3.5;
constexpr double kTryEvery_s = 0.25;
constexpr double kPasserFrom_m = 3;
constexpr double kPasserTo_m = 8;
constexpr double kClearOfStart_m = 1.5;
constexpr double kClearOfGoal_m = 1.2;

double DistanceToWay_m(geometry::Vec2 point, geometry::Vec2 from,
                       geometry::Vec2 to) {
  const geometry::Vec2 way = to - from;
  const double t =
      std::clamp(Dot(point - from, way) / (Dot(way, way) + 1e-9), 0.0, 1.0);
  return Norm(from + t * way - point);
}

}  // namespace

const char* SurpriseName(Surprise surprise) {
  switch (surprise) {
    case Surprise::kNone:
      return "none";
    case Surprise::kCrate:
      return "crate";
    case Surprise::kDoor:
      return "narrow";
    case Surprise::kPerson:
      return "person";
  }
  return "unknown";
}

int AddPassers(const suites::SuitePlace& place, const suites::Route& route,
               int count, uint64_t seed, worlds::World& world) {
  const int person = suites::PersonOf(world);
  if (person < 0) return 0;
  base::Random random(seed, 201);
  int added = 0;
  for (int i = 0; i < 400 * count && added < count; ++i) {
    const simulator::RobotPlacement from = place.AnyPlace(random);
    const simulator::RobotPlacement to = place.AnyPlace(random);
    const double way_m = Norm(to.position - from.position);
    if (way_m < kPasserFrom_m || way_m > kPasserTo_m ||
        std::abs(to.height_m - from.height_m) > 0.05 ||
        DistanceToWay_m(route.start.position, from.position, to.position) <
            kClearOfStart_m ||
        Norm(from.position - route.goal.position) < kClearOfGoal_m ||
        Norm(to.position - route.goal.position) < kClearOfGoal_m ||
        !place.IsStraightWay(from, to)) {
      continue;
    }
    worlds::Body body = world.bodies[static_cast<size_t>(person)];
    body.name = absl::StrCat("passer ", added + 1);
    const double walk_mps = random.NextUniform(0.6, 1.1);
    const double pause_s = random.NextUniform(2, 6);
    body.motion = suites::ToAndFro(from, to, walk_mps, pause_s);
    world.bodies.push_back(std::move(body));
    ++added;
  }
  return added;
}

std::optional<geometry::Vec3> MissionDisturbance::PointAhead(
    const suites::SuiteRobot& robot,
    const behavior::NavigatorSnapshot& snapshot) const {
  const std::vector<core::LevelPose>& path = snapshot.path;
  if (path.size() < 2 || !snapshot.pose.has_value()) return std::nullopt;
  const geometry::Vec2 here = snapshot.pose->pose.map_from_base.translation;
  size_t nearest = 0;
  for (size_t i = 0; i < path.size(); ++i) {
    if (Norm(path[i].map_from_base.translation - here) <
        Norm(path[nearest].map_from_base.translation - here)) {
      nearest = i;
    }
  }
  const double wanted_m =
      options_.surprise == Surprise::kPerson ? kNearest_m + 0.1 : 2.0;
  std::optional<geometry::Vec3> best;
  double best_score = std::numeric_limits<double>::infinity();
  double along_m = 0;
  for (size_t i = nearest + 1; i < path.size(); ++i) {
    const geometry::Vec2 at = path[i].map_from_base.translation;
    along_m += Norm(at - path[i - 1].map_from_base.translation);
    if (along_m > kFurthest_m) break;
    if (Norm(at - here) < kNearest_m) continue;
    double score = std::abs(along_m - wanted_m);
    if (options_.surprise == Surprise::kDoor) {
      score = robot.place().ClearanceInMap_m(path[i]);
    }
    if (score >= best_score) continue;
    best_score = score;
    best = robot.place().InWorld(at, path[i].place.height_m);
  }
  return best;
}

bool MissionDisturbance::Place(suites::SuiteRobot& robot, geometry::Vec3 at) {
  simulator::Simulator& simulator = robot.simulator();
  const bool is_person = options_.surprise == Surprise::kPerson;
  std::string body = "crate";
  if (is_person) {
    const int person = suites::PersonOf(simulator.world());
    if (person < 0) return false;
    body = simulator.world().bodies[static_cast<size_t>(person)].name;
  }
  const simulator::RobotPlacement placement = {
      .position = {at.x, at.y}, .yaw_rad = 0, .height_m = at.z};
  if (!simulator
           .AddObstacle(kSurpriseObject, body, placement,
                        is_person ? worlds::Float3{1, 1, 1} : kCrateScale)
           .ok()) {
    return false;
  }
  const bool stays =
      !is_person &&
      robot.place()
          .PathLength_m(suites::PlacementOf(simulator.state().world_from_base),
                        options_.goal,
                        {{.center = at, .radius_m = kCrateRadius_m}})
          .has_value();
  if (!stays) leaves_at_s_ = robot.now_s() + kSurpriseStays_s;
  what_ = absl::StrFormat("%s at (%.2f, %.2f) after %.1f s%s",
                          SurpriseName(options_.surprise), at.x, at.y,
                          robot.now_s(), stays ? "" : ", for 8 s");
  return true;
}

void MissionDisturbance::Step(suites::SuiteRobot& robot) {
  if (leaves_at_s_.has_value() && robot.now_s() >= *leaves_at_s_) {
    robot.simulator().RemoveObstacle(kSurpriseObject).IgnoreError();
    leaves_at_s_.reset();
  }
  if (is_done_ || options_.surprise == Surprise::kNone ||
      robot.now_s() < next_try_s_) {
    return;
  }
  next_try_s_ = robot.now_s() + kTryEvery_s;
  const simulator::TrueState state = robot.simulator().state();
  if (state.distance_m < options_.at_share * options_.way_m ||
      robot.navigator().mode() != behavior::NavigatorMode::kDriving) {
    return;
  }
  const std::optional<geometry::Vec3> at =
      PointAhead(robot, robot.navigator().Snapshot());
  if (at.has_value()) is_done_ = Place(robot, *at);
}

}  // namespace treeline::missions
