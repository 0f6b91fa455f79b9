#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/random.h"
#include "common/image/decode.h"
#include "evaluation/accuracy/evaluation.h"
#include "evaluation/accuracy/evaluation_table.h"
#include "evaluation/accuracy/feature_pnp_baseline.h"
#include "evaluation/accuracy/query_calibration.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/localizer/localizer.h"
#include "server/core/training/scene_trainer.h"
#include "server/core/training/sift_trainer.h"
#include "tests/pipeline/same_answers.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

// Two walls covered with random blots that meet at a right angle: z = 2 in
// front and x = 1.2 to the right.
class Corner {
 public:
  explicit Corner(uint64_t seed) {
    for (size_t wall = 0; wall < 2; ++wall) {
      brightness_[wall].assign(kSize * kSize, 128);
      base::Random random(seed, wall);
      for (int i = 0; i < 900; ++i) AddBlot(random, brightness_[wall]);
    }
  }

  // What a ray from `origin` meets, and how bright it is there.
  struct Hit {
    geometry::Vec3 point;
    double brightness = 0;
  };
  Hit Look(geometry::Vec3 origin, geometry::Vec3 direction) const {
    const double front = (2 - origin.z) / direction.z;
    const double right = (1.2 - origin.x) / direction.x;
    const bool is_right = right > 0 && (right < front || front <= 0);
    const geometry::Vec3 point =
        origin + (is_right ? right : front) * direction;
    const double u = is_right ? point.z : point.x;
    return {point, Sample(brightness_[is_right ? 1 : 0], u, point.y)};
  }

 private:
  static constexpr int kSize = 900;
  static constexpr double kTexel = 0.006;

  static void AddBlot(base::Random& random, std::vector<double>& texture) {
    const double x = random.NextUniform(0, kSize);
    const double y = random.NextUniform(0, kSize);
    const double radius = random.NextUniform(3, 14);
    const double height = random.NextUniform(-110, 110);
    const int reach = static_cast<int>(3 * radius);
    for (int v = std::max(0, static_cast<int>(y) - reach);
         v < std::min(kSize, static_cast<int>(y) + reach); ++v) {
      for (int u = std::max(0, static_cast<int>(x) - reach);
           u < std::min(kSize, static_cast<int>(x) + reach); ++u) {
        const double d = std::hypot(u - x, v - y) / radius;
        texture[static_cast<size_t>(v * kSize + u)] +=
            height * std::exp(-d * d);
      }
    }
  }

  static double Sample(const std::vector<double>& texture, double u, double v) {
    const double x = std::clamp(u / kTexel + kSize / 2.0, 0.0, kSize - 1.001);
    const double y = std::clamp(v / kTexel + kSize / 2.0, 0.0, kSize - 1.001);
    const auto at = [&](int dx, int dy) {
      const size_t row = static_cast<size_t>(y) + static_cast<size_t>(dy);
      const size_t column = static_cast<size_t>(x) + static_cast<size_t>(dx);
      return texture[row * kSize + column];
    };
    const double fx = x - std::floor(x);
    const double fy = y - std::floor(y);
    const double value = (1 - fy) * ((1 - fx) * at(0, 0) + fx * at(1, 0)) +
                         fy * ((1 - fx) * at(0, 1) + fx * at(1, 1));
    return std::clamp(value, 0.0, 255.0);
  }

  std::vector<double> brightness_[2];
};

image::ColorImage Render(const Corner& corner, const camera::Camera& camera,
                         const geometry::Rigid3& world_from_camera) {
  image::ColorImage image{camera.width(), camera.height(), {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const camera::Pixel ray = *camera.Unproject({double(x), double(y)});
      const auto hit = corner.Look(
          world_from_camera.translation,
          world_from_camera.rotation * geometry::Vec3{ray.x, ray.y, 1});
      const auto value = static_cast<uint8_t>(std::lround(hit.brightness));
      image.rgb.insert(image.rgb.end(), {value, value, value});
    }
  }
  return image;
}

