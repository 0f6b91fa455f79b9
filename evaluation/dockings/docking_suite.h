// Dockings in simulated worlds: a robot stands in a dock and looks, is put
// somewhere else, drives back into it, and how exactly it stands then is
// measured against the truth. docs/reference/suites.md.
#ifndef EVALUATION_DOCKINGS_DOCKING_SUITE_H_
#define EVALUATION_DOCKINGS_DOCKING_SUITE_H_

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "evaluation/suites/suite_run.h"
#include "nav_agent/docking/dock.h"

namespace treeline::dockings {

enum class DockingSuiteOutcome : uint8_t {
  // It says that it is docked, and stands within 2 cm and 2 degrees.
  kExact,
  // It says so, and does not.
  kInexact,
  // It gave up: why.
  kFailed,
  kTimeout,
  // Docked, and did not get out again.
  kStuck
};
const char* DockingSuiteOutcomeName(DockingSuiteOutcome outcome);

struct DockingSuiteOptions {
  uint64_t seed = 0;
  // One of DockingScenes(); empty: "plain".
  std::string scene = {};
  // Whether the robot goes by what the laser sees from the dock, or by its
  // place on the map alone.
  bool by_sight = true;
  // Whether its battery tells of the contacts.
  bool has_contacts = false;
  bool has_rear_laser = true;
  behavior::NavigatorOptions navigator = {};
};

// Where a robot stands to where it should, in the dock's terms.
using DockMiss = docking::DockOffset;

// A robot that was carried away knows after that time that it was (s).
inline constexpr double kMostBelieved_s = 3;

struct DockingRun : suites::SuiteRun {
  std::string scene = {};
  DockingSuiteOutcome outcome = DockingSuiteOutcome::kFailed;
  simulator::RobotPlacement dock;
  simulator::RobotPlacement start;
  // In truth, of a robot that says that it is docked.
  DockMiss miss;
  // What AMCL's estimate was off there (m).
  double estimate_off_m = 0;
  int failed_tries = 0;
  double docking_s = 0;
  // How often it declared itself lost although it was not carried.
  int false_losses = 0;
  // Of a robot that was carried away: so long of the time that it was there
  // before it was sent, it believed to be elsewhere (s).
  bool was_carried = false;
  double believed_s = 0;
  // Whether it can be docked at all: else it must give up.
  bool can_dock = true;

  bool IsGood() const {
    return outcome == (can_dock ? DockingSuiteOutcome::kExact
                                : DockingSuiteOutcome::kFailed) &&
           IsSafe() &&
           (was_carried ? believed_s <= kMostBelieved_s : false_losses == 0);
  }
};

// "plain": a charger of 0.2 m, often before a wall. "backward": driven into
// with the rear first. "moved": by 5 cm, since it was looked at. "wide": 0.62
// m, which hides most of the room from where the robot is docked; the robot is
// started there and must know where it is. "niche": with walls 17 cm beside the
// robot, charging. "blocked": something stands before it for a while.
// "visitor": somebody does; "occupied": who stays. "passers": two walk to and
// fro across its way. "carried": it is put elsewhere while it charges, stands
// there for a while, and is sent to its dock. "cable": and charges there, too.
std::vector<std::string> DockingScenes();
// Whether a scene needs a world in which people are about.
bool HasPeople(const std::string& scene);

// Deterministic by place and options, times apart. CANCELLED if `stop` is
// requested; FAILED_PRECONDITION: the world has no room for a dock; NOT_FOUND:
// no such scene.
absl::StatusOr<DockingRun> RunDocking(const suites::SuitePlace& place,
                                      const DockingSuiteOptions& options,
                                      const std::stop_token& stop);

}  // namespace treeline::dockings

#endif  // EVALUATION_DOCKINGS_DOCKING_SUITE_H_
