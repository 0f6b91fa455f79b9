// What gets in a robot's way on a mission: people who walk about, things that
// stand on its path all of a sudden.
#ifndef EVALUATION_MISSIONS_MISSION_TROUBLE_H_
#define EVALUATION_MISSIONS_MISSION_TROUBLE_H_

#include <optional>
#include <string>

#include "evaluation/suites/suite_robot.h"
#include "evaluation/suites/suite_route.h"

namespace treeline::missions {

// Lets `count` more people walk to and fro on straight ways of 3 to 8 m, not
// near the route's start and without resting at its goal. They mind nobody. How
// many found room; none in a world that has no person.
int AddPassers(const suites::SuitePlace& place, const suites::Route& route,
               int count, uint64_t seed, worlds::World& world);

enum class Surprise {
  kNone,
  kCrate,  // stands on the path, somewhere ahead
  kDoor,   // a crate stands where the path ahead is narrowest
  kPerson  // steps in front of the robot, and goes after a while
};
const char* SurpriseName(Surprise surprise);

struct TroubleOptions {
  Surprise surprise = Surprise::kNone;
  // When the robot has driven this share of its way.
  double at_share = 0.4;
  double way_m = 0;
  simulator::RobotPlacement goal;
  uint64_t seed = 0;
};

// Puts one thing into a robot's way. A crate stays where there is a way around
// it, with room for a round robot that holds the real one; otherwise, like a
// person, it is taken away again after kSurpriseStays_s.
class MissionDisturbance {
 public:
  static constexpr double kSurpriseStays_s = 8;
  // Nothing appears nearer to the robot's middle than this.
  static constexpr double kNearest_m = 1.2;

  explicit MissionDisturbance(const TroubleOptions& options)
      : options_(options) {}

  // After each step of the robot.
  void Step(suites::SuiteRobot& robot);
  // What stood where, for people; empty: nothing yet.
  const std::string& what() const { return what_; }

 private:
  // A point of the path ahead where it may stand.
  std::optional<geometry::Vec3> PointAhead(
      const suites::SuiteRobot& robot,
      const behavior::NavigatorSnapshot& snapshot) const;
  bool Place(suites::SuiteRobot& robot, geometry::Vec3 at);

  TroubleOptions options_;
  bool is_done_ = false;
  std::optional<double> leaves_at_s_;
  double next_try_s_ = 0;
  std::string what_;
};

}  // namespace treeline::missions

#endif  // EVALUATION_MISSIONS_MISSION_TROUBLE_H_
