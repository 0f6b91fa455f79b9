#include "nav_agent/behavior/laser_search.h"

#include <memory>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

using Outcome = LaserSearch::Outcome;

class LaserSearchTest : public testing::Test {
 protected:
  LaserSearchTest() {
    tracker_.now = At(100);
    tracker_.believed =
        core::LevelPose{.map_from_base = tracker_.truth, .place = {}};
  }
  void Begin(RelocalizationMethod method = RelocalizationMethod::kAmclOnly) {
    RelocalizationBehaviorOptions options;
    options.method = method;
    tools_.emplace(map_, core::RobotModel(), tracker_, options);
    search_.emplace(*tools_, tracker_.now);
  }
  // AMCL has looked everywhere, and finds two places that are alike.
  void BeginInDoubt() {
    Begin();
    search_->LookEverywhere(*tools_, tracker_.now);
    tracker_.finds = tracker_.truth;
    tracker_.finds_after_s = 1;
    tracker_.is_in_doubt = true;
    tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  }
  LaserSearch::Result Step() {
    tracker_.now += std::chrono::milliseconds(25);
    const localization::TrackedMotion motion = *tracker_.Motion();
    search_->AddTurn(motion, *tools_);
    const LaserSearch::Result result =
        search_->Step({.now = tracker_.now, .free_ahead_m = free_ahead_m_},
                      motion, server_, *tools_);
    tracker_.Move(kStep_s, result.wanted);
    for (const RelocalizationNote& note : tools_->report.TakeNotes()) {
      notes_ += note.text + "\n";
    }
    return result;
  }
  Outcome Run(double at_most_s) {
    for (took_s_ = 0; took_s_ < at_most_s; took_s_ += kStep_s) {
      const Outcome outcome = Step().outcome;
      if (outcome != Outcome::kOpen) return outcome;
    }
    return Outcome::kOpen;
  }
  UniquePlace Place(const geometry::Rigid2& at) const {
    return {.pose = {.map_from_base = at, .place = {}},
            .motion = *tracker_.Motion()};
  }
  bool Try(const geometry::Rigid2& at) {
    return search_->TryUniquePlace(Place(at), *tracker_.Motion(), *tools_,
                                   tracker_.now);
  }

  std::shared_ptr<const traversability::NavigationMap> map_ =
      std::make_shared<const traversability::NavigationMap>(
          *traversability::NavigationMap::Make(TwoRooms()));
  ScriptedTracker tracker_;
  std::optional<RelocalizationTools> tools_;
  std::optional<LaserSearch> search_;
  LaserSearch::ServerState server_;
  double took_s_ = 0;
  double free_ahead_m_ = 0;
  std::string notes_;
};

TEST_F(LaserSearchTest, WhatHoldsForLongAndOverATurnIsFound) {
  Begin();
  EXPECT_EQ(Run(60), Outcome::kFound);
  // At 0.8 rad/s that is more than the turn.
  EXPECT_NEAR(took_s_, 5.1, 0.1);
}

TEST_F(LaserSearchTest, APlaceThatBreaksBeginsAnew) {
  Begin();
  ASSERT_TRUE(Try(tracker_.truth));
  EXPECT_EQ(Run(3), Outcome::kOpen);
  // For so long nothing fits.
  tracker_.best_fit = 0.3;
  EXPECT_EQ(Run(2), Outcome::kOpen);
  tracker_.best_fit = 0.95;
  EXPECT_EQ(Run(4.5), Outcome::kOpen);
  EXPECT_EQ(Run(60), Outcome::kFound);
}

TEST_F(LaserSearchTest, WhatLacksATurnAloneTurnsOnInsteadOfMoving) {
  Begin();
  search_->LookEverywhere(*tools_, tracker_.now);
  tracker_.finds = tracker_.truth;
  // In the middle of a turn.
  tracker_.finds_after_s = 6;
  free_ahead_m_ = 1;
  const geometry::Vec2 at = tracker_.truth.translation;
  EXPECT_EQ(Run(60), Outcome::kFound);
  EXPECT_NEAR(took_s_, 6 + kSearchHold_s, 0.3);
  EXPECT_EQ(tracker_.truth.translation, at);
}

