// Fields of cylinders, driven through as in the BARN challenge and DynaBARN:
// the goal is straight ahead, nothing is known beforehand, a touch ends it.
// docs/reference/suites.md.
#ifndef EVALUATION_FIELDS_FIELD_SUITE_H_
#define EVALUATION_FIELDS_FIELD_SUITE_H_

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "evaluation/fields/best_way.h"
#include "evaluation/suites/suite_run.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/mapless/mapless_navigator.h"

namespace treeline::fields {

// Of the challenge (its run.py): how near the goal must be, after how long a
// run ends, and the speed of its optimal time.
inline constexpr double kReached_m = 1.0;
inline constexpr double kLongest_s = 100;
inline constexpr double kOptimal_mps = 2.0;

enum class FieldOutcome : uint8_t {
  kReached,
  kTouched,  // it ran into something; the run ends there
  kStruck,   // something ran into it while it stood; there, too
  kFailed,   // it gave up: cause and why
  kTimeout
};
const char* FieldOutcomeName(FieldOutcome outcome);

// In the frame of the world's file; of a world of Gazebo, in Gazebo's.
struct FieldEnds {
  geometry::Rigid2 start;
  geometry::Vec2 goal;
};

// The challenge's, in Gazebo's world: INIT_POSITION and GOAL_POSITION of its
// run.py.
inline constexpr FieldEnds kBarnEnds = {
    .start = {.translation = {-2.25, 3}, .yaw_rad = 1.57}, .goal = {-2.25, 13}};

struct FieldOptions {
  // "field:N", "moving-field:N", or a file.
  std::string world;
  // nullopt: the places "start" and "goal"; of a world of Gazebo, kBarnEnds.
  std::optional<FieldEnds> ends{};
  // What moves there moves; false: it is left out.
  bool with_movers = false;
  // Of the sensors' and the wheels' noise.
  uint64_t seed = 0;
  core::RobotDescription robot;
  mapless::MaplessOptions navigator;
};

struct FieldRun : suites::SuiteRun {
  FieldOutcome outcome = FieldOutcome::kFailed;
  BestWay best_way;
  // From its first 0.1 m to the end.
  double time_s = 0;
  // The least distance that the body had from its way's end.
  double goal_off_m = 0;
  int way_changes = 0;
  int recoveries = 0;

  bool IsGood() const { return outcome == FieldOutcome::kReached && IsSafe(); }
  // The challenge's: optimal time / clip(time, 2 and 8 optimal times), 0 if the
  // goal was not reached; at most 0.5.
  double Score() const;
};

// Deterministic by options, times apart. CANCELLED if `stop` is requested;
// NOT_FOUND: a world file without the two places; INVALID_ARGUMENT: ends that
// are not within the world.
absl::StatusOr<FieldRun> RunField(const FieldOptions& options,
                                  const std::stop_token& stop);

}  // namespace treeline::fields

#endif  // EVALUATION_FIELDS_FIELD_SUITE_H_
