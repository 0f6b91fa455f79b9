#include "nav_agent/rgbd_slam/slam_map.h"

#include <utility>
#include <vector>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/rgbd_slam/binary_features.h"
#include "nav_agent/rgbd_slam/bundle_adjustment.h"
#include "nav_agent/rgbd_slam/testing_room.h"
#include "nav_agent/rgbd_slam/word_index.h"

namespace treeline::rgbd_slam {
namespace {

using ::testing::Each;
using ::testing::SizeIs;

const Pinhole kPinhole = {.fx = 500, .fy = 500, .cx = 320, .cy = 240};

BinaryDescriptor DescriptorOf(uint64_t number) {
  base::Random random(number, 9);
  return {random.NextBits(), random.NextBits(), random.NextBits(),
          random.NextBits()};
}

ImageFeature Like(const BinaryDescriptor& descriptor) {
  ImageFeature feature;
  feature.descriptor = descriptor;
  return feature;
}

// Points of a wall 2 m before the origin.
std::vector<geometry::Vec3> Wall(int count) {
  std::vector<geometry::Vec3> points;
  base::Random random(3, 1);
  for (int i = 0; i < count; ++i) {
    points.push_back({random.NextUniform(-1, 1), random.NextUniform(-0.7, 0.7),
                      random.NextUniform(1.8, 2.2)});
  }
  return points;
}

// A keyframe that sees all of them, with noise of so many pixels.
MapKeyframe See(const std::vector<geometry::Vec3>& points,
                const geometry::Rigid3& map_from_camera, double noise_px = 0) {
  std::vector<ImageFeature> features;
  base::Random random(4, 1);
  for (size_t i = 0; i < points.size(); ++i) {
    const geometry::Vec3 p = map_from_camera.Inverse() * points[i];
    camera::Pixel pixel = kPinhole.Project(p);
    pixel.x += noise_px * random.NextGaussian();
    pixel.y += noise_px * random.NextGaussian();
    features.push_back(
        {.pixel = pixel, .depth_m = p.z, .descriptor = DescriptorOf(i)});
  }
  MapKeyframe keyframe;
  keyframe.map_from_camera = map_from_camera;
  keyframe.features = FeatureSet(640, 480, std::move(features));
  return keyframe;
}

geometry::Rigid3 Shifted(double x_m) {
  return {.rotation = {}, .translation = {x_m, 0, 0}};
}

// As See, but each feature is a sighting of the landmark of that number.
MapKeyframe SeeAgain(const std::vector<geometry::Vec3>& points,
                     const geometry::Rigid3& map_from_camera,
                     double noise_px = 0) {
  MapKeyframe keyframe = See(points, map_from_camera, noise_px);
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    keyframe.landmarks.push_back(i);
  }
  return keyframe;
}

TEST(SlamMap, MakesLandmarksOfWhatIsNewAndCountsWhatIsShared) {
  const std::vector<geometry::Vec3> wall = Wall(50);
  SlamMap map(kPinhole);
  map.AddKeyframe(See(wall, {}));
  EXPECT_EQ(map.landmark_count(), 50);
  MapKeyframe second = See(wall, Shifted(0.1));
  for (int i = 0; i < 20; ++i) second.landmarks.push_back(i);
  map.AddKeyframe(std::move(second));
  EXPECT_EQ(map.landmark_count(), 80);
  ASSERT_THAT(map.CovisibleWith(1, 15), SizeIs(1));
  EXPECT_EQ(map.CovisibleWith(1, 15)[0].shared, 20);
  EXPECT_THAT(map.CovisibleWith(1, 21), SizeIs(0));
  const std::vector<KeyframeEdge> edges = map.CovisibilityEdges(15);
  ASSERT_THAT(edges, SizeIs(1));
  EXPECT_NEAR(edges[0].from_from_to.translation.x, 0.1, 1e-12);
  for (int l = 0; l < 80; ++l) {
    const geometry::Vec3 truth = wall[static_cast<size_t>(l < 50 ? l : l - 30)];
    EXPECT_LT(geometry::Norm(map.landmark(l).point_in_map - truth), 1e-9);
  }
}

TEST(SlamMap, FusingMakesDuplicatesOne) {
  const std::vector<geometry::Vec3> wall = Wall(50);
  SlamMap map(kPinhole);
  map.AddKeyframe(See(wall, {}));
  map.AddKeyframe(See(wall, Shifted(0.1)));
  const Covisible first{0, 0};
  const int found = map.FuseInto(1, map.LandmarksOf({&first, 1}, 1000), 3);
  EXPECT_EQ(found, 50);
  EXPECT_THAT(map.CovisibleWith(1, 50), SizeIs(1));
  int left = 0;
  for (int l = 0; l < map.landmark_count(); ++l) {
    left += map.landmark(l).is_erased ? 0 : 1;
  }
  EXPECT_EQ(left, 50);
}

TEST(SlamMap, ErasedLandmarksAreSeenByNobody) {
  const std::vector<geometry::Vec3> wall = Wall(10);
  SlamMap map(kPinhole);
  map.AddKeyframe(See(wall, {}));
  map.AddKeyframe(SeeAgain(wall, Shifted(0.1)));
  for (int l = 0; l < 10; ++l) map.EraseLandmark(l);
  EXPECT_THAT(map.keyframe(0).landmarks, Each(kNoLandmark));
  EXPECT_THAT(map.keyframe(1).landmarks, Each(kNoLandmark));
  EXPECT_THAT(map.CovisibleWith(0, 1), SizeIs(0));
}

TEST(SlamMap, LandmarksMoveWithTheirSubmap) {
  const std::vector<geometry::Vec3> wall = Wall(10);
  SlamMap map(kPinhole);
  map.AddKeyframe(See(wall, {}));
  MapKeyframe other = See(wall, Shifted(5));
  other.submap = 1;
  map.AddKeyframe(std::move(other));
  map.JoinSubmap(1, 0, Shifted(-5));
  EXPECT_EQ(map.keyframe(1).submap, 0);
  EXPECT_LT(geometry::Norm(map.keyframe(1).map_from_camera.translation), 1e-12);
  EXPECT_LT(geometry::Norm(map.landmark(0).point_in_map - wall[0]), 1e-12);
  EXPECT_LT(geometry::Norm(map.landmark(10).point_in_map -
                           (wall[0] - geometry::Vec3{5, 0, 0})),
            1e-12);
}

TEST(BundleAdjustment, BringsAKeyframeBack) {
  const std::vector<geometry::Vec3> wall = Wall(100);
  SlamMap map(kPinhole);
  map.AddKeyframe(See(wall, {}));
  for (int k = 1; k < 5; ++k) {
    map.AddKeyframe(SeeAgain(wall, Shifted(0.1 * k)));
  }
  map.keyframe(4).map_from_camera.translation.y += 0.02;
  map.keyframe(4).map_from_camera.rotation =
      geometry::Rotation3::FromAxisAngle({0, 0.01, 0});
  AdjustLocally(4, {.window = 2, .iterations = 10}, &map);
  const geometry::PoseError error =
      geometry::ErrorBetween(map.keyframe(4).map_from_camera, Shifted(0.4));
  EXPECT_LT(error.translation_m, 1e-4);
  EXPECT_LT(error.rotation_rad, 1e-4);
}

TEST(BundleAdjustment, ForgetsWhatDoesNotAgree) {
  const std::vector<geometry::Vec3> wall = Wall(100);
  SlamMap map(kPinhole);
  map.AddKeyframe(See(wall, {}));
  map.AddKeyframe(SeeAgain(wall, Shifted(0.1)));
  std::vector<geometry::Vec3> wrong = wall;
  wrong[7].x += 0.3;
  map.AddKeyframe(SeeAgain(wrong, Shifted(0.2)));
  AdjustLocally(2, {.iterations = 10}, &map);
  EXPECT_EQ(map.keyframe(2).landmarks[7], kNoLandmark);
  EXPECT_EQ(map.keyframe(2).landmarks[8], 8);
  EXPECT_LT(
      geometry::ErrorBetween(map.keyframe(2).map_from_camera, Shifted(0.2))
          .translation_m,
      1e-3);
}

TEST(BundleAdjustment, OptionsAreChecked) {
  EXPECT_TRUE(BundleOptions().Validate().ok());
  EXPECT_FALSE(BundleOptions{.window = 0}.Validate().ok());
  EXPECT_FALSE(BundleOptions{.iterations = 1000}.Validate().ok());
}

TEST(OptimizeKeyframes, SpreadsTheErrorOfALoop) {
  // Eleven keyframes in a row, 1 m apart, of which each step was measured 1 %
  // too long; a loop says where the last one truly is.
  SlamMap map(kPinhole);
  std::vector<KeyframeEdge> edges;
  for (int k = 0; k <= 10; ++k) {
    map.AddKeyframe(See(Wall(1), Shifted(1.01 * k)));
    if (k > 0) {
      edges.push_back({.from = k - 1,
                       .to = k,
                       .from_from_to = Shifted(1.01),
                       .shared = 50});
    }
  }
  const KeyframeEdge loop{
      .from = 0, .to = 10, .from_from_to = Shifted(10), .shared = 5000};
  OptimizeKeyframes(edges, {&loop, 1}, 0, 50, &map);
  for (int k = 0; k <= 10; ++k) {
    EXPECT_NEAR(map.keyframe(k).map_from_camera.translation.x, k, 0.01) << k;
    EXPECT_NEAR(map.keyframe(k).map_from_camera.translation.y, 0, 1e-6);
  }
  // Landmarks went along: the last keyframe by 0.1 m.
  EXPECT_NEAR(map.landmark(10).point_in_map.x, Wall(1)[0].x - 0.1, 0.011);
}

TEST(WordIndex, FindsThePictureThatLooksLikeIt) {
  // Ten pictures of random descriptors; one of them again with an eighth of
  // all bits flipped, and a half of its features gone.
  WordIndex index(1);
  for (uint64_t picture = 0; picture < 10; ++picture) {
    std::vector<ImageFeature> features;
    for (uint64_t i = 0; i < 200; ++i) {
      features.push_back(Like(DescriptorOf(1000 * picture + i)));
    }
    index.Add(FeatureSet(640, 480, std::move(features)));
  }
  std::vector<ImageFeature> again;
  base::Random random(6, 1);
  for (uint64_t i = 0; i < 100; ++i) {
    BinaryDescriptor descriptor = DescriptorOf(4000 + i);
    for (uint64_t& part : descriptor) {
      part ^= random.NextBits() & random.NextBits() & random.NextBits();
    }
    again.push_back(Like(descriptor));
  }
  const std::vector<double> scores =
      index.Score(FeatureSet(640, 480, std::move(again)));
  ASSERT_THAT(scores, SizeIs(10));
  for (size_t k = 0; k < 10; ++k) {
    if (k == 4) continue;
    EXPECT_GT(scores[4], 2 * scores[k]) << k;
  }
}

TEST(HammingDistance, CountsBits) {
  EXPECT_EQ(HammingDistance({0, 0, 0, 0}, {1, 2, 4, ~uint64_t{0}}), 67);
}

TEST(FeatureSet, FindsWhatIsNear) {
  FeatureSet set(100, 80,
                 {{.pixel = {10, 10}},
                  {.pixel = {14, 10}},
                  {.pixel = {99.4, 79.4}},
                  {.pixel = {-3, 40}}});
  std::vector<int> found;
  set.Near({11, 11}, 2, &found);
  EXPECT_EQ(found, (std::vector<int>{0}));
  set.Near({12, 10}, 2, &found);
  EXPECT_EQ(found, (std::vector<int>{0, 1}));
  set.Near({110, 90}, 12, &found);
  EXPECT_EQ(found, (std::vector<int>{2}));
  set.Near({0, 40}, 3, &found);
  EXPECT_EQ(found, (std::vector<int>{3}));
  EXPECT_FALSE(set.Contains({-3, 40}));
}

TEST(FeatureExtractor, SpreadsCornersAndGivesThemDepth) {
  const camera::RgbdCalibration calibration = TestingCalibration();
  const image::Frame frame =
      SeeTestingRoom(calibration, TestingPose(0, 0, 0.2), 1);
  FeatureExtractor extractor(calibration, {.count = 300});
  const auto features = extractor.Extract(frame);
  ASSERT_TRUE(features.ok()) << features.status();
  EXPECT_GT(features->size(), 250);
  int with_depth = 0;
  std::vector<int> in_quarter(4, 0);
  for (const ImageFeature& feature : features->all()) {
    with_depth += feature.depth_m > 0.5 && feature.depth_m < 4 ? 1 : 0;
    ++in_quarter[static_cast<size_t>((feature.pixel.x < 160 ? 0 : 1) +
                                     (feature.pixel.y < 120 ? 0 : 2))];
  }
  EXPECT_GT(with_depth, 240);
  for (const int count : in_quarter) EXPECT_GT(count, 45);
}

TEST(FeatureExtractor, RefusesFramesOfAnotherSize) {
  const camera::RgbdCalibration calibration = TestingCalibration();
  FeatureExtractor extractor(calibration, {});
  image::Frame frame = SeeTestingRoom(calibration, TestingPose(0, 0, 0), 1);
  frame.depth.reset();
  EXPECT_EQ(extractor.Extract(frame).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(extractor.Extract({}).ok());
}

}  // namespace
}  // namespace treeline::rgbd_slam