TEST_F(LaserSearchTest, SomebodyWhoWalksByDoesNotBreakIt) {
  Begin();
  ASSERT_TRUE(Try(tracker_.truth));
  EXPECT_EQ(Run(4), Outcome::kOpen);
  tracker_.best_fit = 0.3;
  EXPECT_EQ(Run(0.5), Outcome::kOpen);
  tracker_.best_fit = 0.95;
  EXPECT_EQ(Run(1.5), Outcome::kFound);
}

TEST_F(LaserSearchTest, APlaceWithATwinIsNotFound) {
  Begin();
  ASSERT_TRUE(Try(tracker_.truth));
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  EXPECT_EQ(Run(130), Outcome::kTimeIsUp);
  EXPECT_NEAR(took_s_, 120, 0.1);
}

TEST_F(LaserSearchTest, AVerdictThatIsNotSureIsWaitedFor) {
  Begin();
  ASSERT_TRUE(Try(tracker_.truth));
  tracker_.lost_verdict.probability = 0.21;
  EXPECT_EQ(Run(15), Outcome::kOpen);
  tracker_.lost_verdict.probability = 0.2;
  EXPECT_EQ(Run(1), Outcome::kFound);
}

TEST_F(LaserSearchTest, AWrongPlaceIsSpreadAfterATurn) {
  Begin();
  tracker_.believed->map_from_base = {{10, 4}, 1};
  EXPECT_EQ(Run(7), Outcome::kOpen);
  EXPECT_EQ(tracker_.spread, 0);
  EXPECT_EQ(Run(2), Outcome::kOpen);
  EXPECT_EQ(tracker_.spread, 1);
}

TEST_F(LaserSearchTest, InjectionAloneSpreadsNothingThatHasAPlace) {
  Begin(RelocalizationMethod::kInjectionOnly);
  search_->LookEverywhere(*tools_, tracker_.now);
  EXPECT_EQ(tracker_.spread, 0);
  tracker_.believed.reset();
  search_->LookEverywhere(*tools_, tracker_.now);
  EXPECT_EQ(tracker_.spread, 1);
}

TEST_F(LaserSearchTest, AUniquePlaceIsGivenToAmclCarriedOnByTheWheels) {
  Begin();
  const UniquePlace place = Place(tracker_.truth);
  tracker_.Move(1, {.forward_mps = 0.2, .yaw_rate_radps = 0.5});
  EXPECT_TRUE(search_->TryUniquePlace(place, *tracker_.Motion(), *tools_,
                                      tracker_.now));
  EXPECT_EQ(tracker_.told, 1);
  EXPECT_LT(geometry::Norm(tracker_.believed->map_from_base.translation -
                           tracker_.truth.translation),
            1e-9);
  EXPECT_EQ(Run(60), Outcome::kFound);
}

TEST_F(LaserSearchTest, AUniquePlaceThatDoesNotHoldIsTheCamerasTurn) {
  Begin(RelocalizationMethod::kServer);
  EXPECT_TRUE(Try({{10, 4}, 1}));
  server_ = {.may_be_asked = true, .is_asked = true};
  EXPECT_EQ(Run(20), Outcome::kCamerasTurn);
  EXPECT_EQ(tracker_.spread, 0);
}

TEST_F(LaserSearchTest, WithoutAServerParticlesAreSpreadInstead) {
  Begin(RelocalizationMethod::kServer);
  EXPECT_TRUE(Try({{10, 4}, 1}));
  EXPECT_EQ(Run(10), Outcome::kOpen);
  EXPECT_EQ(tracker_.spread, 1);
}

