#include "simulation/worlds/ground_truth.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "simulation/worlds/world_builder.h"

namespace treeline::worlds {
namespace {

using ::testing::HasSubstr;

constexpr float kNear_m = 1e-4f;

// A floor of 6 x 4 m, on which things can be put.
class GroundTruthTest : public ::testing::Test {
 protected:
  GroundTruthTest() {
    grey_.texture = builder_.AddTexture([] { return Canvas(1, 1); });
    builder_.set_kind(SurfaceKind::kFloor);
    AddLevel(0, 6, 0, 4, 0);
  }

  void AddLevel(float x0, float x1, float y0, float y1, float z) {
    builder_.AddPanel({}, {x0, y1, z}, {x1 - x0, 0, 0}, {0, y0 - y1, 0}, grey_);
  }
  // Of which the low end is at x0.
  void AddRamp(float x0, float x1, float y0, float y1, float rise) {
    builder_.set_kind(SurfaceKind::kRamp);
    builder_.AddPanel({}, {x0, y1, 0}, {x1 - x0, 0, rise}, {0, y0 - y1, 0},
                      grey_);
  }
  void AddBox(Float3 low, Float3 high) {
    builder_.set_kind(SurfaceKind::kOther);
    builder_.AddBox({}, low, high, {.sides = grey_, .has_bottom = true});
  }

  GroundTruth Compute(const GroundTruthOptions& options = {}) {
    World world = builder_.Build("test", {6, 4, 5}, {}, 1);
    world.places.push_back(
        {.name = "start", .placement = {{0.5f, 0.5f, 0}, 0}});
    auto truth = GroundTruth::Compute(world, options);
    EXPECT_TRUE(truth.ok()) << truth.status();
    return *std::move(truth);
  }
  static GroundState StateAt(const GroundTruth& truth, Float3 point) {
    const auto index = truth.Find(point);
    return index ? truth.at(*index).state : GroundState::kUnknown;
  }

