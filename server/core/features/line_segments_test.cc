#include "server/core/features/line_segments.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "gtest/gtest.h"
#include "server/core/features/walsh_hadamard.h"

namespace treeline::features {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// Colour and depth side by side, of different lenses.
camera::RgbdCalibration Pair() {
  camera::RgbdCalibration calibration;
  calibration.color =
      *camera::Camera::Parse("PINHOLE,300,300,160,120", kWidth, kHeight);
  calibration.depth =
      *camera::Camera::Parse("PINHOLE,320,320,155,118", kWidth, kHeight);
  calibration.color_from_depth = {
      geometry::Rotation3::FromAxisAngle({0, 0.01, 0}), {-0.03, 0, 0}};
  return calibration;
}

// A dark rectangle, x in [-0.4, 0.4] and y in [-0.3, 0.3] (m, colour camera's
// frame), on a bright plane z = 2 + slope * x; or, `in_front` by that much, on
// a wall behind it.
struct Scene {
  double slope = 0;
  double in_front_m = 0;

  bool InRectangle(geometry::Vec3 p) const {
    return std::abs(p.x) <= 0.4 && std::abs(p.y) <= 0.3;
  }
  // Where the ray from `origin` meets the scene.
  geometry::Vec3 Hit(geometry::Vec3 origin, geometry::Vec3 direction) const {
    const auto meet = [&](double z0) {
      // origin.z + t dz = z0 + slope (origin.x + t dx)
      const double t = (z0 + slope * origin.x - origin.z) /
                       (direction.z - slope * direction.x);
      return origin + t * direction;
    };
    const geometry::Vec3 front = meet(2);
    return InRectangle(front) || in_front_m == 0 ? front : meet(2 + in_front_m);
  }
};

GrayPyramid ColorOf(const Scene& scene,
                    const camera::RgbdCalibration& calibration) {
  image::ColorImage image{kWidth, kHeight, {}};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      // Four rays a pixel, as a lens would blur.
      int brightness = 0;
      for (const double dx : {-0.25, 0.25}) {
        for (const double dy : {-0.25, 0.25}) {
          const auto ray = calibration.color.Unproject({x + dx, y + dy});
          const bool dark =
              scene.InRectangle(scene.Hit({}, {ray->x, ray->y, 1}));
          brightness += dark ? 10 : 50;
        }
      }
      image.rgb.insert(image.rgb.end(), 3, static_cast<uint8_t>(brightness));
    }
  }
  GrayPyramid pyramid;
  pyramid.Assign(PlanarImage(image));
  return pyramid;
}

// What the depth camera measures, in millimetres.
image::DepthImage DepthOf(const Scene& scene,
                          const camera::RgbdCalibration& calibration) {
  image::DepthImage depth{kWidth, kHeight, {}, 0.001};
  const geometry::Rigid3& color_from_depth = calibration.color_from_depth;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto ray = calibration.depth.Unproject(
          {static_cast<double>(x), static_cast<double>(y)});
      const geometry::Vec3 hit = scene.Hit(
          color_from_depth.translation,
          color_from_depth.rotation * geometry::Vec3{ray->x, ray->y, 1});
      depth.values.push_back(static_cast<uint16_t>(
          std::lround(1000 * (color_from_depth.Inverse() * hit).z)));
    }
  }
  return depth;
}

// Distance of a point from the nearest edge of the rectangle, in x and y.
double DistanceToEdges(geometry::Vec3 p) {
  const double dx = std::abs(std::abs(p.x) - 0.4);
  const double dy = std::abs(std::abs(p.y) - 0.3);
  return std::min(dx, dy);
}

LinePoints Lift(const Scene& scene, const camera::RgbdCalibration& calibration,
                const image::DepthImage& depth) {
  LinePoints points;
  LiftSegments(DepthGeometry(calibration), depth,
               DetectLineSegments(ColorOf(scene, calibration), {}), {}, points);
  return points;
}

