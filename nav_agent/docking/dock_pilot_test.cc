// A pilot above a navigator whose robot moves as it is told.
#include "nav_agent/docking/dock_pilot.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "gmock/gmock.h"
#include "nav_agent/docking/parameters.h"
#include "nav_agent/docking/testing_dock_robot.h"
#include "nav_agent/docking/testing_dock_room.h"

namespace treeline::docking {
namespace {

using behavior::GoalState;
using behavior::NavigatorMode;
using behavior::PoseAtPoint;
using ::testing::HasSubstr;

class DockPilotTest : public DockFixture {
 protected:
  void SetUp() override {
    MakePlaced();
    SetDocks({Charger()});
  }
  // Stands in the dock, by pose alone.
  void BeDocked() {
    Put(Charger().map_from_docked);
    Drive(1);
    ASSERT_TRUE(pilot.IsDocked());
  }
};

TEST_F(DockPilotTest, DrivesInSlowlyAndStandsWithinTheTolerances) {
  beside = {{0.05, 0.09}, 0.14};
  double fastest_mps = 0;
  on_step = [&] {
    if (status().state == DockingState::kDrivingIn) {
      fastest_mps = std::max(fastest_mps, std::abs(Last().forward_mps));
    }
  };
  Begin(Charger());
  EXPECT_EQ(status().state, DockingState::kToStaging);
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded) << status().why;
  EXPECT_EQ(status().failed_tries, 0);
  EXPECT_LE(fastest_mps, kDockSpeed_mps);
  EXPECT_NEAR(Off(Charger()).along_m, 0, kTolerance_m);
  EXPECT_NEAR(Off(Charger()).aside_m, 0, kTolerance_m);
  EXPECT_NEAR(Off(Charger()).turned_rad, 0, kTolerance_rad);
  EXPECT_EQ(Count("dock", "docked in 'charger'"), 1);
  Drive(2);
  EXPECT_TRUE(pilot.IsDocked());
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
  ASSERT_TRUE(controller->last_approach.has_value());
  EXPECT_EQ(controller->last_approach->map_from_docked,
            Charger().map_from_docked);
}

TEST_F(DockPilotTest, ADockThatIsDrivenIntoBackwardIsEnteredWithTheRear) {
  Dock dock = Charger();
  dock.is_backward = true;
  SetDocks({dock});
  beside = {{0.05, -0.09}, -0.14};
  double most_mps = -1;
  on_step = [&] {
    if (status().state == DockingState::kDrivingIn) {
      most_mps = std::max(most_mps, Last().forward_mps);
    }
  };
  Begin(dock);
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded) << status().why;
  EXPECT_LE(most_mps, 0);
  EXPECT_NEAR(Off(dock).along_m, 0, kTolerance_m);
  EXPECT_NEAR(Off(dock).aside_m, 0, kTolerance_m);
}

TEST_F(DockPilotTest, ABatteryThatBeginsToChargeIsAllThatIsWanted) {
  battery = {.charge = 0.5, .charging = core::Charging::kNo};
  on_step = [&] {
    if (status().state == DockingState::kDrivingIn &&
        Off(Charger()).along_m > -0.1) {
      battery->charging = core::Charging::kYes;
    }
  };
  Begin(Charger());
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded);
  EXPECT_THAT(status().why, HasSubstr("it charges"));
  // A little further, to stand well, and no more.
  EXPECT_NEAR(Off(Charger()).along_m, -0.1 + kPress_m, 0.005);
  Drive(1);
  EXPECT_TRUE(pilot.IsCharging());
}

TEST_F(DockPilotTest, ABatteryThatAlwaysSaysItChargesShowsNoContact) {
  battery = {.charge = 0.5, .charging = core::Charging::kYes};
  Begin(Charger());
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded);
  EXPECT_THAT(status().why, HasSubstr("it stands there"));
  EXPECT_NEAR(Off(Charger()).along_m, 0, kTolerance_m);
}

