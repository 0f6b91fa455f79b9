#include "evaluation/accuracy/perturbation_effects.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::accuracy {
namespace {

using ::testing::Each;

// Colour and depth camera apart and different, so that each must follow its
// own picture.
camera::RgbdCalibration Apart() {
  camera::RgbdCalibration calibration = training::BoxRoomCalibration();
  calibration.depth =
      camera::Camera::Parse("PINHOLE,120,118,81,58", 160, 120).value();
  calibration.color_from_depth = {
      geometry::Rotation3::FromAxisAngle({0.02, -0.03, 0.05}),
      {0.05, 0.01, -0.02}};
  return calibration;
}

class PerturbationEffects : public ::testing::Test {
 protected:
  PerturbedFrame View() const {
    PerturbedFrame view{training::RenderBoxRoom(calibration_, pose_), {}};
    view.frame.calibration = calibration_;
    return view;
  }

  base::Random random() const { return {7, 11}; }

  camera::RgbdCalibration calibration_ = Apart();
  geometry::Rigid3 pose_ = training::BoxRoomPoses(9)[2];
};

// Differences of what was measured in both; `outside` counts the rest.
struct Differences {
  std::vector<int> values;
  int outside = 0;

  // The one that a share `p` of them is below.
  int Quantile(double p) {
    std::ranges::sort(values);
    return values[static_cast<size_t>(p *
                                      static_cast<double>(values.size() - 1))];
  }
};

Differences OfColor(const image::ColorImage& a, const image::ColorImage& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  Differences differences;
  for (size_t i = 0; i < a.rgb.size(); i += 3) {
    if (a.rgb[i] == 0 && a.rgb[i + 1] == 0 && a.rgb[i + 2] == 0) {
      ++differences.outside;
      continue;
    }
    for (size_t c = 0; c < 3; ++c) {
      differences.values.push_back(std::abs(a.rgb[i + c] - b.rgb[i + c]));
    }
  }
  return differences;
}

Differences OfDepth(const image::DepthImage& a, const image::DepthImage& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  Differences differences;
  for (size_t i = 0; i < a.values.size(); ++i) {
    if (!image::IsMeasured(a.values[i])) {
      ++differences.outside;
    } else {
      differences.values.push_back(std::abs(a.values[i] - b.values[i]));
    }
  }
  return differences;
}

// What the calibration and the pose of a changed frame say that it shows is
// what it shows. Nearest depth may be half a pixel off: a few centimetres on
// the walls that are seen at a slant.
void ExpectConsistent(const PerturbedFrame& view,
                      const geometry::Rigid3& world_from_sensor,
                      double max_outside = 0) {
  const geometry::Rigid3 world_from_turned =
      world_from_sensor * view.turned_from_sensor.Inverse();
  const image::Frame rendered =
      training::RenderBoxRoom(*view.frame.calibration, world_from_turned);
  Differences color = OfColor(view.frame.color, rendered.color);
  EXPECT_LE(color.Quantile(0.5), 2);
  EXPECT_LE(color.Quantile(0.99), 12);
  EXPECT_LE(color.outside,
            max_outside * rendered.color.width * rendered.color.height);
  Differences depth = OfDepth(*view.frame.depth, *rendered.depth);
  EXPECT_LE(depth.Quantile(0.5), 12);
  EXPECT_LE(depth.Quantile(0.99), 60);
  EXPECT_LE(depth.outside,
            max_outside * rendered.depth->width * rendered.depth->height);
}

TEST_F(PerturbationEffects, ThatMovePixelsMoveCamerasAndPoseWithThem) {
  struct Case {
    const char* name;
    absl::Status (*effect)(double, base::Random&, PerturbedFrame&);
    double strength;
    double max_outside;
  };
  for (const Case& c : {Case{"rotate", Rotate, 90, 0},
                        {"", Rotate, 180, 0},
                        {"", Rotate, 270, 0},
                        {"", Rotate, -90, 0},
                        {"roll", Roll, 90, 0.3},
                        {"", Roll, 25, 0.3},
                        {"crop", Crop, 0.6, 0},
                        {"scale", Scale, 0.5, 0},
                        {"", Scale, 2, 0},
                        {"", Scale, 0.7, 0},
                        {"distort", Distort, -0.15, 0.01}}) {
    SCOPED_TRACE(testing::Message() << c.name << " " << c.strength);
    PerturbedFrame view = View();
    base::Random draws = random();
    ASSERT_TRUE(c.effect(c.strength, draws, view).ok());
    ExpectConsistent(view, pose_, c.max_outside);
    EXPECT_NE(*view.frame.calibration, calibration_);
  }
}

TEST_F(PerturbationEffects, CanFollowEachOther) {
  PerturbedFrame view = View();
  base::Random draws = random();
  ASSERT_TRUE(Rotate(90, draws, view).ok());
  ASSERT_TRUE(Crop(0.8, draws, view).ok());
  ASSERT_TRUE(Scale(1.5, draws, view).ok());
  ASSERT_TRUE(Roll(20, draws, view).ok());
  ExpectConsistent(view, pose_, 0.3);
}

TEST_F(PerturbationEffects, KeepRegisteredDepthRegistered) {
  calibration_ = training::BoxRoomCalibration();
  for (const auto effect : {Rotate, Crop, Scale, WrongFocalLength}) {
    PerturbedFrame view = View();
    base::Random draws = random();
    ASSERT_TRUE(effect(effect == Rotate ? 90 : 0.5, draws, view).ok());
    EXPECT_EQ(view.frame.calibration->depth, view.frame.calibration->color);
    EXPECT_EQ(view.frame.calibration->color_from_depth, geometry::Rigid3{});
  }
}

TEST_F(PerturbationEffects, RotateTurnsThePictureClockwise) {
  PerturbedFrame view = View();
  const image::ColorImage before = view.frame.color;
  base::Random draws = random();
  ASSERT_TRUE(Rotate(90, draws, view).ok());
  // The top left corner is now at the top right.
  EXPECT_EQ(view.frame.color.rgb[3 * 149u], before.rgb[0]);
  EXPECT_EQ(view.frame.color.width, 150);
}

// In the mirror: with the scene's x axis turned round, depth and colour are
// again where the calibration says.
TEST_F(PerturbationEffects, MirrorShowsWhatNoCameraSees) {
  PerturbedFrame view = View();
  const PerturbedFrame before = view;
  base::Random draws = random();
  ASSERT_TRUE(Mirror(0, draws, view).ok());
  EXPECT_EQ(view.frame.color.rgb[0], before.frame.color.rgb[3 * 199u]);
  EXPECT_EQ(view.frame.depth->values[0], before.frame.depth->values[159]);
  const geometry::Vec3 in_depth{0.3, 0.2, 1.5};
  const geometry::Vec3 in_color = calibration_.color_from_depth * in_depth;
  const geometry::Vec3 mirrored =
      view.frame.calibration->color_from_depth * geometry::Vec3{-0.3, 0.2, 1.5};
  EXPECT_NEAR(mirrored.x, -in_color.x, 1e-12);
  EXPECT_NEAR(mirrored.y, in_color.y, 1e-12);
  EXPECT_NEAR(mirrored.z, in_color.z, 1e-12);
}

TEST_F(PerturbationEffects, OfLightChangeValuesAsTheyShould) {
  PerturbedFrame view;
  view.frame.color = {2, 1, {100, 60, 20, 255, 0, 200}};
  base::Random draws = random();
  const auto after = [&](auto effect, double strength) {
    PerturbedFrame changed = view;
    EXPECT_TRUE(effect(strength, draws, changed).ok());
    return changed.frame.color.rgb;
  };
  // 0.299 * 100 + 0.587 * 60 + 0.114 * 20 = 67.4
  EXPECT_EQ(after(Grey, 1)[0], 67);
  EXPECT_EQ(after(Grey, 1)[2], 67);
  EXPECT_EQ(after(Grey, 0.5)[0], 84);
  EXPECT_EQ(after(WhiteBalance, 0.25),
            (std::vector<uint8_t>{125, 60, 15, 255, 0, 150}));
  EXPECT_EQ(after(Exposure, 0.35),
            (std::vector<uint8_t>{35, 21, 7, 89, 0, 70}));
  EXPECT_EQ(after(Exposure, 2),
            (std::vector<uint8_t>{200, 120, 40, 255, 0, 255}));
  // 255 * (100 / 255)^2 = 39.2
  EXPECT_EQ(after(Gamma, 2)[0], 39);
  EXPECT_EQ(after(Gamma, 0.5)[3], 255);
}

TEST_F(PerturbationEffects, LightIsWarmAndBrightOnOneSideAlone) {
  PerturbedFrame view;
  view.frame.color = {101, 101, std::vector<uint8_t>(3 * 101 * 101, 50)};
  base::Random draws = random();
  ASSERT_TRUE(Light(1, draws, view).ok());
  const std::vector<uint8_t>& rgb = view.frame.color.rgb;
  const size_t middle = 3 * (50 * 101 + 50);
  EXPECT_EQ(rgb[middle], 50);
  EXPECT_EQ(rgb[middle + 2], 50);
  // 50 * 2^1.15 = 111 and 50 * 2^-1.15 = 22.5 at opposite corners.
  EXPECT_NEAR(*std::ranges::max_element(rgb), 111, 2);
  EXPECT_NEAR(*std::ranges::min_element(rgb), 23, 2);
  const size_t brightest =
      static_cast<size_t>(std::ranges::max_element(rgb) - rgb.begin());
  EXPECT_EQ(brightest % 3, 0u) << "red is the brightest where it is bright";
}

// A point becomes a line of as many pixels, wherever it points.
TEST_F(PerturbationEffects, MotionBlurSpreadsAPointOverItsLength) {
  PerturbedFrame view;
  view.frame.color = {41, 41, std::vector<uint8_t>(3 * 41 * 41, 0)};
  for (size_t c = 0; c < 3; ++c) {
    view.frame.color.rgb[3 * (20 * 41 + 20) + c] = 255;
  }
  base::Random draws = random();
  ASSERT_TRUE(MotionBlur(9, draws, view).ok());
  double sum = 0;
  double moment = 0;
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) {
      const double value =
          view.frame.color.rgb[static_cast<size_t>(3 * (y * 41 + x))];
      sum += value;
      moment += value * ((x - 20) * (x - 20) + (y - 20) * (y - 20));
    }
  }
  EXPECT_NEAR(sum, 255, 20);
  // A line of length l has variance l^2 / 12, and interpolation adds about 1/3.
  EXPECT_NEAR(moment / sum, 81.0 / 12 + 1.0 / 3, 0.8);
}