// Photographs of the corner with a COLMAP model whose points are the images'
// own features, put where the truth says that they are; one model for all
// tests.
class SiftLocalizerTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new std::string(testing::TempDir() + "/sift_localizer_test_" +
                              std::to_string(getpid()));
    corner_ = new Corner(5);
    Record();
    dataset_ =
        new dataset::Dataset(dataset::Dataset::Open({.uri = Uri()}).value());
    training::SceneTrainingOptions options;
    options.method = "sift";
    const auto trained =
        training::TrainScene(*dataset_, options, ModelPath(), true, {});
    ASSERT_TRUE(trained.ok()) << trained.status();
    EXPECT_EQ(trained->info.training_frames, 6);
    EXPECT_FALSE(trained->info.units_are_metres);
    // Cameras about 2 from one wall and 1.2 from the other.
    EXPECT_NEAR(trained->info.viewing_distance, 2, 0.4);
    localizer_ = localizer::OpenLocalizer(ModelPath()).value().release();
  }
  static void TearDownTestSuite() {
    delete localizer_;
    delete dataset_;
    delete corner_;
    fs::remove_all(*folder_);
    delete folder_;
  }

  static std::string ModelPath() { return *folder_ + "/model.treeline"; }
  static std::string Uri() {
    return absl::StrCat("colmap:", *folder_, "/model,", *folder_, "/images");
  }

  static void Record() {
    const camera::Camera camera =
        camera::Camera::Parse("PINHOLE,280,280,159.5,119.5", 320, 240).value();
    fs::create_directories(*folder_ + "/model");
    fs::create_directories(*folder_ + "/images");
    std::ofstream(*folder_ + "/model/cameras.txt")
        << "1 PINHOLE 320 240 280 280 160 120\n";
    std::ofstream images(*folder_ + "/model/images.txt");
    std::ofstream points(*folder_ + "/model/points3D.txt");
    int point_id = 0;
    for (int i = 0; i < 6; ++i) {
      const geometry::Rigid3 pose{
          geometry::Rotation3::FromAxisAngle({0, 0.1 + 0.08 * i, 0}),
          {0.12 * i - 0.4, 0.05 * (i % 3), 0.1 * (i % 2)}};
      const image::ColorImage image = Render(*corner_, camera, pose);
      std::ofstream(absl::StrCat(*folder_, "/images/", i, ".png"),
                    std::ios::binary)
          << image::EncodePng(image).value();
      const geometry::Rigid3 inverse = pose.Inverse();
      const geometry::Rotation3& q = inverse.rotation;
      const geometry::Vec3& t = inverse.translation;
      images << absl::StrFormat(
          "%d %.17g %.17g %.17g %.17g %.9g %.9g %.9g 1 "
          "%d.png\n",
          i + 1, q.w, q.x, q.y, q.z, t.x, t.y, t.z, i);
      const features::SiftFeatures features = features::ExtractSift(image, {});
      for (size_t k = 0; k < features.size(); ++k, ++point_id) {
        const camera::Pixel at = features.keypoints[k].pixel;
        const camera::Pixel ray = *camera.Unproject(at);
        const geometry::Vec3 p =
            corner_
                ->Look(pose.translation,
                       pose.rotation * geometry::Vec3{ray.x, ray.y, 1})
                .point;
        images << absl::StrFormat("%.6f %.6f %d ", at.x + 0.5, at.y + 0.5,
                                  point_id);
        points << absl::StrFormat("%d %.9g %.9g %.9g 0 0 0 0 %d %d\n", point_id,
                                  p.x, p.y, p.z, i + 1, k);
      }
      images << "\n";
    }
  }

  static std::string* folder_;
  static Corner* corner_;
  static dataset::Dataset* dataset_;
  static localizer::Localizer* localizer_;
  const base::SteadyClock clock_{};
};

std::string* SiftLocalizerTest::folder_ = nullptr;
Corner* SiftLocalizerTest::corner_ = nullptr;
dataset::Dataset* SiftLocalizerTest::dataset_ = nullptr;
localizer::Localizer* SiftLocalizerTest::localizer_ = nullptr;

// Keypoints are found to about 0.2 px at a focal length of 280 px, 2 away, and
// there are hundreds of them.
constexpr double kTranslationBound = 0.005;
constexpr double kRotationBound_rad = 0.003;

TEST_F(SiftLocalizerTest, FindsAnotherCameraOfAnotherSizeAndModel) {
  const geometry::Rigid3 truth{
      geometry::Rotation3::FromAxisAngle({0.03, 0.33, -0.06}),
      {-0.1, 0.08, 0.05}};
  const camera::Camera camera =
      camera::Camera::Parse("RADIAL_FISHEYE,330,199.5,149.5,-0.04,0.01", 400,
                            300)
          .value();
  image::Frame frame;
  frame.color = Render(*corner_, camera, truth);
  frame.calibration.emplace();
  frame.calibration->color = camera;
  localizer::LocalizeOptions options;
  options.keep_correspondences = true;
  const auto estimate = localizer_->Localize(frame, options);
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_EQ(estimate->outcome, localizer::Outcome::kLocalized);
  const geometry::PoseError error =
      geometry::ErrorBetween(estimate->world_from_camera, truth);
  EXPECT_LT(error.translation_m, kTranslationBound);
  EXPECT_LT(error.rotation_rad, kRotationBound_rad);
  ASSERT_EQ(estimate->correspondences.size(),
            static_cast<size_t>(estimate->samples));
  int inliers = 0;
  for (const localizer::Correspondence& match : estimate->correspondences) {
    inliers += match.inlier;
  }
  EXPECT_EQ(inliers, estimate->inliers);
  const auto again = localizer_->Localize(frame, {});
  EXPECT_EQ(again->world_from_camera, estimate->world_from_camera);
}