TEST_F(DockPilotTest, WithoutAContactItTriesAgainAndGivesUpBeforeTheDock) {
  battery = {.charge = 0.5, .charging = core::Charging::kNo};
  double furthest_m = -1;
  on_step = [&] { furthest_m = std::max(furthest_m, Off(Charger()).along_m); };
  Begin(Charger());
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kFailed);
  EXPECT_EQ(status().failed_tries, kTries);
  EXPECT_THAT(status().why, HasSubstr("the battery does not charge"));
  EXPECT_NEAR(furthest_m, kPress_m, 0.005);
  EXPECT_LT(Off(Charger()).along_m, -0.6);
  EXPECT_EQ(Count("dock", "try 3 of 3"), 1);
}

TEST_F(DockPilotTest, SomebodyBeforeTheDockIsWaitedForAndThenBackedAwayFrom) {
  Begin(Charger());
  Drive(2);
  ASSERT_EQ(status().state, DockingState::kDrivingIn);
  controller->guard_stops = true;
  Drive(kPatience_s - 2);
  EXPECT_EQ(status().state, DockingState::kDrivingIn);
  // Gone in time.
  controller->guard_stops = false;
  Drive(1);
  EXPECT_EQ(status().failed_tries, 0);
  controller->guard_stops = true;
  Drive(kPatience_s + 1);
  EXPECT_EQ(status().failed_tries, 1);
  EXPECT_EQ(Count("dock", "something stands in the way"), 1);
  // Behind it, too.
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kFailed);
  EXPECT_THAT(status().why, HasSubstr("and it cannot back out"));
  EXPECT_EQ(Last(), core::VelocityCommand{});
}

TEST_F(DockPilotTest, BehindAClosedDoorItSaysSo) {
  for (int i = 0; i < 50; ++i) {
    planner->answers.emplace_back(behavior::FakePlannerWorker::Failure(
        core::NavigationCause::kNoPath, "a closed door"));
  }
  Begin(Charger());
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kFailed);
  EXPECT_THAT(status().why, HasSubstr("cannot be reached"));
  EXPECT_THAT(status().why, HasSubstr("a closed door"));
}

TEST_F(DockPilotTest, AStopEndsItAndAReleaseMovesNothing) {
  Begin(Charger());
  Drive(3);
  ASSERT_EQ(status().state, DockingState::kDrivingIn);
  navigator->Stop("a child");
  Drive(1);
  EXPECT_EQ(status().outcome, DockingOutcome::kCancelled);
  EXPECT_FALSE(pilot.Begin(*navigator, Charger()).ok());
  navigator->Release();
  Drive(3);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_EQ(mode(), NavigatorMode::kIdle);
}

TEST_F(DockPilotTest, APauseHoldsItAndResumeGoesOn) {
  Begin(Charger());
  Drive(3);
  navigator->Pause();
  Drive(5 * kPatience_s);
  EXPECT_EQ(status().state, DockingState::kDrivingIn);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  navigator->Resume();
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded) << status().why;
}

TEST_F(DockPilotTest, AGoalTakesItsPlaceAndIsDrivenAfterItIsOut) {
  Begin(Charger());
  for (int i = 0; i < 100 && Off(Charger()).along_m < -0.15; ++i) Drive(0.1);
  arrives = false;
  const uint64_t goal = Send({PoseAtPoint(2, 8)});
  Drive(0.5);
  EXPECT_EQ(status().outcome, DockingOutcome::kCancelled);
  EXPECT_EQ(status().state, DockingState::kDrivingOut);
  EXPECT_LT(Last().forward_mps, 0);
  EXPECT_TRUE(controller->path.empty());
  Drive(8);
  EXPECT_EQ(status().state, DockingState::kAway);
  EXPECT_LE(Off(Charger()).along_m, -0.69);
  EXPECT_EQ(Goal().id, goal);
  EXPECT_EQ(Goal().state, GoalState::kActive);
  EXPECT_FALSE(controller->path.empty());
  EXPECT_EQ(Count("dock", "is out of dock 'charger'"), 1);
}

