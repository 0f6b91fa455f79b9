// Worlds whose furniture was moved about.
#include "simulation/worlds/rearrange.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "simulation/worlds/ground_truth.h"
#include "simulation/worlds/world.h"

namespace treeline::worlds {
namespace {

World Make(const std::string& name, const Rearrangement& rearranged) {
  return *MakeWorld(name, {.rearranged = rearranged,
                           .with_people = false,
                           .threads = 1,
                           .paint = false});
}

bool IsSame(const Surface& a, const Surface& b) {
  return a.corners == b.corners && a.texture == b.texture &&
         a.texture_origin == b.texture_origin && a.emission == b.emission;
}

bool IsInPiece(const World& world, size_t surface) {
  return std::ranges::any_of(world.pieces, [&](const Piece& piece) {
    return surface >= piece.first_surface &&
           surface < piece.first_surface + piece.surface_count;
  });
}

// How far the middle of each of the pieces went; -1: it is gone.
std::vector<double> WaysOf(const World& before, const World& after) {
  const auto middle = [](const World& world, const Piece& piece) {
    Float3 low = world.surfaces[piece.first_surface].corners[0];
    Float3 high = low;
    for (size_t k = 0; k < piece.surface_count; ++k) {
      for (const Float3& p : world.surfaces[piece.first_surface + k].corners) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y),
               std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y),
                std::max(high.z, p.z)};
      }
    }
    return 0.5f * (low + high);
  };
  std::vector<double> ways;
  for (size_t i = 0; i < before.pieces.size(); ++i) {
    const Piece& was = before.pieces[i];
    const Piece& is = after.pieces[i];
    if (is.surface_count == 0) {
      ways.push_back(-1);
      continue;
    }
    EXPECT_EQ(is.surface_count, was.surface_count);
    for (size_t k = 0; k < is.surface_count; ++k) {
      EXPECT_EQ(after.surfaces[is.first_surface + k].texture_origin,
                before.surfaces[was.first_surface + k].texture_origin);
    }
    ways.push_back(Norm(middle(after, is) - middle(before, was)));
  }
  return ways;
}

TEST(RearrangeTest, ChangesTheShareThatIsAskedFor) {
  for (const std::string name : {"cafe", "lab", "two-storey", "seed:17"}) {
    SCOPED_TRACE(name);
    const World before = Make(name, {});
    ASSERT_GT(before.pieces.size(), 8u);
    double changed = 0;
    double gone = 0;
    double all = 0;
    for (const uint64_t seed : {1, 2, 3, 4}) {
      const World after = Make(name, {.seed = seed, .share = 0.4});
      for (const double way_m : WaysOf(before, after)) {
        all += 1;
        if (way_m != 0) changed += 1;
        if (way_m < 0) gone += 1;
        // What is turned is not centred any more.
        EXPECT_LT(way_m, 1.3);
      }
    }
    // Three standard deviations of a binomial draw of at least 36.
    EXPECT_NEAR(changed / all, 0.4, 3 * std::sqrt(0.24 / all));
    // 0.3 of them by chance, and some that find no room.
    EXPECT_GT(gone / changed, 0.1);
    EXPECT_LT(gone / changed, 0.8);
  }
}

TEST(RearrangeTest, LeavesWhatIsFixed) {
  const World before = Make("cafe", {});
  const World after = Make("cafe", {.seed = 5, .share = 1});
  EXPECT_LT(after.surfaces.size(), before.surfaces.size());
  for (size_t i = 0; i < before.surfaces.size(); ++i) {
    if (IsInPiece(before, i)) continue;
    EXPECT_TRUE(std::ranges::any_of(after.surfaces, [&](const Surface& is) {
      return IsSame(before.surfaces[i], is);
    })) << i;
  }
  const World same = Make("cafe", {.seed = 5, .share = 1});
  ASSERT_EQ(same.surfaces.size(), after.surfaces.size());
  for (size_t i = 0; i < same.surfaces.size(); ++i) {
    EXPECT_TRUE(IsSame(same.surfaces[i], after.surfaces[i]));
  }
  const World other = Make("cafe", {.seed = 6, .share = 1});
  EXPECT_FALSE(other.surfaces.size() == after.surfaces.size() &&
               std::ranges::equal(other.surfaces, after.surfaces, IsSame));
}

TEST(RearrangeTest, KeepsTheTourDriveable) {
  for (const std::string name : {"cafe", "lab", "two-storey", "seed:17"}) {
    SCOPED_TRACE(name);
    const World world = Make(name, {.seed = 2, .share = 0.7});
    const auto truth = GroundTruth::Compute(world, GroundTruthOptions());
    ASSERT_TRUE(truth.ok()) << truth.status();
    std::vector<Float3> tour = world.tour;
    tour.push_back(tour.front());
    EXPECT_TRUE(truth->IsDriveable(tour, 0.36));
  }
}

TEST(RearrangeTest, MovesFurnitureOfRoomsToo) {
  const World before = *MakeWorld("room", {.threads = 1});
  EXPECT_GE(before.pieces.size(), 8u);
  const World after =
      *MakeWorld("room", {.rearranged = {.seed = 1, .share = 1}, .threads = 1});
  const std::vector<double> ways = WaysOf(before, after);
  EXPECT_EQ(std::ranges::count(ways, 0.0), 0);
  EXPECT_GT(std::ranges::count_if(ways, [](double m) { return m > 0; }), 0);
}

TEST(RearrangeTest, ReadsSeedAndShare) {
  EXPECT_EQ(*ParseRearrangement("3:0.4"),
            (Rearrangement{.seed = 3, .share = 0.4}));
  for (const char* text : {"", "3", "3:", ":0.4", "-1:0.4", "3:1.5", "3:x"}) {
    EXPECT_FALSE(ParseRearrangement(text).ok()) << text;
  }
}

}  // namespace
}  // namespace treeline::worlds
