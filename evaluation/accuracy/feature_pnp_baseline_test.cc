#include "evaluation/accuracy/feature_pnp_baseline.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "common/base/random.h"
#include "common/image/decode.h"
#include "gtest/gtest.h"

namespace treeline::accuracy {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// Recordings of a wall z = 2 m covered with random blots, exact but for the
// rounding of pixels and depths.
class WallRecording {
 public:
  explicit WallRecording(
      const std::vector<geometry::Rigid3>& world_from_camera) {
    std::string name =
        (std::filesystem::temp_directory_path() / "wall_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    std::filesystem::create_directory(folder_ + "/seq-01");
    base::Random random(5, 0);
    for (int i = 0; i < 700; ++i) {
      blots_.push_back(
          {random.NextUniform(-2, 2), random.NextUniform(-1.5, 1.5),
           random.NextUniform(0.01, 0.06), random.NextUniform(-110, 110)});
    }
    for (size_t i = 0; i < world_from_camera.size(); ++i) {
      Record(static_cast<int>(i), world_from_camera[i]);
    }
  }
  ~WallRecording() { std::filesystem::remove_all(folder_); }
  WallRecording(const WallRecording&) = delete;
  WallRecording& operator=(const WallRecording&) = delete;

  dataset::Dataset Open() const {
    dataset::DatasetOptions options;
    options.uri = "7scenes:" + folder_;
    options.color_camera = options.depth_camera = kCamera;
    return dataset::Dataset::Open(options).value();
  }

  static constexpr const char* kCamera = "PINHOLE,280,280,160,120";

 private:
  struct Blot {
    double x, y, radius, brightness;
  };

  double Brightness(double x, double y) const {
    double sum = 128;
    for (const Blot& blot : blots_) {
      const double dx = (x - blot.x) / blot.radius;
      const double dy = (y - blot.y) / blot.radius;
      const double d = dx * dx + dy * dy;
      if (d < 9) sum += blot.brightness * std::exp(-d);
    }
    return std::clamp(sum, 0.0, 255.0);
  }

  void Record(int i, const geometry::Rigid3& world_from_camera) const {
    const camera::Camera camera =
        camera::Camera::Parse(kCamera, kWidth, kHeight).value();
    image::ColorImage color{kWidth, kHeight, {}};
    image::DepthImage depth{kWidth, kHeight, {}, 0.001};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const camera::Pixel ray = *camera.Unproject({double(x), double(y)});
        const geometry::Vec3 direction =
            world_from_camera.rotation * geometry::Vec3{ray.x, ray.y, 1};
        const double z = (2 - world_from_camera.translation.z) / direction.z;
        const geometry::Vec3 point =
            world_from_camera.translation + z * direction;
        const auto value =
            static_cast<uint8_t>(std::lround(Brightness(point.x, point.y)));
        color.rgb.insert(color.rgb.end(), {value, value, value});
        depth.values.push_back(static_cast<uint16_t>(std::lround(1000 * z)));
      }
    }
    const std::string base =
        absl::StrFormat("%s/seq-01/frame-%06d", folder_, i);
    std::ofstream(base + ".color.png", std::ios::binary)
        << image::EncodePng(color).value();
    std::ofstream(base + ".depth.png", std::ios::binary)
        << image::EncodeDepthPng(depth).value();
    const geometry::Mat3 r = world_from_camera.rotation.Matrix();
    std::ofstream pose(base + ".pose.txt");
    for (int row = 0; row < 3; ++row) {
      pose << r(row, 0) << ' ' << r(row, 1) << ' ' << r(row, 2) << ' '
           << world_from_camera.translation[row] << '\n';
    }
    pose << "0 0 0 1\n";
  }

  std::string folder_;
  std::vector<Blot> blots_;
};

FeaturePnpOptions Quiet() {
  FeaturePnpOptions options;
  options.quiet = true;
  return options;
}

TEST(FeaturePnpBaseline, FindsACameraBetweenItsKeyframes) {
  const geometry::Rigid3 query{
      geometry::Rotation3::FromAxisAngle({0.02, 0.05, 0.08}),
      {0.12, 0.05, 0.06}};
  const WallRecording recording({geometry::Rigid3{},
                                 geometry::Rigid3{{}, {0.3, 0, 0}},
                                 geometry::Rigid3{{}, {0, 0.2, 0.1}}, query});
  const dataset::Dataset dataset = recording.Open();
  FeaturePnpOptions options = Quiet();
  options.keyframes = 0;
  const auto baseline =
      BuildFeaturePnpBaseline(dataset, dataset.calibration(), options);
  ASSERT_TRUE(baseline.ok()) << baseline.status();
  EXPECT_EQ((*baseline)->info().training_frames, 4);
  localizer::LocalizeOptions ask;
  ask.keep_correspondences = true;
  const auto estimate = (*baseline)->Localize(*dataset.Load(3), ask);
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_EQ(estimate->outcome, localizer::Outcome::kLocalized);
  const geometry::PoseError error =
      geometry::ErrorBetween(estimate->world_from_camera, query);
  // Its own features are among the keyframes', so that what remains is the
  // depths' rounding to 1 mm.
  EXPECT_LT(error.translation_m, 0.001);
  EXPECT_LT(error.rotation_rad, 0.001);
  EXPECT_EQ(static_cast<int>(estimate->correspondences.size()),
            estimate->samples);
}