TEST(DetectLineSegmentsTest, FindsTheEdgesOfARectangleWhereTheyAre) {
  // At 300 px and 2 m the edges lie at 160 +- 60 and 120 +- 45.
  for (const int level : {0, 1}) {
    LineOptions options;
    options.level = level;
    const auto segments = DetectLineSegments(ColorOf({}, Pair()), options);
    ASSERT_EQ(segments.size(), 4u) << level;
    std::set<int> found;
    for (const LineSegment& s : segments) {
      const double x = 0.5 * (s.a.x + s.b.x);
      const double y = 0.5 * (s.a.y + s.b.y);
      const bool upright = std::abs(s.a.x - s.b.x) < std::abs(s.a.y - s.b.y);
      // A quarter of a pixel of the level looked at.
      const double tolerance_px = 0.25 * (1 << level);
      if (upright) {
        EXPECT_NEAR(std::abs(x - 160), 60, tolerance_px);
        found.insert(x < 160 ? 0 : 1);
      } else {
        EXPECT_NEAR(std::abs(y - 120), 45, tolerance_px);
        found.insert(y < 120 ? 2 : 3);
      }
    }
    EXPECT_EQ(found.size(), 4u);
  }
}

TEST(DetectLineSegmentsTest, DropsTheShortestAndWhatIsTooShort) {
  const GrayPyramid pyramid = ColorOf({}, Pair());
  LineOptions options;
  options.max_segments = 2;
  const auto two = DetectLineSegments(pyramid, options);
  ASSERT_EQ(two.size(), 2u);
  // The long edges are the level ones.
  for (const LineSegment& s : two) EXPECT_NEAR(s.a.y, s.b.y, 1);
  options.max_segments = 100;
  options.min_length_px = 150;
  EXPECT_TRUE(DetectLineSegments(pyramid, options).empty());
}

TEST(DetectLineSegmentsTest, TinyAndPlainImagesHaveNone) {
  for (const int size : {1, 8, 40}) {
    GrayPyramid pyramid;
    pyramid.Assign(PlanarImage(image::ColorImage{
        size, size,
        std::vector<uint8_t>(static_cast<size_t>(3 * size * size))}));
    EXPECT_TRUE(DetectLineSegments(pyramid, {}).empty());
  }
}

TEST(LiftSegmentsTest, PutsLinesWhereTheEdgesAre) {
  for (const double slope : {0., 0.5}) {
    const camera::RgbdCalibration calibration = Pair();
    const Scene scene{slope, 0};
    const LinePoints points =
        Lift(scene, calibration, DepthOf(scene, calibration));
    ASSERT_EQ(points.lines.size(), 4u);
    ASSERT_GT(points.size(), 80u);
    for (const SpaceLine& line : points.lines) {
      EXPECT_NEAR(geometry::Norm(line.direction), 1, 1e-12);
      // Upright, or level and along the slope; within 5 mm over 0.6 m.
      const geometry::Vec3 level =
          geometry::Normalized(geometry::Vec3{1, 0, slope});
      EXPECT_GT(std::max(std::abs(line.direction.y),
                         std::abs(geometry::Dot(line.direction, level))),
                std::cos(0.01));
    }
    for (size_t i = 0; i < points.size(); ++i) {
      const geometry::Vec3 p = points.samples.point[i];
      // Half a pixel at 2 m and 300 px; depth is in millimetres.
      EXPECT_LT(DistanceToEdges(p), 0.0034);
      EXPECT_NEAR(p.z, 2 + slope * p.x, 0.002 + slope * 0.0034);
      const SpaceLine& line = points.lines[static_cast<size_t>(points.line[i])];
      EXPECT_LT(geometry::Norm(geometry::Cross(p - line.point, line.direction)),
                1e-9);
      EXPECT_TRUE(PatchInside(points.samples.x[i], points.samples.y[i], kWidth,
                              kHeight));
    }
  }
}

