#include "server/core/features/walsh_hadamard.h"

#include <bit>
#include <cmath>
#include <set>
#include <utility>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::features {
namespace {

image::ColorImage RandomImage(int width, int height, uint64_t seed) {
  image::ColorImage image{width, height, {}};
  base::Random random(seed, 0);
  image.rgb.resize(static_cast<size_t>(3 * width * height));
  for (uint8_t& value : image.rgb) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  return image;
}

// Row `index` of the 64 x 64 Hadamard matrix in Sylvester's order.
int Hadamard(unsigned index, unsigned x) {
  return std::popcount(index & x) % 2 == 0 ? 1 : -1;
}

// The Walsh function on 64 points with the given number of sign changes,
// found by counting them.
int Walsh(int sign_changes, int x) {
  for (unsigned row = 0; row < 64; ++row) {
    int changes = 0;
    for (unsigned i = 1; i < 64; ++i) {
      changes += Hadamard(row, i) != Hadamard(row, i - 1);
    }
    if (changes == sign_changes) return Hadamard(row, static_cast<unsigned>(x));
  }
  ADD_FAILURE() << "no Walsh function with " << sign_changes << " changes";
  return 0;
}

// Straight from the definition in the header.
int Projection(const image::ColorImage& image, int px, int py, int channel,
               WhtKernel kernel) {
  int sum = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const size_t i =
          static_cast<size_t>((py - 32 + y) * image.width + (px - 32 + x));
      sum += Walsh(kernel.i, x) * Walsh(kernel.j, y) *
             image.rgb[3 * i + static_cast<size_t>(channel)];
    }
  }
  const int rounded = static_cast<int>(std::floor(sum / 4096.0 + 0.5));
  const bool mean = kernel.i == 0 && kernel.j == 0;
  return std::clamp(mean ? rounded - 128 : rounded, -127, 127);
}

TEST(WalshHadamardTest, EqualsItsDefinition) {
  // Random pixels, darker to the right and greener below, so that low
  // frequencies are large too.
  image::ColorImage image = RandomImage(97, 80, 1);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      uint8_t* pixel = &image.rgb[3 * static_cast<size_t>(y * image.width + x)];
      pixel[0] = static_cast<uint8_t>(pixel[0] * (image.width - x) / 97);
      pixel[1] = static_cast<uint8_t>(pixel[1] * y / 80);
    }
  }
  const std::vector<int32_t> x = {32, 65, 40};
  const std::vector<int32_t> y = {32, 48, 41};
  std::vector<WhtDescriptor> descriptors(x.size());
  base::WithEachVectorTarget([&] {
    ComputeWht(PlanarImage(image), x, y, descriptors);
    for (size_t s = 0; s < x.size(); ++s) {
      for (size_t c = 0; c < 3; ++c) {
        for (size_t k = 0; k < kWhtOrder.size(); ++k) {
          EXPECT_EQ(
              descriptors[s].values[c * 20 + k],
              Projection(image, x[s], y[s], static_cast<int>(c), kWhtOrder[k]))
              << "sample " << s << ", channel " << c << ", kernel " << k;
        }
      }
    }
  });
}

TEST(WalshHadamardTest, SaturatesInsteadOfWrapping) {
  // White above, black below: kernel (0, 1) is +127.5 times full contrast.
  image::ColorImage image{64, 64, std::vector<uint8_t>(3 * 64 * 64, 0)};
  std::fill_n(image.rgb.begin(), 3 * 64 * 32, uint8_t{255});
  const std::vector<int32_t> at = {32};
  std::vector<WhtDescriptor> descriptor(1);
  ComputeWht(PlanarImage(image), at, at, descriptor);
  EXPECT_EQ(descriptor[0].values[0], 0);    // mean 127.5, rounded up, less 128
  EXPECT_EQ(descriptor[0].values[2], 127);  // clamped from 128
  EXPECT_EQ(descriptor[0].values[1], 0);
}

TEST(WalshHadamardTest, KernelsAreDistinctAndOrderedBySignChanges) {
  std::set<std::pair<int, int>> seen;
  int last = 0;
  for (const WhtKernel& kernel : kWhtOrder) {
    EXPECT_TRUE(seen.emplace(kernel.i, kernel.j).second);
    EXPECT_GE(kernel.i + kernel.j, last);
    last = kernel.i + kernel.j;
  }
  EXPECT_EQ(last, 5);
}

TEST(WalshHadamardTest, SquaredDistanceIsExact) {
  base::Random random(3, 0);
  WhtDescriptor a;
  WhtDescriptor b;
  int expected = 0;
  for (size_t i = 0; i < 64; ++i) {
    a.values[i] =
        static_cast<int8_t>(static_cast<int>(random.NextBelow(255)) - 127);
    b.values[i] =
        static_cast<int8_t>(static_cast<int>(random.NextBelow(255)) - 127);
    expected += (a.values[i] - b.values[i]) * (a.values[i] - b.values[i]);
  }
  base::WithEachVectorTarget([&] {
    EXPECT_EQ(SquaredDistance(a, b), expected);
    EXPECT_EQ(SquaredDistance(a, a), 0);
  });
}

TEST(PatchInsideTest, TouchesEveryBorderExactly) {
  EXPECT_TRUE(PatchInside(32, 32, 640, 480));
  EXPECT_TRUE(PatchInside(608, 448, 640, 480));
  EXPECT_FALSE(PatchInside(31, 32, 640, 480));
  EXPECT_FALSE(PatchInside(32, 31, 640, 480));
  EXPECT_FALSE(PatchInside(609, 32, 640, 480));
  EXPECT_FALSE(PatchInside(32, 449, 640, 480));
}

TEST(PlanarImageTest, SeparatesChannels) {
  const image::ColorImage image =
      RandomImage(37, 5, 2);  // not a multiple of lanes
  const PlanarImage planar(image);
  for (int i = 0; i < 37 * 5; ++i) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(planar.data()[c * planar.plane_bytes() + i],
                image.rgb[static_cast<size_t>(3 * i + c)]);
    }
  }
}

}  // namespace
}  // namespace treeline::features
