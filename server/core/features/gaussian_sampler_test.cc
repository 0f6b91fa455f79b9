#include "server/core/features/gaussian_sampler.h"

#include <algorithm>
#include <cmath>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"

namespace treeline::features {
namespace {

struct Picture {
  int width;
  int height;
  std::vector<uint8_t> gray;
};

Picture Noise(int width, int height) {
  base::Random random(3, 0);
  Picture picture{width, height, {}};
  for (int i = 0; i < width * height; ++i) {
    picture.gray.push_back(static_cast<uint8_t>(random.NextBelow(256)));
  }
  return picture;
}

// As it is defined.
double Expected(const Picture& picture, double scale, double sigma_px, int x,
                int y) {
  const double at_x = (x + 0.5) / scale - 0.5;
  const double at_y = (y + 0.5) / scale - 0.5;
  const int reach = static_cast<int>(std::ceil(6 * sigma_px / scale));
  const int middle_x = static_cast<int>(std::lround(at_x));
  const int middle_y = static_cast<int>(std::lround(at_y));
  double sum = 0;
  double weights = 0;
  for (int v = middle_y - reach; v <= middle_y + reach; ++v) {
    for (int u = middle_x - reach; u <= middle_x + reach; ++u) {
      const double off = std::hypot(u - at_x, v - at_y) * scale / sigma_px;
      const double weight = std::exp(-0.5 * off * off);
      const int row = std::clamp(v, 0, picture.height - 1);
      const int column = std::clamp(u, 0, picture.width - 1);
      sum += weight *
             picture.gray[static_cast<size_t>(row * picture.width + column)];
      weights += weight;
    }
  }
  return sum / weights;
}

TEST(GaussianSamplerTest, SamplesAreMeansAroundTheirPlaces) {
  struct Case {
    int width, height;
    double scale, sigma_px;
  };
  base::WithEachVectorTarget([] {
    for (const Case& c : {Case{40, 31, 0.8, 0.6},
                          {37, 9, 0.5, 0.6},
                          {5, 3, 0.8, 0.6},
                          {2, 2, 0.5, 1.0},
                          {33, 17, 1.0, 0.8},
                          {50, 20, 0.31, 0.4}}) {
      const Picture picture = Noise(c.width, c.height);
      GaussianSampler sampler(c.width, c.height, c.scale, c.sigma_px);
      ASSERT_EQ(sampler.width(), static_cast<int>(c.width * c.scale));
      ASSERT_EQ(sampler.height(), static_cast<int>(c.height * c.scale));
      std::vector<float> row(static_cast<size_t>(sampler.width()));
      for (int y = 0; y < sampler.height(); ++y) {
        sampler.Sample(picture.gray.data(), y, row);
        for (int x = 0; x < sampler.width(); ++x) {
          EXPECT_NEAR(static_cast<double>(row[static_cast<size_t>(x)]),
                      Expected(picture, c.scale, c.sigma_px, x, y), 0.3)
              << c.width << " x " << c.height << ", " << x << ", " << y;
        }
      }
    }
  });
}

TEST(GaussianSamplerTest, ASlopeStaysTheSlopeThatItWas) {
  Picture picture{64, 8, {}};
  for (int i = 0; i < 64 * 8; ++i) {
    picture.gray.push_back(static_cast<uint8_t>(3 * (i % 64)));
  }
  GaussianSampler sampler(64, 8, 0.8, 0.6);
  std::vector<float> row(static_cast<size_t>(sampler.width()));
  sampler.Sample(picture.gray.data(), 3, row);
  for (size_t x = 3; x + 3 < row.size(); ++x) {
    EXPECT_NEAR(static_cast<double>(row[x]),
                3 * ((static_cast<double>(x) + 0.5) / 0.8 - 0.5), 0.05);
  }
}

}  // namespace
}  // namespace treeline::features