TEST_F(PerturbationEffects, DefocusNoiseAndJpegHaveTheirStrength) {
  PerturbedFrame grey;
  grey.frame.color = {120, 120, std::vector<uint8_t>(3 * 120 * 120, 128)};
  base::Random draws = random();
  PerturbedFrame noisy = grey;
  ASSERT_TRUE(Noise(12, draws, noisy).ok());
  double square = 0;
  for (const uint8_t value : noisy.frame.color.rgb) {
    square += (value - 128.0) * (value - 128.0);
  }
  // 43,200 draws: the deviation is within 1 % of 12 almost surely, rounding
  // adds 0.3 %.
  EXPECT_NEAR(std::sqrt(square / (3 * 120 * 120)), 12, 0.2);
  PerturbedFrame soft = noisy;
  ASSERT_TRUE(Defocus(1.5, draws, soft).ok());
  double soft_square = 0;
  for (const uint8_t value : soft.frame.color.rgb) {
    soft_square += (value - 128.0) * (value - 128.0);
  }
  // White noise keeps 1 / (4 pi sigma^2) of its variance.
  EXPECT_NEAR(soft_square / square, 1 / (4 * 3.1416 * 2.25), 0.01);
  PerturbedFrame compressed = noisy;
  ASSERT_TRUE(Jpeg(10, draws, compressed).ok());
  EXPECT_NE(compressed.frame.color.rgb, noisy.frame.color.rgb);
  EXPECT_EQ(compressed.frame.color.rgb.size(), noisy.frame.color.rgb.size());
}