TEST_F(SiftLocalizerTest, CorrectsAStatedFocalLengthThatFeaturesRefute) {
  constexpr double kFocal_px = 330;
  constexpr double kTooLong = 1.15;
  const auto pinhole = [](double focal_px) {
    return camera::Camera::Parse(absl::StrCat("PINHOLE,", focal_px, ",",
                                              focal_px, ",199.5,149.5"),
                                 400, 300)
        .value();
  };
  const geometry::Rigid3 truth{
      geometry::Rotation3::FromAxisAngle({0.03, 0.33, -0.06}),
      {-0.1, 0.08, 0.05}};
  image::Frame frame;
  frame.color = Render(*corner_, pinhole(kFocal_px), truth);
  frame.calibration.emplace();
  frame.calibration->color = pinhole(kTooLong * kFocal_px);
  const auto estimate = localizer_->Localize(frame, {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_EQ(estimate->outcome, localizer::Outcome::kLocalized);
  // Hundreds of keypoints tell it to a few thousandths; so much of 2 away is
  // along the line of sight.
  EXPECT_NEAR(estimate->focal_scale * kTooLong, 1, 0.005);
  EXPECT_LT(
      geometry::ErrorBetween(estimate->world_from_camera, truth).translation_m,
      kTranslationBound + 2 * 0.005);
}

TEST_F(SiftLocalizerTest, AllVectorInstructionsGiveTheSameAnswers) {
  const camera::Camera camera =
      camera::Camera::Parse("PINHOLE,280,280,159.5,119.5", 320, 240).value();
  std::vector<image::Frame> frames(8);
  for (size_t i = 0; i < frames.size(); ++i) {
    const double turn_rad = 0.14 + 0.05 * static_cast<double>(i);
    const geometry::Rigid3 pose{
        geometry::Rotation3::FromAxisAngle({0.03, turn_rad, -0.06}),
        {-0.1, 0.08, 0.05}};
    frames[i].color = Render(*corner_, camera, pose);
    frames[i].calibration.emplace().color = camera;
  }
  ExpectSameAnswers(*localizer_, frames);
}

TEST_F(SiftLocalizerTest, EvaluationTakesEachFramesCameraAndSceneUnits) {
  EXPECT_FALSE(
      accuracy::QueryCalibration(*dataset_, {.uri = Uri()}, {}).has_value());
  accuracy::EvaluationOptions options;
  options.quiet = true;
  const auto results =
      accuracy::Evaluate(*localizer_, *dataset_, options, clock_);
  ASSERT_TRUE(results.ok()) << results.status();
  for (const accuracy::FrameResult& result : *results) {
    ASSERT_TRUE(result.localized()) << result.stem;
    EXPECT_LT(result.error->translation_m, kTranslationBound) << result.stem;
  }
  accuracy::EvaluatedMethod method;
  method.model = localizer_->info();
  method.results = *results;
  EXPECT_THAT(accuracy::EvaluationTable(method, {}),
              AllOf(HasSubstr("% of the viewing distance"),
                    testing::Not(HasSubstr("cm"))));
}

TEST_F(SiftLocalizerTest, TheBaselineKnowsTheSamePoints) {
  accuracy::FeaturePnpOptions options;
  options.quiet = true;
  const auto baseline = accuracy::BuildFeaturePnpBaseline(
      *dataset_, dataset_->calibration(), options);
  ASSERT_TRUE(baseline.ok()) << baseline.status();
  EXPECT_EQ((*baseline)->info().training_frames, 6);
  const auto frame = dataset_->Load(3);
  ASSERT_TRUE(frame.ok()) << frame.status();
  const auto estimate = (*baseline)->Localize(*frame, {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  ASSERT_EQ(estimate->outcome, localizer::Outcome::kLocalized);
  EXPECT_LT(geometry::ErrorBetween(estimate->world_from_camera,
                                   *dataset_->frame(3).world_from_camera)
                .translation_m,
            kTranslationBound);
}

TEST_F(SiftLocalizerTest, NoiseABlankWallAndAnotherSceneAreNotLocalized) {
  image::Frame frame;
  base::Random random(1, 0);
  for (int i = 0; i < 3 * 320 * 240; ++i) {
    frame.color.rgb.push_back(static_cast<uint8_t>(random.NextBelow(256)));
  }
  frame.color.width = 320;
  frame.color.height = 240;
  auto estimate = localizer_->Localize(frame, {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  EXPECT_EQ(estimate->outcome, localizer::Outcome::kNotLocalized);
  frame.color.rgb.assign(frame.color.rgb.size(), 200);
  estimate = localizer_->Localize(frame, {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  EXPECT_EQ(estimate->outcome, localizer::Outcome::kNotLocalized);
  EXPECT_EQ(estimate->reason, localizer::NotLocalizedReason::kTooFewSamples);
  frame.color = Render(Corner(6), localizer_->info().calibration.color,
                       geometry::Rigid3{});
  estimate = localizer_->Localize(frame, {});
  ASSERT_TRUE(estimate.ok()) << estimate.status();
  EXPECT_EQ(estimate->outcome, localizer::Outcome::kNotLocalized);
}

TEST_F(SiftLocalizerTest, RefusesAnImageOfAnotherSizeThanItsCamera) {
  image::Frame frame;
  frame.color = {10, 10, std::vector<uint8_t>(300)};
  const auto estimate = localizer_->Localize(frame, {});
  EXPECT_EQ(estimate.status().code(), absl::StatusCode::kInvalidArgument);
  frame.color = {};
  EXPECT_EQ(localizer_->Localize(frame, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(SiftLocalizerTest, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  image::Frame frame;
  frame.color = Render(*corner_, localizer_->info().calibration.color, {});
  EXPECT_EQ(
      localizer_->Localize(frame, {.stop = stop.get_token()}).status().code(),
      absl::StatusCode::kCancelled);
  EXPECT_EQ(training::TrainSiftForest(*dataset_, {}, true, stop.get_token())
                .status()
                .code(),
            absl::StatusCode::kCancelled);
}

TEST_F(SiftLocalizerTest, ForestsDoNotDependOnThreads) {
  training::SiftTrainingOptions options{
      .threads = 1, .trees = 2, .images_per_tree = 4};
  const auto one = training::TrainSiftForest(*dataset_, options, true, {});
  options.threads = 3;
  const auto three = training::TrainSiftForest(*dataset_, options, true, {});
  ASSERT_TRUE(one.ok() && three.ok());
  EXPECT_TRUE(one->forest.View().Validate().ok());
  ASSERT_EQ(one->forest.nodes.size(), three->forest.nodes.size());
  for (size_t i = 0; i < one->forest.nodes.size(); ++i) {
    ASSERT_EQ(one->forest.nodes[i].lo, three->forest.nodes[i].lo);
    ASSERT_EQ(one->forest.nodes[i].hi, three->forest.nodes[i].hi);
  }
  ASSERT_EQ(one->forest.sift_descriptors.size(),
            three->forest.sift_descriptors.size());
  for (size_t i = 0; i < one->forest.sift_descriptors.size(); ++i) {
    ASSERT_EQ(one->forest.sift_descriptors[i].values,
              three->forest.sift_descriptors[i].values);
  }
}

TEST_F(SiftLocalizerTest, TrainingNeedsAStructureAndSensibleOptions) {
  EXPECT_THAT(
      std::string(training::TrainSiftForest(*dataset_, {.trees = 0}, true, {})
                      .status()
                      .message()),
      HasSubstr("trees is 0"));
  fs::create_directories(*folder_ + "/bare");
  fs::copy_file(*folder_ + "/model/cameras.txt",
                *folder_ + "/bare/cameras.txt");
  std::ofstream(*folder_ + "/bare/images.txt") << "1 1 0 0 0 0 0 0 1 0.png\n";
  const auto bare =
      dataset::Dataset::Open({.uri = absl::StrCat("colmap:", *folder_, "/bare,",
                                                  *folder_, "/images")});
  ASSERT_TRUE(bare.ok()) << bare.status();
  const auto trained = training::TrainSiftForest(*bare, {}, true, {});
  EXPECT_EQ(trained.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(trained.status().message()), HasSubstr("keypoint"));
}

TEST(LabelFeaturesTest, TakesTheNearestKeypointWithAPoint) {
  const std::vector<features::SiftKeypoint> features = {
      {.pixel = {10, 10}}, {.pixel = {-3, 5}}, {.pixel = {100, 100}}};
  const std::vector<dataset::SfmModel::Keypoint> keypoints = {
      {{10.5, 10}, -1},
      {{11.2, 10}, 4},
      {{10, 9}, 7},
      {{-3.9, 4}, 2},
      {{101.6, 100}, 9}};
  EXPECT_EQ(training::LabelFeatures(features, keypoints, 1.5),
            (std::vector<int32_t>{7, 2, -1}));
}

}  // namespace
}  // namespace treeline