TEST_F(LaserSearchTest, AsksNowAndThen) {
  Begin(RelocalizationMethod::kServer);
  tracker_.best_fit = 0.3;
  server_.may_be_asked = true;
  EXPECT_EQ(Run(10), Outcome::kAsks);
  EXPECT_NEAR(took_s_, 4, 0.1);
  EXPECT_EQ(Run(10), Outcome::kAsks);
  EXPECT_NEAR(took_s_, 4, 0.1);
  // One that failed last is asked less often.
  server_.has_failed = true;
  EXPECT_EQ(Run(30), Outcome::kAsks);
  EXPECT_NEAR(took_s_, kAskFailedInterval_s, 0.1);
  // And not while it thinks.
  server_.is_asked = true;
  EXPECT_EQ(Run(20), Outcome::kOpen);
}

TEST_F(LaserSearchTest, WhatHoldsInDoubtIsFoundWhenTheDoubtEnds) {
  Begin();
  search_->LookEverywhere(*tools_, tracker_.now);
  tracker_.finds = tracker_.truth;
  tracker_.finds_after_s = 1;
  tracker_.is_in_doubt = true;
  // One scan fits another place too; those of all viewpoints do not.
  tracker_.alias = geometry::Rigid2{{9, 3}, 0.5};
  EXPECT_EQ(Run(30), Outcome::kOpen);
  tracker_.is_in_doubt = false;
  EXPECT_EQ(Run(0.1), Outcome::kFound);
}

TEST_F(LaserSearchTest, APlaceThatAmclLeavesForAnotherBeginsAnew) {
  BeginInDoubt();
  EXPECT_EQ(Run(10), Outcome::kOpen);
  // The scans fit there as well.
  tracker_.believed->map_from_base = *tracker_.alias;
  tracker_.is_in_doubt = false;
  EXPECT_EQ(Run(4.8), Outcome::kOpen);
  EXPECT_EQ(Run(1), Outcome::kFound);
}

TEST_F(LaserSearchTest, DrivesToWhereThePlacesThatAreLeftDiffer) {
  BeginInDoubt();
  tracker_.others = {
      {.pose = {.map_from_base = *tracker_.alias, .place = {}}, .share = 0.5}};
  free_ahead_m_ = 1;
  // The fake's scan shows things all around: between their points.
  tools_->robot.half_width_m = 0;
  // The room on the left has something in its upper right corner.
  const geometry::Vec2 spot = {4.5, 4.5};
  tracker_.expected_at = [spot](const core::LevelPose& pose, int directions) {
    const bool is_there =
        geometry::Norm(pose.map_from_base.translation - spot) < 1;
    return std::vector<float>(static_cast<size_t>(directions),
                              is_there ? 1.0F : 3.0F);
  };
  for (double s = 0; s < 40; s += kStep_s) {
    Step();
    if (geometry::Norm(tracker_.truth.translation - spot) < 1) break;
  }
  EXPECT_LT(geometry::Norm(tracker_.truth.translation - spot), 1);
  EXPECT_NE(notes_.find("2 places are left"), std::string::npos) << notes_;
  EXPECT_NE(notes_.find("to where they differ"), std::string::npos) << notes_;
  // The doubt is over, and what it has held for counts.
  tracker_.is_in_doubt = false;
  tracker_.others.clear();
  EXPECT_EQ(Run(0.1), Outcome::kFound);
}

TEST_F(LaserSearchTest, WhereNothingDiffersItSaysSoAndLooksOn) {
  BeginInDoubt();
  tracker_.others = {
      {.pose = {.map_from_base = *tracker_.alias, .place = {}}, .share = 0.5}};
  EXPECT_EQ(Run(130), Outcome::kTimeIsUp);
  EXPECT_NE(notes_.find("no view in reach parts them"), std::string::npos)
      << notes_;
}

}  // namespace
}  // namespace treeline::behavior