// As after a restart: nothing is known but where it stands.
TEST_F(DockPilotTest, ARobotThatStandsInADockDrivesStraightOutFirst) {
  BeDocked();
  arrives = false;
  double most_turned_rad = 0;
  Send({PoseAtPoint(2, 8)});
  on_step = [&] {
    if (status().state == DockingState::kDrivingOut) {
      most_turned_rad =
          std::max(most_turned_rad, std::abs(Off(Charger()).turned_rad));
    }
  };
  Drive(10);
  EXPECT_EQ(Count("dock", "drives out of dock 'charger'"), 1);
  EXPECT_EQ(Count("dock", "is out of dock 'charger'"), 1);
  EXPECT_LT(most_turned_rad, 0.01);
  EXPECT_FALSE(controller->path.empty());
}

TEST_F(DockPilotTest, HeldInADockItsGoalDrivesItAsItCan) {
  BeDocked();
  arrives = false;
  controller->guard_stops = true;
  Send({PoseAtPoint(2, 8)});
  Drive(kPatience_s + 2);
  EXPECT_EQ(Count("dock", "something holds it there"), 1);
  EXPECT_FALSE(controller->path.empty());
  EXPECT_EQ(Count("dock", "drives out of dock"), 1);
}

TEST_F(DockPilotTest, DrivesOutWhenItIsTold) {
  EXPECT_EQ(pilot.DriveOut(*navigator).code(),
            absl::StatusCode::kFailedPrecondition);
  BeDocked();
  EXPECT_TRUE(pilot.DriveOut(*navigator).ok());
  Drive(10);
  EXPECT_EQ(status().state, DockingState::kAway);
  EXPECT_LE(Off(Charger()).along_m, -0.69);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  EXPECT_EQ(pilot.Cancel(*navigator).code(), absl::StatusCode::kNotFound);
}

TEST_F(DockPilotTest, LostOnItsWayInItComesBackWhenItIsFound) {
  Begin(Charger());
  Drive(4);
  ASSERT_EQ(status().state, DockingState::kDrivingIn);
  lost->now_state = behavior::RelocalizationState::kSearching;
  Drive(1);
  EXPECT_EQ(status().state, DockingState::kToStaging);
  lost->now_state = behavior::RelocalizationState::kIdle;
  Put({{8, 8}, 1});
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded) << status().why;
}

TEST_F(DockPilotTest, KidnappedFromItsDockItKnowsWhereItStandsWhenItIsFound) {
  BeDocked();
  lost->now_state = behavior::RelocalizationState::kSearching;
  Drive(1);
  EXPECT_EQ(status().state, DockingState::kAway);
  lost->now_state = behavior::RelocalizationState::kIdle;
  Drive(1);
  EXPECT_TRUE(pilot.IsDocked());
  lost->now_state = behavior::RelocalizationState::kSearching;
  Drive(1);
  Put({{2, 2}, 0});
  lost->now_state = behavior::RelocalizationState::kIdle;
  Drive(1);
  EXPECT_EQ(status().state, DockingState::kAway);
}

TEST_F(DockPilotTest, ADockThatIsRemovedOrMovedIsFollowed) {
  Begin(Charger());
  Drive(3);
  Dock moved = Charger();
  moved.map_from_docked.translation = {7, 7};
  SetDocks({moved});
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded) << status().why;
  EXPECT_NEAR(Off(moved).along_m, 0, kTolerance_m);
  Put({{2, 2}, 0});
  Drive(1);
  Begin(moved);
  Drive(3);
  SetDocks({});
  Drive(1);
  EXPECT_EQ(status().outcome, DockingOutcome::kFailed);
  EXPECT_EQ(status().why, "the dock was removed");
  EXPECT_EQ(Last(), core::VelocityCommand{});
}