TEST(FeaturePnpBaseline, LocalizesAViewItHasNotSeen) {
  const geometry::Rigid3 query{
      geometry::Rotation3::FromAxisAngle({0.02, 0.05, 0.08}),
      {0.12, 0.05, 0.06}};
  const WallRecording training({geometry::Rigid3{},
                                geometry::Rigid3{{}, {0.3, 0, 0}},
                                geometry::Rigid3{{}, {0, 0.2, 0.1}}});
  const WallRecording test({query});
  const dataset::Dataset dataset = training.Open();
  const auto baseline =
      BuildFeaturePnpBaseline(dataset, dataset.calibration(), Quiet());
  ASSERT_TRUE(baseline.ok()) << baseline.status();
  const auto first = (*baseline)->Localize(*test.Open().Load(0), {});
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_EQ(first->outcome, localizer::Outcome::kLocalized);
  const geometry::PoseError error =
      geometry::ErrorBetween(first->world_from_camera, query);
  // Over a hundred features, each placed to some tenths of a pixel: 0.3 px at
  // f 280 and 2 m are 2 mm for one of them. Turning about a point of the wall
  // hardly moves its picture, so position is worse than that.
  EXPECT_LT(error.translation_m, 0.01);
  EXPECT_LT(error.rotation_rad, 0.005);
  const auto again = (*baseline)->Localize(*test.Open().Load(0), {});
  EXPECT_EQ(again->world_from_camera, first->world_from_camera);
}

TEST(FeaturePnpBaseline, DoesNotLocalizeABlankImage) {
  const WallRecording recording({geometry::Rigid3{}});
  const dataset::Dataset dataset = recording.Open();
  const auto baseline =
      BuildFeaturePnpBaseline(dataset, dataset.calibration(), Quiet());
  ASSERT_TRUE(baseline.ok()) << baseline.status();
  image::Frame blank;
  blank.color = {kWidth, kHeight,
                 std::vector<uint8_t>(3 * kWidth * kHeight, 90)};
  const auto estimate = (*baseline)->Localize(blank, {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  EXPECT_EQ(estimate->outcome, localizer::Outcome::kNotLocalized);
  EXPECT_EQ(estimate->reason, localizer::NotLocalizedReason::kTooFewSamples);
}

TEST(FeaturePnpBaseline, SpreadsItsKeyframesOverTheRecording) {
  const WallRecording recording(std::vector<geometry::Rigid3>(6));
  const dataset::Dataset dataset = recording.Open();
  FeaturePnpOptions options = Quiet();
  options.keyframes = 3;
  const auto baseline =
      BuildFeaturePnpBaseline(dataset, dataset.calibration(), options);
  ASSERT_TRUE(baseline.ok()) << baseline.status();
  EXPECT_EQ((*baseline)->info().training_frames, 3);
  EXPECT_EQ((*baseline)->info().method, "sift-pnp");
  EXPECT_GT((*baseline)->info().file_bytes, 0u);
}

TEST(FeaturePnpBaseline, StopsWhenInterrupted) {
  const WallRecording recording({geometry::Rigid3{}});
  std::stop_source source;
  source.request_stop();
  FeaturePnpOptions options = Quiet();
  options.stop = source.get_token();
  const dataset::Dataset dataset = recording.Open();
  EXPECT_EQ(BuildFeaturePnpBaseline(dataset, dataset.calibration(), options)
                .status()
                .code(),
            absl::StatusCode::kCancelled);
}

TEST(FeaturePnpBaseline, LocalizesAViewWithOrbToo) {
  const geometry::Rigid3 query{
      geometry::Rotation3::FromAxisAngle({0.02, 0.05, 0.08}),
      {0.12, 0.05, 0.06}};
  const WallRecording training({geometry::Rigid3{},
                                geometry::Rigid3{{}, {0.3, 0, 0}},
                                geometry::Rigid3{{}, {0, 0.2, 0.1}}});
  const WallRecording test({query});
  const dataset::Dataset dataset = training.Open();
  FeaturePnpOptions options = Quiet();
  options.kind = FeatureKind::kOrb;
  const auto build = [&] {
    return BuildFeaturePnpBaseline(dataset, dataset.calibration(), options)
        .value();
  };
  const std::unique_ptr<localizer::Localizer> baseline = build();
  EXPECT_EQ(baseline->info().method, "orb-pnp");
  const image::Frame frame = *test.Open().Load(0);
  const auto first = baseline->Localize(frame, {});
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_EQ(first->outcome, localizer::Outcome::kLocalized);
  // ORB's corners are placed to a pixel or two at the coarser levels of its
  // pyramid: at f 280 and 2 m, 1 px is 7 mm.
  const geometry::PoseError error =
      geometry::ErrorBetween(first->world_from_camera, query);
  EXPECT_LT(error.translation_m, 0.03);
  EXPECT_LT(error.rotation_rad, 0.015);
  // Hashing draws its keys from the seed alone.
  const auto again = build()->Localize(frame, {});
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->world_from_camera, first->world_from_camera);
}

TEST(FeaturePnpBaseline, HasNamesForItsKinds) {
  EXPECT_EQ(BaselineOfName("sift-pnp"), FeatureKind::kSift);
  EXPECT_EQ(BaselineOfName("orb-pnp"), FeatureKind::kOrb);
  EXPECT_EQ(BaselineOfName("surf-pnp"), std::nullopt);
}

TEST(FeaturePnpOptions, RefusesWhatMakesNoSense) {
  EXPECT_TRUE(FeaturePnpOptions().Validate().ok());
  FeaturePnpOptions options;
  options.keyframes = -1;
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.match_ratio = 0;
  EXPECT_FALSE(options.Validate().ok());
  options = {};
  options.inlier_px = std::nan("");
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace treeline::accuracy