TEST_F(PerturbationEffects, CoverHidesItsShareOfColourAndDepth) {
  int unmeasured = 0;
  for (uint64_t stream = 0; stream < 20; ++stream) {
    PerturbedFrame view = View();
    const PerturbedFrame before = view;
    base::Random draws(1, stream);
    ASSERT_TRUE(Cover(0.4, draws, view).ok());
    int hidden = 0;
    for (size_t i = 0; i < view.frame.color.rgb.size(); i += 3) {
      hidden += view.frame.color.rgb[i] != before.frame.color.rgb[i] ||
                view.frame.color.rgb[i + 1] != before.frame.color.rgb[i + 1];
    }
    EXPECT_NEAR(hidden, 0.4 * 200 * 150, 0.02 * 200 * 150);
    int changed = 0;
    int near = 0;
    for (size_t i = 0; i < view.frame.depth->values.size(); ++i) {
      const uint16_t value = view.frame.depth->values[i];
      changed += value != before.frame.depth->values[i];
      near += value >= 500 && value <= 1000;
    }
    EXPECT_NEAR(changed, 0.4 * 160 * 120, 0.02 * 160 * 120);
    unmeasured += near < changed / 2;
  }
  EXPECT_GT(unmeasured, 3);
  EXPECT_LT(unmeasured, 17);
}

