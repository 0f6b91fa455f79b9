// A battery that runs low above a robot that moves as it is told.
#include "nav_agent/docking/charge_keeper.h"

#include <cmath>
#include <limits>

#include "gmock/gmock.h"
#include "nav_agent/docking/parameters.h"
#include "nav_agent/docking/testing_dock_robot.h"

namespace treeline::docking {
namespace {

using behavior::PoseAtPoint;
using ::testing::HasSubstr;

class ChargeKeeperTest : public DockFixture {
 protected:
  void SetUp() override {
    MakePlaced();
    SetDocks({Charger()});
    battery = {.charge = 0.5, .charging = core::Charging::kNo};
    on_step = [this] { Charge(); };
    // As after its first orders.
    keeper.Resume();
  }
  // It charges in a dock, by `charges_ps` of a full battery a second.
  void Charge() {
    if (!has_contact || !tracker->pose.has_value()) return;
    bool touches = false;
    for (const Dock& dock : *pilot.docks()) {
      touches =
          touches ||
          (IsAt(dock, *tracker->pose) &&
           OffsetFrom(dock, tracker->pose->map_from_base).along_m > -0.01);
    }
    battery->charging = touches ? core::Charging::kYes : core::Charging::kNo;
    if (touches && battery->charge.has_value()) {
      *battery->charge = std::min(1.0, *battery->charge + charges_ps * kStep_s);
    }
  }
  void DriveUntil(ChargeState state) {
    for (int i = 0; i < 600 && keeper.status().state != state; ++i) Drive(0.5);
    EXPECT_EQ(keeper.status().state, state) << keeper.status().why;
  }
  void StartPatrol() {
    const auto id =
        runner.Start(*navigator,
                     {.name = "patrol",
                      .waypoints = {{.position_in_map = {2, 2}, .wait_s = 1000},
                                    {.position_in_map = {8, 8}}}},
                     0);
    ASSERT_TRUE(id.ok()) << id.status();
    Drive(2);
    ASSERT_EQ(runner.status()->state, routes::RouteState::kWaiting);
  }