  WorldBuilder builder_;
  Finish grey_;
};

TEST_F(GroundTruthTest, AFloorIsFreeUpToItsEdges) {
  const GroundTruth truth = Compute();
  ASSERT_EQ(truth.levels().size(), 1u);
  EXPECT_EQ(truth.width(), 120);
  EXPECT_EQ(truth.height(), 80);
  EXPECT_EQ(StateAt(truth, {3, 2, 0}), GroundState::kFree);
  const auto index = truth.Find({3, 2, 0});
  ASSERT_TRUE(index.has_value());
  EXPECT_NEAR(truth.at(*index).clearance_m, 100, kNear_m);
  EXPECT_EQ(truth.at(*index).kind, SurfaceKind::kFloor);
}

TEST_F(GroundTruthTest, ThinObstaclesBetweenTheCentresAreSeen) {
  // A pane without thickness, on the line between two columns of cells.
  builder_.set_kind(SurfaceKind::kGlass);
  builder_.AddPanel({}, {2, 1, 2}, {0, 2, 0}, {0, 0, -2}, grey_);
  AddBox({4.01f, 2.01f, 0}, {4.02f, 2.02f, 1});  // a pole of 1 cm
  const GroundTruth truth = Compute();
  EXPECT_EQ(StateAt(truth, {1.98f, 2, 0}), GroundState::kOccupied);
  EXPECT_EQ(StateAt(truth, {2.02f, 2, 0}), GroundState::kOccupied);
  EXPECT_EQ(StateAt(truth, {1.92f, 2, 0}), GroundState::kFree);
  EXPECT_EQ(StateAt(truth, {4.03f, 2.03f, 0}), GroundState::kOccupied);
  EXPECT_EQ(StateAt(truth, {4.08f, 2.03f, 0}), GroundState::kFree);
}

TEST_F(GroundTruthTest, BelowATableItDependsOnTheRobot) {
  AddBox({2, 1, 0.7f}, {4, 3, 0.74f});
  const GroundTruthOptions low = {.clearance_m = 0.6};
  const GroundTruth for_low = Compute(low);
  EXPECT_EQ(StateAt(for_low, {3, 2, 0}), GroundState::kFree);
  const auto index = for_low.Find({3, 2, 0});
  ASSERT_TRUE(index.has_value());
  EXPECT_NEAR(for_low.at(*index).clearance_m, 0.7f, kNear_m);
}

TEST_F(GroundTruthTest, TablesBlockTallRobotsAndRugsBlockNobody) {
  AddBox({2, 1, 0.7f}, {4, 3, 0.74f});
  AddBox({4.5f, 1, 0}, {5.5f, 3, 0.008f});
  const GroundTruth truth = Compute();
  EXPECT_EQ(StateAt(truth, {3, 2, 0}), GroundState::kOccupied);
  EXPECT_EQ(StateAt(truth, {5, 2, 0}), GroundState::kFree);
}

TEST_F(GroundTruthTest, ARampHasItsSlopeAndItsEdgesAreOccupied) {
  AddRamp(1, 5, 1, 3, 0.4f);
  const GroundTruth truth = Compute();
  const auto index = truth.Find({3.02f, 2, 0.2f});
  ASSERT_TRUE(index.has_value());
  const GroundCell& cell = truth.at(*index);
  EXPECT_EQ(cell.state, GroundState::kFree);
  EXPECT_EQ(cell.kind, SurfaceKind::kRamp);
  EXPECT_NEAR(cell.slope_rad, std::atan(0.1), 1e-5);
  // The middle of its cell is at x = 3.025.
  EXPECT_NEAR(cell.height_m, 0.2025, kNear_m);
  EXPECT_EQ(StateAt(truth, {3.02f, 1.02f, 0.2f}), GroundState::kOccupied);
  EXPECT_EQ(StateAt(truth, {3.02f, 2.98f, 0.2f}), GroundState::kOccupied);
  EXPECT_EQ(StateAt(truth, {4.97f, 2, 0.4f}), GroundState::kOccupied);
  EXPECT_EQ(StateAt(truth, {1.02f, 2, 0}), GroundState::kFree);
}

TEST_F(GroundTruthTest, SteepRampsAreOccupied) {
  AddRamp(1, 5, 1, 3, 1.2f);  // 16.7 degrees
  const GroundTruth truth = Compute();
  EXPECT_EQ(StateAt(truth, {1.5f, 2, 0.15f}), GroundState::kOccupied);
}

TEST_F(GroundTruthTest, StairsAreNeverFree) {
  builder_.set_kind(SurfaceKind::kStair);
  AddLevel(3, 4, 1, 3, 0.015f);  // a step that one could drive over
  const GroundTruth truth = Compute();
  EXPECT_EQ(StateAt(truth, {3.5f, 2, 0.015f}), GroundState::kOccupied);
}

TEST_F(GroundTruthTest, StoreysOverOneAnotherAreLevelsThatARampJoins) {
  AddRamp(1, 5, 0, 1.5f, 2);
  builder_.set_kind(SurfaceKind::kFloor);
  AddLevel(5, 6, 0, 4, 2);
  AddLevel(2, 5, 1.5f, 4, 2);
  const GroundTruthOptions options = {.max_slope_rad = 0.5, .clearance_m = 1};
  const GroundTruth truth = Compute(options);
  ASSERT_EQ(truth.levels().size(), 2u);
  const auto below = truth.Find({4, 3, 0});
  const auto above = truth.Find({4, 3, 2});
  ASSERT_TRUE(below.has_value());
  ASSERT_TRUE(above.has_value());
  EXPECT_EQ(below->level, 0);
  EXPECT_EQ(above->level, 1);
  const auto reach = truth.ReachableFrom({0.5f, 0.5f, 0}, 0.2);
  EXPECT_TRUE(reach.Contains(*below));
  EXPECT_TRUE(reach.Contains(*above));
  // Too wide for the ramp.
  const auto wide = truth.ReachableFrom({0.9f, 2.9f, 0}, 0.8);
  EXPECT_GT(wide.count(), 0u);
  EXPECT_FALSE(wide.Contains(*above));
}

TEST_F(GroundTruthTest, WhereNobodyGetsToIsUnknown) {
  builder_.set_kind(SurfaceKind::kFloor);
  AddLevel(3, 6, 0, 4, 2.5f);
  const GroundTruth truth = Compute();
  EXPECT_EQ(truth.levels().size(), 1u);
  EXPECT_FALSE(truth.Find({5, 2, 2.5f}).has_value());
}

TEST_F(GroundTruthTest, AWayIsDriveableIfARobotHasRoomAllAlongIt) {
  AddBox({3, 0, 0}, {3.1f, 2, 2});
  const GroundTruth truth = Compute();
  EXPECT_TRUE(truth.IsDriveable({{1, 3, 0}, {5, 3, 0}}, 0.36));
  EXPECT_FALSE(truth.IsDriveable({{1, 1, 0}, {5, 1, 0}}, 0.36));
  EXPECT_FALSE(truth.IsDriveable({{1, 2.3f, 0}, {5, 2.3f, 0}}, 0.36));
  EXPECT_FALSE(truth.IsDriveable({{1, 3, 1}, {5, 3, 1}}, 0.36));
}

TEST(GroundTruthOptionsTest, OptionsOutOfRangeAreNamed) {
  const GroundTruthOptions options = {.resolution_m = 0};
  EXPECT_THAT(options.Validate().message(), HasSubstr("resolution_m"));
  World huge;
  huge.size_m = {200, 200, 3};
  EXPECT_EQ(GroundTruth::Compute(huge, GroundTruthOptions()).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::worlds