TEST_F(PerturbationEffects, OfDepthLeaveColourAndWhatWasNotMeasured) {
  PerturbedFrame view = View();
  view.frame.depth->values[0] = 0;
  view.frame.depth->values[1] = 65535;
  const PerturbedFrame before = view;
  base::Random draws = random();
  for (const auto effect : {DepthHoles, DepthNoise, DepthScaled, DepthOffset}) {
    PerturbedFrame changed = before;
    ASSERT_TRUE(effect(0.5, draws, changed).ok());
    EXPECT_EQ(changed.frame.color.rgb, before.frame.color.rgb);
    EXPECT_EQ(changed.frame.calibration, before.frame.calibration);
    EXPECT_NE(changed.frame.depth->values, before.frame.depth->values);
    EXPECT_FALSE(image::IsMeasured(changed.frame.depth->values[0]));
    EXPECT_FALSE(image::IsMeasured(changed.frame.depth->values[1]));
  }
}

TEST_F(PerturbationEffects, OfDepthHaveTheirStrength) {
  const auto flat = [] {
    PerturbedFrame view;
    view.frame.depth = image::DepthImage{
        480, 480, std::vector<uint16_t>(480 * 480, 2000), 0.001};
    return view;
  };
  base::Random draws = random();
  PerturbedFrame holes = flat();
  ASSERT_TRUE(DepthHoles(0.3, draws, holes).ok());
  const auto missing = std::ranges::count(holes.frame.depth->values, 0);
  // 400 cells, of each the deviation is 0.46: 3 sigma are 0.07.
  EXPECT_NEAR(static_cast<double>(missing) / (480 * 480), 0.3, 0.07);
  PerturbedFrame noisy = flat();
  ASSERT_TRUE(DepthNoise(0.01, draws, noisy).ok());
  double square = 0;
  for (const uint16_t value : noisy.frame.depth->values) {
    square += (value - 2000.0) * (value - 2000.0);
  }
  // 0.01 / m * (2 m)^2 = 40 mm.
  EXPECT_NEAR(std::sqrt(square / (480 * 480)), 40, 0.5);
  PerturbedFrame scaled = flat();
  ASSERT_TRUE(DepthScaled(1.02, draws, scaled).ok());
  EXPECT_THAT(scaled.frame.depth->values, Each(2040));
  PerturbedFrame further = flat();
  ASSERT_TRUE(DepthOffset(0.03, draws, further).ok());
  EXPECT_THAT(further.frame.depth->values, Each(2030));
}

TEST_F(PerturbationEffects, OfDepthDoNothingWithoutIt) {
  for (const auto effect : {DepthHoles, DepthNoise, DepthScaled, DepthOffset,
                            NoDepth, Cover, Mirror}) {
    PerturbedFrame view = View();
    view.frame.depth.reset();
    base::Random draws = random();
    EXPECT_TRUE(effect(0.5, draws, view).ok());
    EXPECT_FALSE(view.frame.depth.has_value());
  }
  PerturbedFrame view = View();
  base::Random draws = random();
  EXPECT_TRUE(NoDepth(0, draws, view).ok());
  EXPECT_FALSE(view.frame.depth.has_value());
}

TEST_F(PerturbationEffects, WrongFocalLengthChangesTheStatementAlone) {
  PerturbedFrame view = View();
  const PerturbedFrame before = view;
  base::Random draws = random();
  ASSERT_TRUE(WrongFocalLength(1.1, draws, view).ok());
  EXPECT_EQ(view.frame.color.rgb, before.frame.color.rgb);
  EXPECT_DOUBLE_EQ(view.frame.calibration->color.fx(), 145 * 1.1);
  EXPECT_DOUBLE_EQ(view.frame.calibration->color.fy(), 145 * 1.1);
  EXPECT_EQ(view.frame.calibration->color.cx(), 100);
  EXPECT_EQ(view.frame.calibration->depth, before.frame.calibration->depth);
}

TEST_F(PerturbationEffects, DistortRefusesToFoldThePicture) {
  PerturbedFrame view = View();
  base::Random draws = random();
  EXPECT_EQ(Distort(-0.9, draws, view).code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::accuracy
