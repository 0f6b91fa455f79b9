#include "nav_agent/behavior/unique_place_search.h"

#include <optional>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_relocalization.h"

namespace treeline::behavior {
namespace {

// A tracker whose search finds what the test says.
class UniquePlaceSearchTest : public testing::Test {
 protected:
  class Tracker final : public ScriptedTracker {
   public:
    std::vector<OtherPlace> finds_places;
    int begun = 0;
    bool begun_for_others = false;

    void BeginOtherPlaces(const std::optional<core::LevelPose>& than) override {
      ++begun;
      begun_for_others = than.has_value();
      ScriptedTracker::BeginOtherPlaces(than);
    }
    std::vector<OtherPlace> BestPlaces() const override { return finds_places; }
  };

  UniquePlaceSearchTest() { tracker_.now = At(100); }

  // A place where the scan has this score and contradicts nothing.
  static localization::RobotTracker::OtherPlace Place(double score,
                                                      double x = 9) {
    return {.pose = {.map_from_base = {{x, 3}, 0}, .place = {}},
            .fit = {.explained = score, .contradicted = 0, .judged = 100}};
  }
  static core::LevelPose Here() { return {}; }
  void WholeMap(std::vector<localization::RobotTracker::OtherPlace> places) {
    tracker_.finds_places = std::move(places);
    search_.BeginWholeMap();
    ASSERT_TRUE(search_.StepWholeMap());
  }
  // A scan that scores 0.94 at the truth.
  OtherPlaces Others(
      std::vector<localization::RobotTracker::OtherPlace> places) {
    tracker_.finds_places = std::move(places);
    search_.BeginOthers({.map_from_base = tracker_.truth, .place = {}});
    EXPECT_TRUE(search_.StepOthers());
    return search_.others();
  }

  Tracker tracker_;
  UniquePlaceOptions options_;
  UniquePlaceSearch search_{tracker_, options_};
};

TEST_F(UniquePlaceSearchTest, APlaceThatStandsAloneIsFound) {
  tracker_.odom_from_base = {{4, 5}, 0.5};
  WholeMap({Place(0.95, 9), Place(0.5, 1)});
  ASSERT_TRUE(search_.place().has_value());
  EXPECT_EQ(search_.place()->pose.map_from_base.translation.x, 9);
  // Of the scan's moment, not of a later one.
  EXPECT_EQ(search_.place()->motion.odom_from_base, tracker_.odom_from_base);
}

TEST_F(UniquePlaceSearchTest, APlaceWithATwinIsNot) {
  WholeMap({Place(0.95), Place(0.95 - 0.11)});
  EXPECT_FALSE(search_.place().has_value());
  WholeMap({Place(0.95), Place(0.95 - 0.13)});
  EXPECT_TRUE(search_.place().has_value());
}

TEST_F(UniquePlaceSearchTest, APlaceMustFitWell) {
  WholeMap({});
  EXPECT_FALSE(search_.place().has_value());
  WholeMap({Place(0.74)});
  EXPECT_FALSE(search_.place().has_value());
  WholeMap({Place(0.75)});
  EXPECT_TRUE(search_.place().has_value());
  localization::RobotTracker::OtherPlace contradicted = Place(0.95);
  contradicted.fit.contradicted = 0.13;
  WholeMap({contradicted});
  EXPECT_FALSE(search_.place().has_value());
  localization::RobotTracker::OtherPlace few_beams = Place(0.95);
  few_beams.fit.judged = 24;
  WholeMap({few_beams});
  EXPECT_FALSE(search_.place().has_value());
}

TEST_F(UniquePlaceSearchTest, ANewSearchForgetsThePlaceAndAnEndKeepsIt) {
  WholeMap({Place(0.95)});
  EXPECT_TRUE(search_.has_begun_whole_map());
  search_.EndWholeMap();
  EXPECT_FALSE(search_.has_begun_whole_map());
  EXPECT_TRUE(search_.place().has_value());
  search_.BeginWholeMap();
  EXPECT_FALSE(search_.place().has_value());
  EXPECT_TRUE(search_.has_begun_whole_map());
}

TEST_F(UniquePlaceSearchTest, AnEndedSearchDoesNotGoOn) {
  tracker_.search_steps = 2;
  search_.BeginWholeMap();
  EXPECT_FALSE(search_.StepWholeMap());
  search_.EndWholeMap();
  tracker_.finds_places = {Place(0.95)};
  EXPECT_FALSE(search_.StepWholeMap());
  EXPECT_FALSE(search_.place().has_value());
}

TEST_F(UniquePlaceSearchTest, ADoneSearchTellsItOnce) {
  WholeMap({Place(0.95)});
  EXPECT_FALSE(search_.StepWholeMap());
}

TEST_F(UniquePlaceSearchTest, OthersAreWorseAlikeOrBetter) {
  EXPECT_EQ(search_.others(), OtherPlaces::kNotSearched);
  EXPECT_EQ(Others({}), OtherPlaces::kNone);
  EXPECT_EQ(Others({Place(0.81)}), OtherPlaces::kNone);
  EXPECT_EQ(Others({Place(0.83)}), OtherPlaces::kAlike);
  EXPECT_EQ(Others({Place(1.0), Place(0.5)}), OtherPlaces::kAlike);
  // Fits elsewhere much better than here.
  tracker_.best_fit = 0.8;
  EXPECT_EQ(Others({Place(0.9)}), OtherPlaces::kAlike);
  EXPECT_EQ(Others({Place(0.92)}), OtherPlaces::kBetter);
  search_.ForgetOthers();
  EXPECT_EQ(search_.others(), OtherPlaces::kNotSearched);
}

TEST_F(UniquePlaceSearchTest, OthersTakeTheirTime) {
  tracker_.search_steps = 3;
  search_.BeginOthers(Here());
  EXPECT_TRUE(tracker_.begun_for_others);
  EXPECT_FALSE(search_.StepOthers());
  EXPECT_EQ(search_.others(), OtherPlaces::kSearching);
  EXPECT_FALSE(search_.StepOthers());
  EXPECT_TRUE(search_.StepOthers());
  EXPECT_FALSE(search_.StepOthers());
}

TEST_F(UniquePlaceSearchTest, NothingFitsClearlyBetterThanANearlyPerfectFit) {
  Others({});
  EXPECT_TRUE(search_.IsBestPossible());
  tracker_.best_fit = 0.85;
  Others({});
  EXPECT_FALSE(search_.IsBestPossible());
}

}  // namespace
}  // namespace treeline::behavior
