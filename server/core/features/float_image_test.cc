#include "server/core/features/float_image.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"
#include "server/core/features/gaussian_blur.h"

namespace treeline::features {
namespace {

image::ColorImage Gradient(int width, int height) {
  image::ColorImage image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.rgb.push_back(static_cast<uint8_t>(7 * x + y));
      image.rgb.push_back(static_cast<uint8_t>(3 * y + x * x));
      image.rgb.push_back(static_cast<uint8_t>(x * y + 11));
    }
  }
  return image;
}

TEST(FloatImageTest, BrightnessIsTheWeightedMeanOfNByN) {
  const image::ColorImage image = Gradient(37, 20);
  const auto channel = [&](int x, int y, int c) {
    return int{image.rgb[static_cast<size_t>(3 * (y * 37 + x) + c)]};
  };
  base::WithEachVectorTarget([&] {
    for (const int n : {1, 2, 3}) {
      for (const GrayWeights& weights : {kPlainGray, kLuma}) {
        if (n > MaxReduction(weights)) continue;
        FloatImage gray;
        std::vector<uint16_t> row_sums;
        ReduceToGray(image, n, weights, row_sums, gray);
        ASSERT_EQ(gray.width(), 37 / n);
        ASSERT_EQ(gray.height(), 20 / n);
        for (int y = 0; y < gray.height(); ++y) {
          for (int x = 0; x < gray.width(); ++x) {
            int sum = 0;
            for (int k = 0; k < n * n; ++k) {
              const int u = n * x + k % n;
              const int v = n * y + k / n;
              sum += weights.red * channel(u, v, 0) +
                     weights.green * channel(u, v, 1) +
                     weights.blue * channel(u, v, 2);
            }
            ASSERT_NEAR(gray.row(y)[x], sum / double{1} / weights.sum() / n / n,
                        1e-4);
          }
        }
      }
    }
  });
  EXPECT_EQ(MaxReduction(kPlainGray), 64);
  EXPECT_EQ(MaxReduction(kLuma), 1);
}

FloatImage Slope(int width, int height) {
  FloatImage image;
  image.Resize(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.row(y)[x] = 2 * static_cast<float>(x) - static_cast<float>(y);
    }
  }
  return image;
}

TEST(FloatImageTest, DoublingInterpolatesLinearly) {
  base::WithEachVectorTarget([] {
    for (const int width : {1, 5, 8, 16, 33}) {
      FloatImage doubled;
      DoubleInSize(Slope(width, 7), doubled);
      ASSERT_EQ(doubled.width(), 2 * width);
      ASSERT_EQ(doubled.height(), 14);
      for (int y = 0; y < 14; ++y) {
        for (int x = 0; x < 2 * width; ++x) {
          // Where it lies, and no further out than the outermost pixels.
          const double u = std::clamp(x / 2.0 - 0.25, 0.0, width - 1.0);
          const double v = std::clamp(y / 2.0 - 0.25, 0.0, 6.0);
          ASSERT_NEAR(doubled.row(y)[x], 2 * u - v, 1e-4) << x << " " << y;
        }
      }
    }
  });
}

TEST(FloatImageTest, ShiftingGivesEverySecondPixelOfTheDoubledImage) {
  FloatImage image = Slope(21, 9);
  image.row(3)[5] = 50;
  base::WithEachVectorTarget([&] {
    FloatImage doubled;
    FloatImage shifted;
    DoubleInSize(image, doubled);
    ShiftByQuarter(image, shifted);
    ASSERT_EQ(shifted.width(), 21);
    ASSERT_EQ(shifted.height(), 9);
    for (int y = 0; y < 9; ++y) {
      for (int x = 0; x < 21; ++x) {
        ASSERT_EQ(shifted.row(y)[x], doubled.row(2 * y)[2 * x]);
      }
    }
  });
}

TEST(GaussianBlurTest, SpreadsAPixelAsAGaussian) {
  FloatImage image;
  image.Resize(41, 33);
  for (int y = 0; y < 33; ++y) std::fill_n(image.row(y), 41, 0.0F);
  image.row(16)[20] = 1;
  constexpr double kSigma_px = 1.7;
  base::WithEachVectorTarget([&] {
    FloatImage blurred;
    blurred.Resize(41, 33);
    std::vector<float> row;
    GaussianBlur(static_cast<float>(kSigma_px), 4)
        .Rows(image, 0, 33, blurred, row);
    for (int y = 0; y < 33; ++y) {
      for (int x = 0; x < 41; ++x) {
        const double square = std::pow(x - 20, 2) + std::pow(y - 16, 2);
        const double expected =
            std::exp(-0.5 * square / (kSigma_px * kSigma_px)) /
            (2 * 3.14159265 * kSigma_px * kSigma_px);
        ASSERT_NEAR(blurred.row(y)[x], expected, 1e-4) << x << " " << y;
      }
    }
  });
}

TEST(GaussianBlurTest, GoesOnBeyondTheEdgesWithWhatIsThere) {
  for (const int width : {1, 3, 40}) {
    FloatImage image;
    image.Resize(width, 5);
    for (int y = 0; y < 5; ++y) std::fill_n(image.row(y), width, 3.0F);
    FloatImage blurred;
    blurred.Resize(width, 5);
    std::vector<float> row;
    GaussianBlur(3, 4).Rows(image, 0, 5, blurred, row);
    for (int y = 0; y < 5; ++y) {
      for (int x = 0; x < width; ++x) {
        ASSERT_NEAR(blurred.row(y)[x], 3, 1e-5);
      }
    }
  }
}

TEST(GaussianBlurTest, RowsDoNotDependOnOthers) {
  const FloatImage image = Slope(50, 30);
  const GaussianBlur blur(2, 3);
  FloatImage whole;
  whole.Resize(50, 30);
  FloatImage parts;
  parts.Resize(50, 30);
  std::vector<float> row;
  blur.Rows(image, 0, 30, whole, row);
  for (const int begin : {20, 0, 10}) {
    blur.Rows(image, begin, begin + 10, parts, row);
  }
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 50; ++x) {
      ASSERT_EQ(whole.row(y)[x], parts.row(y)[x]);
    }
  }
}

}  // namespace
}  // namespace treeline::features
