#include "server/core/forest/sift_places.h"

#include <set>
#include <tuple>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::forest {
namespace {

features::SiftDescriptor RandomDescriptor(base::Random& random) {
  features::SiftDescriptor descriptor;
  for (uint8_t& value : descriptor.values) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  return descriptor;
}

// Modes at 300 places of a cube with sides of 2; those of three trees, one
// after the other.
Forest RandomForest() {
  base::Random random(3, 0);
  Forest forest;
  std::vector<LeafPayload> places(300);
  for (LeafPayload& place : places) {
    for (uint16_t& x : place.mean) {
      x = static_cast<uint16_t>(random.NextBelow(65536));
    }
  }
  for (int i = 0; i < 900; ++i) {
    forest.payloads.push_back(places[random.NextBelow(300)]);
    forest.sift_descriptors.push_back(RandomDescriptor(random));
  }
  forest.bounds_min_in_world = {-1, -1, -1};
  forest.bounds_max_in_world = {1, 1, 1};
  return forest;
}

// The nearest of all modes that are seen within the window.
SiftMatch Reference(const ForestView& forest,
                    const geometry::Rigid3& camera_from_world,
                    const camera::Pixel& ray,
                    const features::SiftDescriptor& descriptor,
                    const SiftWindow& window) {
  SiftMatch match{.distance = window.max_squared_distance + 1};
  for (uint32_t m = 0; m < forest.payloads.size(); ++m) {
    const geometry::Vec3 point = camera_from_world * forest.LeafMean(m);
    const geometry::Vec3 off{point.x / point.z - ray.x,
                             point.y / point.z - ray.y, 0};
    const int32_t distance =
        SquaredDistance(descriptor, forest.sift_descriptors[m]);
    if (point.z > 0 && geometry::Norm(off) <= window.radius &&
        distance < match.distance) {
      match = {.mode = m, .distance = distance};
    }
  }
  return match;
}

class SiftPlacesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    base::Random random(4, 0);
    for (int i = 0; i < 400; ++i) {
      rays_.push_back(
          {random.NextUniform(-0.8, 0.8), random.NextUniform(-0.8, 0.8)});
      descriptors_.push_back(RandomDescriptor(random));
      if (i % 3 != 0) which_.push_back(static_cast<uint32_t>(i));
    }
  }

  const Forest forest_ = RandomForest();
  std::vector<camera::Pixel> rays_;
  std::vector<features::SiftDescriptor> descriptors_;
  std::vector<uint32_t> which_;
};

TEST_F(SiftPlacesTest, ModesOfOnePlaceStandTogether) {
  std::set<std::tuple<int, int, int>> places;
  for (const LeafPayload& payload : forest_.payloads) {
    places.emplace(payload.mean[0], payload.mean[1], payload.mean[2]);
  }
  const ForestView view = forest_.View();
  EXPECT_EQ(SiftPlaces(view).size(), places.size());
}

TEST_F(SiftPlacesTest, FindsTheNearestModeOfThePlacesThatAreSeenThere) {
  const ForestView view = forest_.View();
  const SiftPlaces places(view);
  // From outside the cube, from within it, and looking away from it.
  const geometry::Rigid3 poses[] = {
      {geometry::Rotation3::FromAxisAngle({0, 0, 0}), {0.1, 0, 3}},
      {geometry::Rotation3::FromAxisAngle({0.3, 1, 0.2}), {0, 0.2, 0.4}},
      {geometry::Rotation3::FromAxisAngle({0, 0, 0}), {0, 0, -3}}};
  std::vector<size_t> found;
  for (const geometry::Rigid3& camera_from_world : poses) {
    // So large that some have a place and some none, and so near that some of
    // those are refused: random descriptors are 1.4 million apart, plus or
    // minus 0.1 million.
    const SiftWindow window{.radius = 0.05, .max_squared_distance = 1400000};
    std::vector<SiftMatch> matches(rays_.size(), {.mode = 7});
    places.Match(camera_from_world, rays_, descriptors_, which_, window,
                 matches);
    found.push_back(0);
    for (uint32_t i = 0; i < rays_.size(); ++i) {
      if (i % 3 == 0) {
        EXPECT_EQ(matches[i].mode, 7u) << "was not asked for";
        continue;
      }
      const SiftMatch expected =
          Reference(view, camera_from_world, rays_[i], descriptors_[i], window);
      EXPECT_EQ(matches[i].mode, expected.mode);
      EXPECT_EQ(matches[i].distance, expected.distance);
      found.back() += matches[i].mode != kNoLeaf;
    }
  }
  EXPECT_GT(found[0], 50u);
  EXPECT_LT(found[0], 260u);
  EXPECT_GT(found[1], 10u);
  EXPECT_EQ(found[2], 0u);
}

TEST_F(SiftPlacesTest, NoFeaturesFindNothing) {
  const ForestView view = forest_.View();
  std::vector<SiftMatch> matches;
  SiftPlaces(view).Match({}, {}, {}, {}, {}, matches);
  EXPECT_TRUE(matches.empty());
}

}  // namespace
}  // namespace treeline::forest