TEST_F(DockPilotTest, CancelledItStands) {
  Begin(Charger());
  Drive(3);
  EXPECT_TRUE(pilot.Cancel(*navigator).ok());
  Drive(2);
  EXPECT_EQ(status().outcome, DockingOutcome::kCancelled);
  EXPECT_EQ(Last(), core::VelocityCommand{});
}

TEST_F(DockPilotTest, OneThatComesInBesideTheDockTriesAgain) {
  int tries = 0;
  on_step = [&] {
    // Something pushes it, once.
    if (tries == 0 && status().state == DockingState::kDrivingIn &&
        Off(Charger()).along_m > -0.04) {
      ++tries;
      Put(Charger().map_from_docked * geometry::Rigid2{{-0.03, 0.06}, 0});
    }
  };
  Begin(Charger());
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded) << status().why;
  EXPECT_EQ(status().failed_tries, 1);
  EXPECT_EQ(Count("dock", "it came in"), 1);
}

// A robot in a room, whose estimate is wrong by `off`.
class DockSightTest : public DockFixture {
 protected:
  void SetUp() override {
    laser.info = DockRoom::Laser();
    laser_runs = false;
    on_step = [this] {
      core::LaserScan scan;
      scan.stamp = clock.Now();
      scan.ranges_m = room.Ranges_m(Truth());
      laser.waiting.push_back(std::move(scan));
    };
  }
  geometry::Rigid2 Truth() const {
    return tracker->pose.has_value() ? tracker->pose->map_from_base * off
                                     : unplaced_truth;
  }
  // Stands in the dock until it knows what is seen from there.
  Dock Look() {
    MakePlaced();
    SetDocks({DockRoom::Charger()});
    Put(DockRoom::Charger().map_from_docked);
    Drive(3);
    const std::optional<Dock> learned = pilot.TakeLearned();
    EXPECT_TRUE(learned.has_value());
    EXPECT_EQ(Count("dock", "knows what is seen from dock 'charger'"), 1);
    return learned.value_or(DockRoom::Charger());
  }

  DockRoom room;
  geometry::Rigid2 off;
  geometry::Rigid2 unplaced_truth = DockRoom::Charger().map_from_docked;
};

TEST_F(DockSightTest, DrivesInByWhatItSeesAndNotByItsEstimate) {
  const Dock dock = Look();
  EXPECT_FALSE(pilot.TakeLearned().has_value());
  for (const double side : {-1.0, 1.0}) {
    off = {{0.05, side * 0.06}, side * 0.05};
    Put({{1.5, 1.5}, 0});
    Drive(1);
    Begin(dock);
    DriveUntilOver();
    EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded) << status().why;
    EXPECT_THAT(status().why, HasSubstr("as it sees"));
    EXPECT_EQ(status().failed_tries, 0);
    const DockOffset miss = OffsetFrom(dock, Truth());
    // It stops a quarter of the tolerance before it.
    EXPECT_NEAR(miss.along_m, 0, 0.012);
    // What it was beside the line has fallen to a twenty-fifth, less or more.
    EXPECT_NEAR(miss.aside_m, 0, 0.015);
    EXPECT_NEAR(miss.turned_rad, 0, kTolerance_rad);
  }
}

TEST_F(DockSightTest, ADockThatWasMovedIsFollowedAndTold) {
  Dock dock = Look();
  room.PutDock({0, 0.05});
  Put({{1.5, 1.5}, 0});
  Drive(1);
  Begin(dock);
  DriveUntilOver();
  EXPECT_EQ(status().outcome, DockingOutcome::kSucceeded) << status().why;
  EXPECT_GE(Count("dock", "dock 'charger' was moved by"), 1);
  dock.map_from_docked.translation.y += 0.05;
  EXPECT_NEAR(OffsetFrom(dock, Truth()).aside_m, 0, 0.015);
}

