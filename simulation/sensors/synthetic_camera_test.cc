#include "simulation/sensors/synthetic_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "common/image/rolling_shutter.h"
#include "gtest/gtest.h"
#include "simulation/sensors/picture.h"
#include "simulation/worlds/testing_world.h"

namespace treeline::sensors {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr size_t kPixels = size_t{kWidth} * kHeight;

renderer::PixelRays DepthRays() {
  return renderer::PixelRays(SyntheticCamera::DefaultCalibration().depth);
}

// A wall that faces the camera.
std::vector<renderer::DepthSample> Wall(float depth_m, float incidence = 1) {
  return std::vector<renderer::DepthSample>(kPixels, {depth_m, incidence});
}

double LostShare(const image::DepthImage& image) {
  return static_cast<double>(
             std::count(image.values.begin(), image.values.end(), 0)) /
         static_cast<double>(image.values.size());
}

TEST(DepthSensorTest, NoiseGrowsAsTheModelSays) {
  for (const double z_m : {0.8, 1.5, 2.5, 4.0}) {
    const double sigma_m = 0.0012 + 0.0019 * (z_m - 0.4) * (z_m - 0.4);
    const double step_m = z_m * z_m / (585 * 0.075 * 8);
    // A wall that recedes by five steps of disparity from left to right, so
    // that rounding errs evenly.
    std::vector<renderer::DepthSample> samples = Wall(0);
    for (size_t i = 0; i < kPixels; ++i) {
      samples[i].depth_m = static_cast<float>(
          z_m + step_m * 5 * (static_cast<double>(i % kWidth) / kWidth - 0.5));
    }
    const image::DepthImage image =
        MeasureDepth(DepthRays(), samples, {}, 1, 0, 1);
    double sum = 0;
    double squares = 0;
    double count = 0;
    for (size_t i = 0; i < kPixels; ++i) {
      if (image.values[i] == 0) continue;
      const double error_m =
          0.001 * image.values[i] - static_cast<double>(samples[i].depth_m);
      sum += error_m;
      squares += error_m * error_m;
      ++count;
    }
    // Rounding to steps and to millimetres adds the variance of even errors.
    // 300,000 samples give the deviation to 0.2 %; sigma and step themselves
    // vary by 3 % over the wall.
    const double expected_m =
        std::sqrt(sigma_m * sigma_m + (step_m * step_m + 1e-6) / 12);
    EXPECT_NEAR(std::sqrt(squares / count), expected_m, 0.03 * expected_m)
        << z_m;
    // No bias to speak of, though five depths do not round evenly to mm.
    EXPECT_NEAR(sum / count, 0, 0.05 * expected_m) << z_m;
  }
}

TEST(DepthSensorTest, DepthComesInStepsOfDisparity) {
  const image::DepthImage image =
      MeasureDepth(DepthRays(), Wall(3), {}, 1, 0, 1);
  for (const uint16_t value : image.values) {
    if (value == 0) continue;
    const double steps = 585 * 0.075 * 8 / (0.001 * value);
    // Half a millimetre of rounding is 0.02 steps at 3 m.
    ASSERT_NEAR(steps, std::round(steps), 0.03);
  }
}

TEST(DepthSensorTest, NothingIsMeasuredOutOfRange) {
  EXPECT_EQ(LostShare(MeasureDepth(DepthRays(), Wall(0.39f), {}, 1, 0, 1)), 1);
  EXPECT_EQ(LostShare(MeasureDepth(DepthRays(), Wall(4.51f), {}, 1, 0, 1)), 1);
  EXPECT_EQ(LostShare(MeasureDepth(DepthRays(), Wall(0), {}, 1, 0, 1)), 1);
}

TEST(DepthSensorTest, PixelsAreLostByChanceAndAtGrazingAngles) {
  const auto lost_at_angle_deg = [](double angle_deg) {
    const float incidence =
        static_cast<float>(std::sin(angle_deg * 3.14159265 / 180));
    return LostShare(
        MeasureDepth(DepthRays(), Wall(2, incidence), {}, 1, 0, 1));
  };
  // The share of 300,000 has a sigma of 0.0001 at 0.003.
  EXPECT_NEAR(lost_at_angle_deg(90), 0.003, 0.0005);
  EXPECT_NEAR(lost_at_angle_deg(21), 0.003, 0.0005);
  EXPECT_NEAR(lost_at_angle_deg(15), 0.494, 0.01);  // half way, in the sine
  EXPECT_EQ(lost_at_angle_deg(9), 1);
}

TEST(DepthSensorTest, NearThingsThrowAShadowToTheirLeft) {
  // A board at 1 m over columns 300 to 399, a wall at 2 m behind it.
  std::vector<renderer::DepthSample> samples = Wall(2);
  for (size_t y = 0; y < kHeight; ++y) {
    for (size_t x = 300; x < 400; ++x) samples[y * kWidth + x].depth_m = 1;
  }
  DepthSensorOptions options;
  options.edge_loss = 0;
  options.random_loss = 0;
  const image::DepthImage image =
      MeasureDepth(DepthRays(), samples, options, 1, 0, 1);
  // Disparities are 43.9 and 21.9 px: the shadow is 22 columns wide.
  for (size_t y = 0; y < kHeight; y += 37) {
    int lost = 0;
    for (size_t x = 0; x < kWidth; ++x) {
      if (image.values[y * kWidth + x] != 0) continue;
      ++lost;
      EXPECT_GE(x, 278u);
      EXPECT_LT(x, 300u);
    }
    EXPECT_NEAR(lost, 22, 1);
  }
}

TEST(DepthSensorTest, EdgesLosePixelsOnBothSides) {
  std::vector<renderer::DepthSample> samples = Wall(2);
  for (size_t y = 0; y < kHeight; ++y) {
    // To the right and farther away: in nobody's shadow.
    for (size_t x = 400; x < kWidth; ++x) samples[y * kWidth + x].depth_m = 3;
  }
  const image::DepthImage image =
      MeasureDepth(DepthRays(), samples, {}, 1, 0, 1);
  const auto lost_in_column = [&](size_t x) {
    int lost = 0;
    for (size_t y = 0; y < kHeight; ++y) {
      lost += image.values[y * kWidth + x] == 0 ? 1 : 0;
    }
    return lost / static_cast<double>(kHeight);
  };
  // 480 draws at 0.6: sigma 0.022.
  EXPECT_NEAR(lost_in_column(399), 0.6, 0.1);
  EXPECT_NEAR(lost_in_column(400), 0.6, 0.1);
  EXPECT_LT(lost_in_column(398), 0.02);
  EXPECT_LT(lost_in_column(401), 0.02);
}

TEST(DepthSensorTest, NoiseIsNewInEveryFrameAndTheSameForASeed) {
  const auto measure = [](uint64_t seed, uint64_t frame, int threads) {
    return MeasureDepth(DepthRays(), Wall(2), {}, seed, frame, threads).values;
  };
  EXPECT_EQ(measure(1, 0, 1), measure(1, 0, 2));
  EXPECT_NE(measure(1, 0, 1), measure(1, 1, 1));
  EXPECT_NE(measure(1, 0, 1), measure(2, 0, 1));
}

TEST(ColorSensorTest, NoiseHasItsDeviationAndNoBias) {
  const renderer::PixelRays rays(SyntheticCamera::DefaultCalibration().color);
  const std::vector<worlds::Float3> radiance(kPixels, {0.1f, 0.2f, 0.3f});
  const ColorSensorOptions quiet = {.exposure = 2, .noise_levels = 0};
  const ColorSensorOptions noisy = {.exposure = 2, .noise_levels = 3};
  const image::ColorImage clean = ExposeColor(rays, radiance, quiet, 1, 0, 1);
  const image::ColorImage image = ExposeColor(rays, radiance, noisy, 1, 0, 1);
  EXPECT_LT(clean.rgb[0], clean.rgb[1]);
  EXPECT_LT(clean.rgb[1], clean.rgb[2]);
  double sum = 0;
  double squares = 0;
  for (size_t i = 0; i < image.rgb.size(); ++i) {
    const double difference = image.rgb[i] - clean.rgb[i];
    sum += difference;
    squares += difference * difference;
  }
  const double count = static_cast<double>(image.rgb.size());
  // Rounding adds 1/12 twice; the clean picture's rounding is a bias of up to
  // half a level.
  EXPECT_NEAR(sum / count, 0, 0.5);
  EXPECT_NEAR(squares / count, 9 + 1.0 / 6, 0.6);
}

TEST(SyntheticCameraTest, OptionsAreChecked) {
  EXPECT_FALSE((ColorSensorOptions{.exposure = 0}).Validate().ok());
  EXPECT_FALSE((ColorSensorOptions{.noise_levels = -1}).Validate().ok());
  EXPECT_FALSE((ColorSensorOptions{.min_exposure = 3, .max_exposure = 2})
                   .Validate()
                   .ok());
  EXPECT_FALSE((ColorSensorOptions{.white_balance = 2}).Validate().ok());
  EXPECT_FALSE((DepthSensorOptions{.max_range_m = 0.1}).Validate().ok());
  EXPECT_FALSE((DepthSensorOptions{.edge_loss = 1.5}).Validate().ok());
  EXPECT_FALSE(
      (DepthSensorOptions{.axial_base_m = std::nan("")}).Validate().ok());
  EXPECT_TRUE(DepthSensorOptions{}.Validate().ok());
}

TEST(SyntheticCameraTest, TheColourCameraIsBesideTheDepthCamera) {
  const std::shared_ptr<const renderer::Renderer> renderer =
      *renderer::Renderer::Create(worlds::TestingWorld(), 1);
  SyntheticCamera::Options options;
  options.color.noise_levels = 0;
  options.depth = {.axial_base_m = 0,
                   .axial_square_per_m = 0,
                   .edge_loss = 0,
                   .random_loss = 0};
  const auto camera = SyntheticCamera::Create(renderer, options);
  ASSERT_TRUE(camera.ok()) << camera.status();
  // Looking along -x at the box's face, with its edge at y = 1 in sight: the
  // camera's x axis is the world's y axis.
  const geometry::Rigid3 world_from_depth = {
      geometry::Rotation3::FromMatrix(
          geometry::Mat3{{0, 0, -1, 1, 0, 0, 0, -1, 0}}),
      {3, 0.8, 0.5}};
  const image::Frame frame = camera->Capture(world_from_depth, 0, 1);
  const size_t middle = size_t{240} * kWidth;
  // The edge is 2 m away and 0.2 m to the right of the depth camera, and
  // 0.175 m to the right of the colour camera.
  size_t depth_edge = 0;
  size_t color_edge = 0;
  for (size_t x = 1; x < kWidth; ++x) {
    const uint16_t left = frame.depth->values[middle + x - 1];
    const uint16_t right = frame.depth->values[middle + x];
    if (left != 0 && left < 2100 && right > 2900) depth_edge = x;
    if (frame.color.rgb[3 * (middle + x - 1)] >
        frame.color.rgb[3 * (middle + x)] + 20) {
      color_edge = x;
    }
  }
  EXPECT_NEAR(static_cast<double>(depth_edge), 320 + 585 * 0.1, 1.5);
  EXPECT_NEAR(static_cast<double>(color_edge), 320 + 525 * 0.0875, 2);

  // The same place told as the colour camera's pose.
  options.calibration.pose_sensor = camera::RgbdSensor::kColor;
  const auto by_color = SyntheticCamera::Create(renderer, options);
  const image::Frame same = by_color->Capture(
      world_from_depth * options.calibration.color_from_depth.Inverse(), 0, 2);
  size_t different = 0;
  for (size_t i = 0; i < kPixels; ++i) {
    different += frame.depth->values[i] != same.depth->values[i] ? 1 : 0;
  }
  EXPECT_LT(different, kPixels / 1000);  // rounding of the pose
}

TEST(GlassInDepth, IsMostlyLostAndNoisier) {
  const renderer::PixelRays rays(SyntheticCamera::DefaultCalibration().depth);
  const std::vector<renderer::DepthSample> samples(
      rays.rays().size(),
      {.depth_m = 2, .incidence = 1, .is_behind_glass = true});
  DepthSensorOptions options;
  options.random_loss = 0;
  options.disparity_steps_per_px = 1000;  // finer than the noise
  const image::DepthImage depth = MeasureDepth(rays, samples, options, 3, 1, 2);
  double squares = 0;
  double count = 0;
  for (const uint16_t value : depth.values) {
    if (!image::IsMeasured(value)) continue;
    squares += (value - 2000.0) * (value - 2000.0);
    count += 1;
  }
  // 4800 patches of 8 x 8 are lost or kept together: five standard errors.
  const double pixels = 640.0 * 480.0;
  EXPECT_NEAR(count / pixels, 0.3, 5 * std::sqrt(0.3 * 0.7 / 4800));
  const double sigma_mm = 2 * 1000 * (0.0012 + 0.0019 * (2 - 0.4) * (2 - 0.4));
  EXPECT_NEAR(std::sqrt(squares / count), sigma_mm,
              5 * sigma_mm / std::sqrt(2 * count));
}

TEST(RegisterDepth, MovesPixelsToWhereColourSeesThem) {
  const camera::RgbdCalibration calibration =
      SyntheticCamera::DefaultCalibration();
  image::DepthImage depth{.width = 640, .height = 480, .values = {}};
  depth.values.resize(640 * 480);
  // A point 1 m ahead, and one 2 m ahead that colour sees in the same place:
  // the depth camera sees them f b (1 / 1 - 1 / 2) = 7.3 px apart.
  depth.values[240 * 640 + 320] = 1000;
  depth.values[240 * 640 + 320 - 7] = 2000;
  const image::DepthImage registered = RegisterDepth(depth, calibration);
  const int moved = 320 - static_cast<int>(std::lround(525 * 0.025));
  EXPECT_EQ(registered.values[static_cast<size_t>(240 * 640 + moved)], 1000);
  EXPECT_EQ(std::count_if(registered.values.begin(), registered.values.end(),
                          image::IsMeasured),
            1);
}

TEST(AutomaticExposure, MakesBrightAndDarkPicturesAlike) {
  const renderer::PixelRays rays(SyntheticCamera::DefaultCalibration().color);
  const auto mean_level = [&](float light) {
    std::vector<worlds::Float3> radiance(rays.rays().size());
    for (size_t i = 0; i < radiance.size(); ++i) {
      const float value = light * (0.5f + static_cast<float>(i % 640) / 640);
      radiance[i] = {value, value, value};
    }
    const image::ColorImage image = ExposeColor(
        rays, radiance, {.is_automatic = true, .noise_levels = 0}, 0, 0, 1);
    double sum = 0;
    for (const uint8_t level : image.rgb) sum += level;
    return sum / static_cast<double>(image.rgb.size());
  };
  EXPECT_NEAR(mean_level(0.02f), mean_level(0.5f), 1);
  EXPECT_GT(mean_level(0.1f), 80);
  EXPECT_LT(mean_level(0.1f), 170);
}

// Mean levels of an evenly lit picture and the deviation of its green.
struct Levels {
  std::array<double, 3> means{};
  double deviation = 0;
};
Levels LevelsOf(worlds::Float3 light, const ColorSensorOptions& options,
                uint64_t seed = 1) {
  constexpr double kParameters[] = {80, 80, 47.5, 35.5};
  const renderer::PixelRays rays(*camera::Camera::Create(
      camera::CameraModel::kPinhole, 96, 72, kParameters, 4));
  const std::vector<worlds::Float3> radiance(rays.rays().size(), light);
  const image::ColorImage image =
      ExposeColor(rays, radiance, options, seed, 0, 1);
  Levels levels;
  const double count = static_cast<double>(radiance.size());
  for (size_t i = 0; i < image.rgb.size(); ++i) {
    levels.means[i % 3] += image.rgb[i] / count;
  }
  for (size_t i = 1; i < image.rgb.size(); i += 3) {
    const double away = image.rgb[i] - levels.means[1];
    levels.deviation += away * away / count;
  }
  levels.deviation = std::sqrt(levels.deviation);
  return levels;
}

TEST(AutomaticExposure, EndsWhereShutterAndGainDo) {
  const ColorSensorOptions options = {
      .is_automatic = true, .max_exposure = 30, .noise_levels = 0};
  // A middle grey of 0.35 needs 30 times 0.0117.
  const double grey = LevelsOf({0.1f, 0.1f, 0.1f}, options).means[1];
  EXPECT_NEAR(LevelsOf({0.012f, 0.012f, 0.012f}, options).means[1], grey, 1);
  EXPECT_LT(LevelsOf({0.003f, 0.003f, 0.003f}, options).means[1], 0.7 * grey);
}

TEST(WhiteBalance, TakesItsShareOutOfTheCast) {
  const worlds::Float3 warm = {0.15f, 0.10f, 0.05f};
  const auto cast_left = [&](double share) {
    const Levels levels = LevelsOf(
        warm,
        {.is_automatic = true, .white_balance = share, .noise_levels = 0});
    return levels.means[0] - levels.means[2];
  };
  EXPECT_GT(cast_left(0), 40);
  EXPECT_GT(cast_left(0.5), 0.3 * cast_left(0));
  EXPECT_LT(cast_left(0.5), 0.7 * cast_left(0));
  EXPECT_NEAR(cast_left(1), 0, 1);
}

TEST(WhiteBalance, HasAnErrorOfEachCamerasOwn) {
  const ColorSensorOptions options = {.white_balance_error = 0.1,
                                      .noise_levels = 0};
  double squares = 0;
  constexpr int kCameras = 40;
  const auto red_over_green = [&](uint64_t seed) {
    // Straight: far below where the tone curve bends, and its square root.
    const Levels levels = LevelsOf({0.01f, 0.01f, 0.01f}, options, seed);
    return 2 * std::log(levels.means[0] / levels.means[1]);
  };
  for (uint64_t seed = 0; seed < kCameras; ++seed) {
    squares += std::pow(red_over_green(seed), 2) / kCameras;
  }
  EXPECT_EQ(red_over_green(3), red_over_green(3));
  // The deviation of 40 draws is known to 11 %; three times that, and what
  // rounding to levels of about 40 adds.
  EXPECT_NEAR(std::sqrt(squares), 0.1, 0.04);
}

TEST(ColorSensorTest, NoiseGrowsWithTheExposureThatDarknessTakes) {
  ColorSensorOptions options = ColorSensorFor(building::Lighting::kEvening);
  options.white_balance_error = 0;
  const Levels bright = LevelsOf({0.1f, 0.1f, 0.1f}, options);
  const Levels dark = LevelsOf({0.012f, 0.012f, 0.012f}, options);
  EXPECT_NEAR(bright.means[1], dark.means[1], 2);
  EXPECT_LT(bright.deviation, 3);
  EXPECT_GT(dark.deviation, 2 * bright.deviation);
  EXPECT_TRUE(options.Validate().ok());
}

TEST(ColorSensorTest, IsByDayWhatItAlwaysWas) {
  const ColorSensorOptions day = ColorSensorFor(building::Lighting::kDay);
  EXPECT_FALSE(day.is_automatic);
  EXPECT_EQ(day.exposure, ColorSensorOptions().exposure);
  EXPECT_EQ(day.noise_levels, ColorSensorOptions().noise_levels);
  EXPECT_EQ(day.shot_noise + day.read_noise + day.white_balance +
                day.white_balance_error,
            0);
}

TEST(MotionBlur, IsTheMeanOfWhatIsSeenOnTheWay) {
  const std::shared_ptr<const renderer::Renderer> renderer =
      *renderer::Renderer::Create(worlds::TestingWorld(), 2);
  SyntheticCamera::Options options;
  options.color.noise_levels = 0;
  const SyntheticCamera camera = *SyntheticCamera::Create(renderer, options);
  const renderer::WorldSnapshot nobody = renderer->caster().At({});
  const geometry::Rigid3 still = LookingFrom({2.5, 2, 1.3}, -2.5, -0.4);
  const geometry::Rigid3 turned = LookingFrom({2.5, 2, 1.3}, -2.4, -0.4);
  const std::array<geometry::Rigid3, 3> same = {still, still, still};
  const image::Frame sharp = camera.Capture(still, 0, 2);
  const image::Frame three = camera.CaptureMoving(nobody, same, 0, 2);
  int most = 0;
  for (size_t i = 0; i < sharp.color.rgb.size(); ++i) {
    most = std::max(most, std::abs(sharp.color.rgb[i] - three.color.rgb[i]));
  }
  EXPECT_LE(most, 1);
  const std::array<geometry::Rigid3, 2> moving = {still, turned};
  const image::Frame blurred = camera.CaptureMoving(nobody, moving, 0, 2);
  const image::Frame after = camera.Capture(turned, 0, 2);
  // Between the two pictures, up to the tone curve's rounding.
  for (size_t i = 0; i < sharp.color.rgb.size(); ++i) {
    const auto [low, high] =
        std::minmax(sharp.color.rgb[i], after.color.rgb[i]);
    ASSERT_GE(blurred.color.rgb[i] + 1, low);
    ASSERT_LE(blurred.color.rgb[i], high + 1);
  }
  EXPECT_NE(blurred.color.rgb, sharp.color.rgb);
  EXPECT_EQ(blurred.depth->values, after.depth->values);
}

TEST(RollingShutter, RowsAreSeenFromWhereTheCameraIsThen) {
  const std::shared_ptr<const renderer::Renderer> renderer =
      *renderer::Renderer::Create(worlds::TestingWorld(), 2);
  SyntheticCamera::Options options;
  options.color.noise_levels = 0;
  const SyntheticCamera camera = *SyntheticCamera::Create(renderer, options);
  const auto pose_at = [](double row_share) {
    return LookingFrom({2.5, 2, 1.3}, -2.5 + 0.1 * row_share, -0.4);
  };
  const image::Frame rolling =
      camera.CaptureRolling(renderer->caster().At({}), pose_at, 0, 2);
  const image::Frame at_once = camera.Capture(pose_at(0), 0, 2);
  constexpr int kBand = SyntheticCamera::kRollingBand_px;
  constexpr int kColumns = 640;
  for (const int top : {0, 240, 472}) {
    const image::Frame then = camera.Capture(
        pose_at(image::RowShare(top + 0.5 * (kBand - 1), 480)), 0, 2);
    // Rows whose neighbours, which smooth edges, are of the same band.
    int same = 0;
    int as_at_once = 0;
    int same_depth = 0;
    for (int y = top + 1; y < top + kBand - 1; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        const size_t i = static_cast<size_t>(y * kColumns + x);
        same += std::abs(rolling.color.rgb[3 * i] - then.color.rgb[3 * i]) <= 1;
        as_at_once +=
            std::abs(rolling.color.rgb[3 * i] - at_once.color.rgb[3 * i]) <= 1;
        same_depth += rolling.depth->values[i] == then.depth->values[i];
      }
    }
    constexpr int kAll = (kBand - 2) * kColumns;
    // But for what float arithmetic decides on edges.
    EXPECT_GE(same, 0.99 * kAll) << top;
    EXPECT_GE(same_depth, 0.99 * kAll) << top;
    // The lowest rows see bare floor.
    if (top == 0) {
      EXPECT_LT(as_at_once, 0.9 * kAll) << top;
    }
  }
}

}  // namespace
}  // namespace treeline::sensors
