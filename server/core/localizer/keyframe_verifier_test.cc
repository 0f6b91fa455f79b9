#include "server/core/localizer/keyframe_verifier.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/camera/camera.h"
#include "common/image/frame.h"
#include "gtest/gtest.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/features/planar_image.h"
#include "server/core/keyframes/testing_keyframe_model.h"

namespace treeline::localizer {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kFocal_px = 260;
constexpr double kWall_m = 2;
// How far candidates are beside the camera.
constexpr double kAside_m = 0.01;

// A wall with blots, 2 m before a camera at the origin, which is also where the
// only keyframe was taken: alignment finds back there from a centimetre aside.
class KeyframeVerifierTest : public testing::Test {
 protected:
  KeyframeVerifierTest() {
    calibration_.color = calibration_.depth =
        *camera::Camera::Parse("PINHOLE,260,260,160,120", kWidth, kHeight);
    frame_.color.width = kWidth;
    frame_.color.height = kHeight;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double gray = 120 + 45 * std::sin(x / 9.0) * std::cos(y / 7.0) +
                            30 * std::sin((x + 2 * y) / 16.0);
        frame_.color.rgb.insert(frame_.color.rgb.end(), 3,
                                static_cast<uint8_t>(std::lround(gray)));
      }
    }
    forest::ModelInfo info;
    info.calibration = calibration_;
    model_ = *keyframes::ModelWithKeyframes(Wall(), info);
  }

  keyframes::Keyframes Wall() const {
    features::GrayPyramid pyramid;
    pyramid.Assign(features::PlanarImage(frame_.color));
    keyframes::Keyframes keyframes;
    for (int y = 20; y < kHeight - 20; y += 5) {
      for (int x = 20; x < kWidth - 20; x += 5) {
        keyframes::KeyframePoint point;
        point.position_in_world = {
            static_cast<float>((x - kWidth / 2.0) / kFocal_px * kWall_m),
            static_cast<float>((y - kHeight / 2.0) / kFocal_px * kWall_m),
            static_cast<float>(kWall_m)};
        for (int l = 0; l < features::GrayPyramid::kLevels; ++l) {
          point.gray[static_cast<size_t>(l)] =
              static_cast<uint8_t>(std::lround(pyramid.level(l).At(
                  features::AtLevel(static_cast<float>(x), l),
                  features::AtLevel(static_cast<float>(y), l))));
        }
        keyframes.points.push_back(point);
      }
    }
    keyframes.records.resize(1);
    keyframes.records[0].points =
        static_cast<uint32_t>(keyframes.points.size());
    return keyframes;
  }

  // Of 50 features that determine the position to sigma_m along each axis.
  Verdict Verify(double sigma_m, AlignmentUse use) const {
    Candidate candidate;
    candidate.is_matched = true;
    candidate.samples = 100;
    candidate.pose.emplace();
    candidate.pose->inliers = 50;
    candidate.pose->world_from_camera.translation = {kAside_m, 0, 0};
    for (size_t i = 0; i < 6; ++i) {
      candidate.pose->covariance[7 * i] = sigma_m * sigma_m;
    }
    const LocalizeOptions options;
    QueryScratch scratch;
    Query query(frame_, calibration_, DepthUse::kWhereGiven, options, scratch);
    return (*KeyframeVerifier::Create(*model_, use))->Verify(query, candidate);
  }

  camera::RgbdCalibration calibration_;
  image::Frame frame_;
  std::unique_ptr<const forest::ModelFile> model_;
};

TEST_F(KeyframeVerifierTest, AlignmentMovesAPoseThatFeaturesLeaveOpen) {
  const Verdict verdict = Verify(0.02, AlignmentUse::kFuses);
  EXPECT_LT(verdict.world_from_camera.translation.x, 0.5 * kAside_m);
  EXPECT_GT(verdict.evidence.moved_m, 0.5 * kAside_m);
}

// The move is more than five standard deviations.
TEST_F(KeyframeVerifierTest, ButNotOneThatTheyAreSureOf) {
  const Verdict verdict = Verify(0.001, AlignmentUse::kFuses);
  EXPECT_EQ(verdict.world_from_camera.translation.x, kAside_m);
  EXPECT_EQ(verdict.covariance[0], 1e-6);
  EXPECT_EQ(verdict.evidence.moved_m, 0);
}

// Both are estimates by one map: together they know no more than the better.
TEST_F(KeyframeVerifierTest, AFusedPoseIsNoSurerThanItsAlignment) {
  const Verdict aligned = Verify(0.05, AlignmentUse::kReplaces);
  const Verdict fused = Verify(0.05, AlignmentUse::kFuses);
  EXPECT_GT(fused.covariance[0], aligned.covariance[0]);
  EXPECT_LE(fused.covariance[0], 2.001 * aligned.covariance[0]);
  EXPECT_LT(fused.evidence.sigma_m, std::sqrt(fused.covariance[0]));
}

TEST_F(KeyframeVerifierTest, SaysWhatFeaturesAloneKnow) {
  const Verdict fused = Verify(0.02, AlignmentUse::kFuses);
  ASSERT_TRUE(fused.of_features.has_value());
  EXPECT_EQ((*fused.of_features)[0], 0.02 * 0.02);
  EXPECT_FALSE(Verify(0.02, AlignmentUse::kReplaces).of_features.has_value());
  // Depth holds the pose, too.
  frame_.depth.emplace();
  frame_.depth->width = kWidth;
  frame_.depth->height = kHeight;
  frame_.depth->unit_m = 0.001;
  frame_.depth->values.assign(kWidth * kHeight,
                              static_cast<uint16_t>(1000 * kWall_m));
  EXPECT_FALSE(Verify(0.02, AlignmentUse::kFuses).of_features.has_value());
}

TEST_F(KeyframeVerifierTest, WhereAlignmentReplacesPosesItMovesAny) {
  const Verdict verdict = Verify(0.001, AlignmentUse::kReplaces);
  EXPECT_LT(verdict.world_from_camera.translation.x, 0.5 * kAside_m);
}

}  // namespace
}  // namespace treeline::localizer