TEST(LiftSegmentsTest, AnswersInThePoseSensorsFrame) {
  camera::RgbdCalibration calibration = Pair();
  const image::DepthImage depth = DepthOf({}, calibration);
  const LinePoints in_color = Lift({}, calibration, depth);
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  const LinePoints in_depth = Lift({}, calibration, depth);
  ASSERT_EQ(in_color.size(), in_depth.size());
  for (size_t i = 0; i < in_color.size(); ++i) {
    EXPECT_LT(geometry::Norm(calibration.color_from_depth *
                                 in_depth.samples.point[i] -
                             in_color.samples.point[i]),
              1e-9);
  }
}

TEST(LiftSegmentsTest, EdgesBelongToTheSurfaceInFront) {
  const Scene scene{0, 1};
  const camera::RgbdCalibration calibration = Pair();
  const LinePoints points =
      Lift(scene, calibration, DepthOf(scene, calibration));
  ASSERT_GE(points.lines.size(), 3u);
  for (const geometry::Vec3& p : points.samples.point) {
    EXPECT_NEAR(p.z, 2, 0.003);
    EXPECT_LT(DistanceToEdges(p), 0.0034);
  }
}

TEST(LiftSegmentsTest, GapsAndOutliersOfDepthAreLeftOut) {
  const camera::RgbdCalibration calibration = Pair();
  image::DepthImage depth = DepthOf({}, calibration);
  base::Random random(1, 0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      uint16_t& value = depth.values[static_cast<size_t>(y * kWidth + x)];
      if (x / 16 % 4 == 0) value = 0;
      // A fifth of the columns of four is somewhere in front.
      if (x / 4 % 5 == 0) {
        value = static_cast<uint16_t>(800 + random.NextBelow(800));
      }
    }
  }
  LineOptions options;
  options.min_support = 0.25;
  LinePoints points;
  LiftSegments(DepthGeometry(calibration), depth,
               DetectLineSegments(ColorOf({}, calibration), options), options,
               points);
  ASSERT_GE(points.lines.size(), 2u);
  for (const geometry::Vec3& p : points.samples.point)
    EXPECT_NEAR(p.z, 2, 0.02);
}

TEST(LiftSegmentsTest, SegmentsWithoutSupportAreDropped) {
  const camera::RgbdCalibration calibration = Pair();
  image::DepthImage none = DepthOf({}, calibration);
  std::ranges::fill(none.values, uint16_t{0});
  EXPECT_EQ(Lift({}, calibration, none).size(), 0u);
  image::DepthImage anything = none;
  base::Random random(2, 0);
  for (uint16_t& value : anything.values) {
    value = static_cast<uint16_t>(500 + random.NextBelow(3000));
  }
  EXPECT_EQ(Lift({}, calibration, anything).size(), 0u);
}

TEST(DrawLinePointsTest, DrawsEachPointAtMostOnceInRandomOrder) {
  const camera::RgbdCalibration calibration = Pair();
  const LinePoints all = Lift({}, calibration, DepthOf({}, calibration));
  LinePoints drawn;
  DrawLinePoints(all, 50, base::Random(1, 0), drawn);
  ASSERT_EQ(drawn.size(), 50u);
  std::set<std::pair<int, int>> pixels;
  for (size_t i = 0; i < drawn.size(); ++i) {
    pixels.insert({drawn.samples.x[i], drawn.samples.y[i]});
    const SpaceLine& line = drawn.lines[static_cast<size_t>(drawn.line[i])];
    EXPECT_LT(geometry::Norm(geometry::Cross(
                  drawn.samples.point[i] - line.point, line.direction)),
              1e-9);
  }
  // Corners may be on two lines.
  EXPECT_GE(pixels.size(), 46u);
  EXPECT_FALSE(std::ranges::is_sorted(drawn.line));
  DrawLinePoints(all, 100000, base::Random(1, 0), drawn);
  EXPECT_EQ(drawn.size(), all.size());
}

}  // namespace
}  // namespace treeline::features
