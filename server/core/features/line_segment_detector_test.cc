#include "server/core/features/line_segment_detector.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::features {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 150;

// Of what `brightness` says at a place, mean of 4 x 4 places a pixel.
template <typename Brightness>
GrayPyramid::Level Paint(Brightness brightness) {
  GrayPyramid::Level picture{kWidth, kHeight, {}};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double sum = 0;
      for (int i = 0; i < 16; ++i) {
        sum += brightness(x + (i % 4 - 1.5) / 4, y + (i / 4 - 1.5) / 4);
      }
      picture.gray.push_back(static_cast<uint8_t>(std::lround(sum / 16)));
    }
  }
  return picture;
}

double Length(const LineSegment& s) {
  return std::hypot(s.b.x - s.a.x, s.b.y - s.a.y);
}

LineSegment Longest(const std::vector<LineSegment>& segments) {
  return *std::ranges::max_element(segments, {}, Length);
}

TEST(FindLineSegmentsTest, AnEdgeOfAnyDirectionLiesWhereItIs) {
  for (int degrees = 0; degrees < 360; degrees += 15) {
    const double turn = (degrees + 3) * std::numbers::pi / 180;
    const double nx = std::cos(turn);
    const double ny = std::sin(turn);
    // Bright on the side of (nx, ny), half a pixel and more beside the middle.
    const auto offset = [&](double x, double y) {
      return (x - 100.3) * nx + (y - 74.6) * ny;
    };
    const auto segments = FindLineSegments(
        Paint([&](double x, double y) { return offset(x, y) > 0 ? 90 : 60; }));
    ASSERT_FALSE(segments.empty()) << degrees;
    const LineSegment s = Longest(segments);
    EXPECT_GT(Length(s), 100) << degrees;
    EXPECT_NEAR(offset(s.a.x, s.a.y), 0, 0.25) << degrees;
    EXPECT_NEAR(offset(s.b.x, s.b.y), 0, 0.25) << degrees;
    // The brighter side is to the right, y being down.
    EXPECT_GT(-(s.b.y - s.a.y) * nx + (s.b.x - s.a.x) * ny, 0) << degrees;
  }
}

TEST(FindLineSegmentsTest, EndsAreWhereTheEdgeEnds) {
  const auto segments = FindLineSegments(Paint([](double x, double y) {
    return x > 60 && x < 140 && y > 50 && y < 100 ? 120 : 60;
  }));
  ASSERT_EQ(segments.size(), 4U);
  for (const LineSegment& s : segments) {
    const bool upright = std::abs(s.a.x - s.b.x) < std::abs(s.a.y - s.b.y);
    EXPECT_NEAR(Length(s), upright ? 50 : 80, 4);
    const double edge = upright ? s.a.x : s.a.y;
    const double low = upright ? 60 : 50;
    const double high = upright ? 140 : 100;
    EXPECT_LT(std::min(std::abs(edge - low), std::abs(edge - high)), 0.2);
  }
}

TEST(FindLineSegmentsTest, ABentEdgeIsSeveralSegmentsThatStayOnIt) {
  const auto radius = [](double x, double y) {
    return std::hypot(x - 100, y - 75);
  };
  const auto segments = FindLineSegments(
      Paint([&](double x, double y) { return radius(x, y) < 60 ? 150 : 50; }));
  ASSERT_GE(segments.size(), 8U);
  double all_px = 0;
  for (const LineSegment& s : segments) {
    all_px += Length(s);
    EXPECT_LT(Length(s), 70);
    EXPECT_NEAR(radius(0.5 * (s.a.x + s.b.x), 0.5 * (s.a.y + s.b.y)), 60, 3);
  }
  EXPECT_GT(all_px, 0.6 * 2 * std::numbers::pi * 60);
}

TEST(FindLineSegmentsTest, WhereThereIsNoEdgeThereIsNoSegment) {
  EXPECT_TRUE(
      FindLineSegments(Paint([](double, double) { return 80; })).empty());
  // A slope that is no edge.
  EXPECT_TRUE(
      FindLineSegments(Paint([](double x, double) { return x; })).empty());
  base::Random random(7, 0);
  EXPECT_TRUE(FindLineSegments(Paint([&](double, double) {
                return 100 + static_cast<double>(random.NextBelow(9));
              })).empty());
}

TEST(FindLineSegmentsTest, NoiseAloneHasNoLongSegments) {
  base::Random random(8, 0);
  GrayPyramid::Level picture{kWidth, kHeight, {}};
  picture.gray.resize(static_cast<size_t>(kWidth) * kHeight);
  for (uint8_t& v : picture.gray) {
    v = static_cast<uint8_t>(random.NextBelow(256));
  }
  for (const LineSegment& s : FindLineSegments(picture)) {
    EXPECT_LT(Length(s), 20);
  }
}

TEST(FindLineSegmentsTest, PicturesOfAnySizeAreTaken) {
  struct Size {
    int width;
    int height;
    size_t segments;
  };
  for (const Size size : {Size{0, 0, 0},
                          {1, 300, 0},
                          {7, 300, 0},
                          {300, 7, 0},
                          {8, 8, 1},
                          {9, 200, 1},
                          {300, 20, 1},
                          {40000, 8, 0}}) {
    GrayPyramid::Level picture{size.width, size.height, {}};
    for (int i = 0; i < size.width * size.height; ++i) {
      picture.gray.push_back(i % size.width < size.width / 2 ? 0 : 255);
    }
    const auto segments = FindLineSegments(picture);
    ASSERT_EQ(segments.size(), size.segments) << size.width;
    for (const LineSegment& s : segments) {
      EXPECT_NEAR(s.a.x, size.width / 2 - 0.5, 0.25);
    }
  }
}

}  // namespace
}  // namespace treeline::features
