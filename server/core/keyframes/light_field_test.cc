#include "server/core/keyframes/light_field.h"

#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::keyframes {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

class LightFieldTest : public ::testing::Test {
 protected:
  LightFieldTest() {
    base::Random random(1, 0);
    seen_.resize(kPoints);
    for (size_t i = 0; i < kPoints; ++i) {
      seen_.u[i] = static_cast<float>(random.NextUniform(0, kWidth));
      seen_.v[i] = static_cast<float>(random.NextUniform(0, kHeight));
      seen_.gradient_x[i] = 3;
      seen_.gradient_y[i] = -2;
      seen_.seen[i] = i % 10 == 0 ? 0.0F : 1.0F;
      reference_.push_back(static_cast<float>(random.NextUniform(20, 120)));
    }
  }

  // Of a lamp on the right whose light falls off towards the left.
  static float Lamp(float u, float v) {
    const float x = 2 * u / kWidth - 1;
    const float y = 2 * v / kHeight - 1;
    return std::exp(0.5F * x - 0.2F * y + 0.1F * x * x - 0.2F);
  }
  void Shine() {
    for (size_t i = 0; i < kPoints; ++i) {
      seen_.brightness[i] = reference_[i] * Lamp(seen_.u[i], seen_.v[i]);
    }
  }

  static constexpr size_t kPoints = 1200;
  VisiblePoints seen_;
  std::vector<float> reference_;
};

TEST_F(LightFieldTest, MakesALampsLightEven) {
  Shine();
  const auto field =
      LightField::Fit(reference_, seen_, kPoints, kWidth, kHeight);
  ASSERT_TRUE(field.has_value());
  const VisiblePoints lit = seen_;
  EXPECT_EQ(field->Even(kPoints, seen_), 1080);
  for (size_t i = 0; i < kPoints; ++i) {
    if (seen_.seen[i] == 0) continue;
    // Ratios are drawn to 1 a little, where parts leave a choice.
    EXPECT_NEAR(seen_.brightness[i] / reference_[i], 1, 0.05);
    // A pixel to the right, where the picture is brighter by its gradient.
    const float next =
        (lit.brightness[i] + 3) / field->At(seen_.u[i] + 1, seen_.v[i]);
    EXPECT_NEAR(seen_.gradient_x[i], next - seen_.brightness[i], 0.05);
    const float below =
        (lit.brightness[i] - 2) / field->At(seen_.u[i], seen_.v[i] + 1);
    EXPECT_NEAR(seen_.gradient_y[i], below - seen_.brightness[i], 0.05);
  }
}

TEST_F(LightFieldTest, WhatCoversAThirdOfThePictureDoesNotCount) {
  Shine();
  base::Random random(2, 0);
  for (size_t i = 0; i < kPoints; ++i) {
    if (seen_.u[i] < kWidth / 3.0) {
      seen_.brightness[i] = static_cast<float>(random.NextUniform(90, 110));
    }
  }
  const auto field =
      LightField::Fit(reference_, seen_, kPoints, kWidth, kHeight);
  ASSERT_TRUE(field.has_value());
  EXPECT_NEAR(field->At(600, 240) / Lamp(600, 240), 1, 0.05);
  EXPECT_NEAR(field->At(300, 100) / Lamp(300, 100), 1, 0.05);
}

TEST_F(LightFieldTest, WhatIsWhiteTellsNothing) {
  Shine();
  for (size_t i = 0; i < kPoints; i += 2) seen_.brightness[i] = 255;
  const auto field =
      LightField::Fit(reference_, seen_, kPoints, kWidth, kHeight);
  ASSERT_TRUE(field.has_value());
  EXPECT_NEAR(field->At(320, 240) / Lamp(320, 240), 1, 0.05);
  // The others, less those that were not seen: all of every tenth are white.
  EXPECT_EQ(field->Even(kPoints, seen_), 600);
  EXPECT_EQ(seen_.seen[2], 0);
  EXPECT_EQ(seen_.brightness[2], 0);
}

TEST_F(LightFieldTest, AnotherPlaceHasNone) {
  base::Random random(3, 0);
  for (size_t i = 0; i < kPoints; ++i) {
    seen_.brightness[i] = static_cast<float>(random.NextUniform(20, 120));
  }
  EXPECT_FALSE(LightField::Fit(reference_, seen_, kPoints, kWidth, kHeight));
}

}  // namespace
}  // namespace treeline::keyframes