TEST_F(DockSightTest, ARobotThatChargesKnowsWhereItWakesUp) {
  const Dock dock = Look();
  Make();
  SetDocks({dock});
  Drive(2);
  // Nobody told it, and no contact did.
  EXPECT_FALSE(tracker->pose.has_value());
  battery = {.charge = 0.5, .charging = core::Charging::kYes};
  Drive(1);
  ASSERT_TRUE(tracker->pose.has_value());
  EXPECT_NEAR(tracker->pose->map_from_base.translation.x, 3, 0.01);
  EXPECT_NEAR(tracker->pose->map_from_base.translation.y, 1.5, 0.01);
  EXPECT_EQ(Count("dock", "it knows where it is"), 1);
  EXPECT_TRUE(pilot.IsCharging());
}

TEST_F(DockSightTest, WhoChargesWhereItDidHasNotBeenCarried) {
  MakePlaced();
  SetDocks({DockRoom::Charger()});
  Put(DockRoom::Charger().map_from_docked);
  battery = {.charge = 0.5, .charging = core::Charging::kYes};
  Drive(0.7);
  ASSERT_TRUE(pilot.IsCharging());
  // What hides the room makes it doubt, and its estimate goes; it sees what is
  // seen from there.
  lost->now_state = behavior::RelocalizationState::kSearching;
  tracker->pose->map_from_base = {{8, 8}, 0};
  off = tracker->pose->map_from_base.Inverse() *
        DockRoom::Charger().map_from_docked;
  Drive(0.6);
  EXPECT_GE(Count("dock", "it has not been carried"), 1);
  EXPECT_NEAR(tracker->pose->map_from_base.translation.x, 3, 1e-9);
  // Off the contacts anybody may have carried it.
  off = {};
  lost->now_state = behavior::RelocalizationState::kIdle;
  Drive(1);
  battery->charging = core::Charging::kNo;
  lost->now_state = behavior::RelocalizationState::kSearching;
  tracker->pose->map_from_base = {{8, 8}, 0};
  Drive(1);
  EXPECT_EQ(tracker->pose->map_from_base.translation.x, 8);
}

TEST_F(DockSightTest, WhoWasCarriedWhileItChargedIsNotHeldThere) {
  Look();
  battery = {.charge = 0.5, .charging = core::Charging::kYes};
  Drive(1);
  ASSERT_TRUE(pilot.IsCharging());
  // With its charger, or by somebody whose cable follows.
  const geometry::Rigid2 elsewhere = {{1.2, 2}, 2};
  lost->now_state = behavior::RelocalizationState::kSearching;
  tracker->pose->map_from_base = {{8, 8}, 0};
  off = tracker->pose->map_from_base.Inverse() * elsewhere;
  Drive(3);
  EXPECT_EQ(Count("dock",
                  "does not see what is seen from dock 'charger': it "
                  "has been carried"),
            1);
  EXPECT_EQ(Count("dock", "it has not been carried"), 0);
  EXPECT_EQ(tracker->pose->map_from_base.translation.x, 8);
}

TEST_F(DockSightTest, OneThatChargesSomewhereElseIsToldNothing) {
  const Dock dock = Look();
  Make();
  laser.waiting.clear();
  unplaced_truth = {{1.5, 2.2}, 2};
  battery = {.charge = 0.5, .charging = core::Charging::kYes};
  Drive(2);
  EXPECT_FALSE(tracker->pose.has_value());
  // Two docks that look the same from inside.
  Dock twin = dock;
  twin.name = "twin";
  twin.map_from_docked = {{8, 8}, 1};
  SetDocks({dock, twin});
  unplaced_truth = dock.map_from_docked;
  Drive(2);
  EXPECT_FALSE(tracker->pose.has_value());
  SetDocks({dock});
  Drive(1);
  EXPECT_TRUE(tracker->pose.has_value());
}

}  // namespace
}  // namespace treeline::docking