  bool has_contact = true;
  double charges_ps = 0.02;
};

TEST_F(ChargeKeeperTest, ALowBatterySendsItToItsDockAndBackToItsRoute) {
  StartPatrol();
  battery->charge = 0.19;
  Drive(kLow_s / 2);
  EXPECT_EQ(keeper.status().state, ChargeState::kEnough);
  Drive(kLow_s);
  EXPECT_EQ(keeper.status().state, ChargeState::kGoing);
  EXPECT_EQ(runner.status()->state, routes::RouteState::kHeld);
  EXPECT_THAT(runner.status()->why, HasSubstr("the battery is at 19 %"));
  DriveUntil(ChargeState::kCharging);
  EXPECT_TRUE(pilot.IsDocked());
  Drive(5);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  DriveUntil(ChargeState::kEnough);
  EXPECT_GE(*battery->charge, 0.9);
  Drive(20);
  EXPECT_EQ(Count("dock", "is out of dock"), 1);
  EXPECT_EQ(runner.status()->state, routes::RouteState::kWaiting);
  EXPECT_EQ(runner.status()->progress.waypoint, 0u);
  EXPECT_EQ(keeper.trips(), 1);
}

TEST_F(ChargeKeeperTest, ABatteryThatDoesNotTellMakesNothingHappen) {
  StartPatrol();
  for (const std::optional<core::Battery>& deaf :
       {std::optional<core::Battery>(),
        std::optional<core::Battery>(core::Battery{.voltage_v = 60}),
        std::optional<core::Battery>(
            core::Battery{.charge = std::numeric_limits<double>::quiet_NaN()}),
        std::optional<core::Battery>(core::Battery{.charge = -0.1}),
        std::optional<core::Battery>(core::Battery{.charge = 18})}) {
    has_contact = false;
    battery = deaf;
    Drive(30);
    EXPECT_EQ(keeper.status().state, ChargeState::kUnknown);
    EXPECT_EQ(runner.status()->state, routes::RouteState::kWaiting);
  }
  EXPECT_EQ(keeper.trips(), 0);
  // One that is heard of now and then only.
  for (int i = 0; i < 10; ++i) {
    battery = {.charge = 0.1};
    Drive(kLow_s / 2);
    battery.reset();
    Drive(0.1);
  }
  EXPECT_EQ(keeper.trips(), 0);
}

TEST_F(ChargeKeeperTest, WithoutADockItIsOff) {
  SetDocks({});
  battery->charge = 0.05;
  Drive(60);
  EXPECT_EQ(keeper.status().state, ChargeState::kOff);
  EXPECT_EQ(keeper.trips(), 0);
}

TEST_F(ChargeKeeperTest, AGoalIsDrivenToItsEndFirst) {
  arrives = false;
  Send({PoseAtPoint(8, 8)});
  battery->charge = 0.1;
  Drive(60);
  EXPECT_EQ(keeper.status().state, ChargeState::kLow);
  EXPECT_EQ(keeper.trips(), 0);
  arrives = true;
  Drive(kIdle_s - 1);
  EXPECT_EQ(keeper.trips(), 0);
  Drive(3);
  EXPECT_EQ(keeper.trips(), 1);
}

TEST_F(ChargeKeeperTest, NothingMovesByItAfterTheStartAStopOrACancelledTrip) {
  keeper = ChargeKeeper{ChargeOptions{}};
  battery->charge = 0.1;
  Drive(60);
  EXPECT_EQ(keeper.status().state, ChargeState::kLow);
  EXPECT_THAT(keeper.status().why, HasSubstr("nobody has sent it anywhere"));
  EXPECT_EQ(keeper.trips(), 0);
  keeper.Resume();
  Drive(1);
  EXPECT_EQ(keeper.trips(), 1);
  navigator->Stop("a child");
  Drive(1);
  navigator->Release();
  Drive(60);
  EXPECT_EQ(keeper.trips(), 1);
  EXPECT_EQ(Last(), core::VelocityCommand{});
  keeper.Resume();
  Drive(1);
  EXPECT_EQ(keeper.trips(), 2);
  EXPECT_TRUE(pilot.Cancel(*navigator).ok());
  Drive(60);
  EXPECT_EQ(keeper.trips(), 2);
  EXPECT_THAT(keeper.status().why, HasSubstr("somebody cancelled it"));
  Send({PoseAtPoint(3, 3)});
  Drive(30);
  EXPECT_EQ(keeper.trips(), 3);
}

TEST_F(ChargeKeeperTest, AnOperatorsGoalGoesFirstAndTheRouteWaits) {
  StartPatrol();
  charges_ps = 0.001;
  battery->charge = 0.1;
  DriveUntil(ChargeState::kCharging);
  arrives = false;
  Send({PoseAtPoint(8, 8)});
  Drive(20);
  EXPECT_EQ(keeper.status().state, ChargeState::kLow);
  EXPECT_EQ(Count("charge", "it left its dock"), 1);
  EXPECT_EQ(runner.status()->state, routes::RouteState::kHeld);
  EXPECT_FALSE(controller->path.empty());
  EXPECT_EQ(keeper.trips(), 1);
}

TEST_F(ChargeKeeperTest, ARouteThatSomebodyResumesIsNotLeftAgain) {
  StartPatrol();
  charges_ps = 0.001;
  battery->charge = 0.1;
  DriveUntil(ChargeState::kCharging);
  EXPECT_TRUE(runner.Resume(*navigator).ok());
  Drive(60);
  EXPECT_EQ(runner.status()->state, routes::RouteState::kWaiting);
  EXPECT_EQ(keeper.trips(), 1);
  EXPECT_THAT(keeper.status().why, HasSubstr("somebody resumed its route"));
}

TEST_F(ChargeKeeperTest, TheNearestDockThatCanBeReachedIsTaken) {
  Dock far = Charger("far");
  far.map_from_docked.translation = {8, 8};
  SetDocks({far, Charger("near")});
  battery->charge = 0.1;
  Put({{3, 3}, 0});
  // No way to the first that it tries.
  planner->answers.emplace_back(behavior::FakePlannerWorker::Failure(
      core::NavigationCause::kGoalBlocked, "a wall"));
  DriveUntil(ChargeState::kCharging);
  EXPECT_EQ(pilot.status().dock, "far");
  EXPECT_EQ(Count("dock", "drives to dock 'near'"), 1);
  EXPECT_EQ(Count("dock", "fails at dock 'near'"), 1);
}

TEST_F(ChargeKeeperTest, WhereNoDockCanBeReachedTheRouteGoesOnAndItSaysWhy) {
  StartPatrol();
  has_contact = false;
  battery->charge = 0.1;
  DriveUntil(ChargeState::kGoing);
  DriveUntil(ChargeState::kLow);
  EXPECT_THAT(keeper.status().why, HasSubstr("the battery does not charge"));
  EXPECT_THAT(keeper.status().why, HasSubstr("tries again after 300 s"));
  Drive(20);
  EXPECT_EQ(runner.status()->state, routes::RouteState::kWaiting);
  Drive(kRetry_s);
  EXPECT_EQ(keeper.trips(), 2);
}

TEST_F(ChargeKeeperTest, AContactThatIsLostIsLookedForAgain) {
  battery->charge = 0.1;
  charges_ps = 0.001;
  DriveUntil(ChargeState::kCharging);
  Drive(2);
  has_contact = false;
  battery->charging = core::Charging::kNo;
  Drive(2 * kContact_s + 1);
  EXPECT_EQ(Count("charge", "the contact is lost"), 1);
  EXPECT_EQ(keeper.status().state, ChargeState::kGoing);
  has_contact = true;
  DriveUntil(ChargeState::kCharging);
}

TEST(ChargeOptions, MustMakeSense) {
  EXPECT_TRUE(ChargeOptions{}.Validate().ok());
  EXPECT_TRUE((ChargeOptions{.below = 0, .until = 1}.Validate().ok()));
  EXPECT_FALSE((ChargeOptions{.below = 0.5, .until = 0.5}.Validate().ok()));
  EXPECT_FALSE((ChargeOptions{.below = -0.1, .until = 0.5}.Validate().ok()));
  EXPECT_FALSE((ChargeOptions{.below = 0.1, .until = 1.5}.Validate().ok()));
  EXPECT_FALSE(
      (ChargeOptions{.below = std::nan(""), .until = 0.5}.Validate().ok()));
}

}  // namespace
}  // namespace treeline::docking
