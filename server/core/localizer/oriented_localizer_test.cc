#include "server/core/localizer/oriented_localizer.h"

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/image/quarter_turn.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/localizer/parameters.h"
#include "server/core/localizer/query.h"

namespace treeline::localizer {
namespace {

using geometry::Rigid3;
using geometry::Vec3;
using image::QuarterTurn;
using ::testing::ElementsAre;

constexpr int kWidth = 6;
constexpr int kHeight = 4;
constexpr double kThreshold = 0.9;

// Answers by a function of the frame, and remembers what it was asked.
class FakeLocalizer final : public Localizer {
 public:
  using Answer = std::function<absl::StatusOr<PoseEstimate>(
      const image::Frame&, const LocalizeOptions&)>;

  FakeLocalizer(Answer answer, camera::RgbdSensor pose_sensor)
      : answer_(std::move(answer)) {
    info_.calibration.color =
        camera::Camera::Parse("PINHOLE,5,6,2.6,1.4", kWidth, kHeight).value();
    info_.calibration.depth = info_.calibration.color;
    info_.calibration.color_from_depth = {
        geometry::Rotation3::FromAxisAngle({0.1, 0.2, 0.3}), {0.1, 0, 0.02}};
    info_.calibration.pose_sensor = pose_sensor;
    info_.confidence = forest::ConfidenceModel{.threshold = kThreshold};
  }

  absl::StatusOr<PoseEstimate> Localize(
      const image::Frame& frame,
      const LocalizeOptions& options) const override {
    return answer_(frame, options);
  }
  const forest::ModelInfo& info() const override { return info_; }
  DepthUse depth_use() const override { return DepthUse::kIgnored; }

 private:
  const Answer answer_;
  forest::ModelInfo info_;
};

// Its first pixel is red: so the corner that is red tells how it was turned.
image::Frame SomeFrame(image::Orientation orientation = {}) {
  image::Frame frame;
  frame.color = {.width = kWidth,
                 .height = kHeight,
                 .rgb = std::vector<uint8_t>(3 * kWidth * kHeight)};
  frame.color.rgb[0] = 255;
  frame.orientation = orientation;
  return frame;
}

QuarterTurn TurnOf(const image::Frame& frame) {
  const std::vector<uint8_t>& rgb = frame.color.rgb;
  if (rgb[0] == 255) return QuarterTurn::kNone;
  if (rgb[rgb.size() - 3] == 255) return QuarterTurn::kHalf;
  const auto top_right = static_cast<size_t>(3 * (frame.color.width - 1));
  return rgb[top_right] == 255 ? QuarterTurn::kClockwise
                               : QuarterTurn::kCounterclockwise;
}

PoseEstimate Localized(double confidence) {
  PoseEstimate estimate;
  estimate.outcome = Outcome::kLocalized;
  estimate.reason = NotLocalizedReason::kNone;
  estimate.confidence = confidence;
  estimate.timings.total_ms = 1;
  return estimate;
}

PoseEstimate Refused(double confidence) {
  PoseEstimate estimate = Localized(confidence);
  estimate.outcome = Outcome::kNotLocalized;
  estimate.reason = NotLocalizedReason::kLowConfidence;
  return estimate;
}

PoseEstimate OfUnknownCamera(double confidence) {
  PoseEstimate estimate = Refused(confidence);
  estimate.reason = NotLocalizedReason::kUnknownCamera;
  return estimate;
}

// What it takes to be believed at another turn, by the odds.
double ConfidenceOfOdds(double odds) { return odds / (1 + odds); }
constexpr double kThresholdOdds = kThreshold / (1 - kThreshold);

class OrientedLocalizerTest : public testing::Test {
 protected:
  // What the upright localizer says of the frame at each turn.
  absl::StatusOr<PoseEstimate> Localize(const image::Frame& frame,
                                        const std::vector<PoseEstimate>& says,
                                        const LocalizeOptions& options = {}) {
    asked_.clear();
    const OrientedLocalizer localizer(
        std::make_unique<FakeLocalizer>(
            [&](const image::Frame& turned, const LocalizeOptions&) {
              asked_.push_back(TurnOf(turned));
              return says.at(static_cast<size_t>(asked_.back()));
            },
            camera::RgbdSensor::kColor),
        other_turns_);
    return localizer.Localize(frame, options);
  }

  bool other_turns_ = true;
  std::vector<QuarterTurn> asked_;
};

TEST_F(OrientedLocalizerTest, AnUprightFrameIsAskedOnce) {
  const auto estimate = Localize(
      SomeFrame(), {Localized(0.95), Localized(1), Localized(1), Localized(1)});
  ASSERT_TRUE(estimate.ok());
  EXPECT_EQ(estimate->confidence, 0.95);
  EXPECT_THAT(asked_, ElementsAre(QuarterTurn::kNone));
}

TEST_F(OrientedLocalizerTest, APoseOfAnUnknownCameraSettlesTheTurn) {
  std::vector<PoseEstimate> says(4, Refused(0.2));
  says[0] = OfUnknownCamera(0.95);
  ASSERT_TRUE(Localize(SomeFrame(), says).ok());
  EXPECT_THAT(asked_, ElementsAre(QuarterTurn::kNone));
  says[0] = OfUnknownCamera(0.2);
  ASSERT_TRUE(Localize(SomeFrame(), says).ok());
  EXPECT_THAT(asked_, ::testing::SizeIs(4));
}

TEST_F(OrientedLocalizerTest, TheStatedTurnIsTheOnlyOne) {
  const auto estimate =
      Localize(SomeFrame({QuarterTurn::kClockwise, true}),
               {Localized(1), Refused(0.2), Localized(1), Localized(1)});
  ASSERT_TRUE(estimate.ok());
  EXPECT_EQ(estimate->outcome, Outcome::kNotLocalized);
  // Nothing speaks against that turn, so the evidence is as it was found.
  EXPECT_EQ(estimate->confidence, 0.2);
  EXPECT_THAT(asked_, ElementsAre(QuarterTurn::kClockwise));
}

TEST_F(OrientedLocalizerTest, OtherTurnsAreTriedAfterAGuess) {
  const std::vector<PoseEstimate> lost(4, Refused(0.2));
  ASSERT_TRUE(Localize(SomeFrame(), lost).ok());
  EXPECT_THAT(asked_,
              ElementsAre(QuarterTurn::kNone, QuarterTurn::kClockwise,
                          QuarterTurn::kHalf, QuarterTurn::kCounterclockwise));
  const auto estimate = Localize(SomeFrame({QuarterTurn::kHalf, false}), lost);
  ASSERT_TRUE(estimate.ok());
  EXPECT_THAT(asked_, ElementsAre(QuarterTurn::kHalf, QuarterTurn::kNone,
                                  QuarterTurn::kClockwise,
                                  QuarterTurn::kCounterclockwise));
  EXPECT_EQ(estimate->confidence, 0.2);
  EXPECT_EQ(estimate->timings.total_ms, 4);
}

TEST_F(OrientedLocalizerTest, TriesNoOtherTurnIfItIsNotTo) {
  other_turns_ = false;
  const std::vector<PoseEstimate> lost(4, Refused(0.2));
  ASSERT_TRUE(Localize(SomeFrame({QuarterTurn::kHalf, false}), lost).ok());
  EXPECT_THAT(asked_, ElementsAre(QuarterTurn::kHalf));
}

TEST_F(OrientedLocalizerTest, AnotherTurnNeedsMoreEvidence) {
  const double enough =
      ConfidenceOfOdds(1.01 * kOtherTurnOdds * kThresholdOdds);
  const double short_of_it =
      ConfidenceOfOdds(0.99 * kOtherTurnOdds * kThresholdOdds);
  const auto found = Localize(SomeFrame(), {Refused(0.1), Refused(0.1),
                                            Localized(enough), Refused(0.1)});
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->outcome, Outcome::kLocalized);
  EXPECT_NEAR(found->confidence, kThreshold, 0.002);
  const auto lost = Localize(
      SomeFrame(),
      {Refused(0.1), Refused(0.1), Localized(short_of_it), Refused(0.1)});
  ASSERT_TRUE(lost.ok());
  EXPECT_EQ(lost->outcome, Outcome::kNotLocalized);
  EXPECT_EQ(lost->reason, NotLocalizedReason::kLowConfidence);
}

TEST_F(OrientedLocalizerTest, TheBestAcceptedTurnWins) {
  const auto estimate = Localize(
      SomeFrame(),
      {Refused(0.5), Localized(0.9990), Localized(0.9999), Localized(0.9995)});
  ASSERT_TRUE(estimate.ok());
  EXPECT_EQ(estimate->outcome, Outcome::kLocalized);
  EXPECT_EQ(asked_.size(), 4u);
  EXPECT_NEAR(estimate->confidence,
              ConfidenceOfOdds(0.9999 / 0.0001 / kOtherTurnOdds), 1e-9);
}

// A client that takes little for an answer still gets the best one.
TEST_F(OrientedLocalizerTest, AWeakPoseDoesNotHideASureOneAtAnotherTurn) {
  LocalizeOptions options;
  options.min_confidence = 0.3;
  const auto better = Localize(
      SomeFrame(), {Localized(0.4), Refused(0), Localized(0.9999), Refused(0)},
      options);
  ASSERT_TRUE(better.ok());
  EXPECT_GT(better->confidence, kThreshold);
  const auto weak = Localize(
      SomeFrame(), {Localized(0.4), Refused(0), Localized(0.8), Refused(0)},
      options);
  ASSERT_TRUE(weak.ok());
  EXPECT_EQ(weak->outcome, Outcome::kLocalized);
  EXPECT_EQ(weak->confidence, 0.4);
}

TEST_F(OrientedLocalizerTest, ErrorsAreThoseOfTheLocalizer) {
  int calls = 0;
  const OrientedLocalizer localizer(
      std::make_unique<FakeLocalizer>(
          [&](const image::Frame&,
              const LocalizeOptions&) -> absl::StatusOr<PoseEstimate> {
            if (++calls < 2) return Refused(0.1);
            return absl::CancelledError("stopped");
          },
          camera::RgbdSensor::kColor),
      true);
  EXPECT_EQ(localizer.Localize(SomeFrame(), {}).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(calls, 2);
}

// A world in which the truth is known: the localizer sees the turned frame, and
// gives the pose of its pose sensor, with the cameras that a query takes.
class TurnedPoseTest : public testing::TestWithParam<QuarterTurn> {
 protected:
  static constexpr double kTolerance = 1e-12;

  const Rigid3 world_from_color_{
      geometry::Rotation3::FromAxisAngle({0.3, -0.5, 0.8}), {1, 2, 3}};

  Rigid3 WorldFromTurned() const {
    return world_from_color_ *
           Rigid3{image::TurnedFromCamera(GetParam()), {}}.Inverse();
  }

  // Of the colour camera of the frame as it is, through a localizer of poses of
  // `pose_sensor`.
  void ExpectThePoseOfTheFrame(const image::Frame& frame, DepthUse depth_use,
                               camera::RgbdSensor pose_sensor) {
    std::optional<PoseEstimate> given;
    auto fake = std::make_unique<FakeLocalizer>(
        [&](const image::Frame& turned, const LocalizeOptions& options) {
          EXPECT_TRUE(CheckFrame(turned,
                                 QueryCalibration(turned, *info_, depth_use),
                                 depth_use, "fake")
                          .ok());
          given = Localized(1);
          // The fake confirms the camera that is stated.
          given->found_camera =
              QueryCalibration(turned, *info_, depth_use).color;
          given->world_from_camera = camera::PoseOfSensor(
              WorldFromTurned(), camera::RgbdSensor::kColor, pose_sensor,
              QueryCalibration(turned, *info_, depth_use));
          EXPECT_TRUE(options.priors.Allows(given->world_from_camera));
          return *given;
        },
        pose_sensor);
    info_ = &fake->info();
    const OrientedLocalizer localizer(std::move(fake), true);
    const Rigid3 truth = camera::PoseOfSensor(
        world_from_color_, camera::RgbdSensor::kColor, pose_sensor,
        QueryCalibration(frame, *info_, depth_use));
    LocalizeOptions options;
    options.priors.pose = geometry::PosePrior{truth, 1e-6, 1e-6};
    const auto estimate = localizer.Localize(frame, options);
    ASSERT_TRUE(estimate.ok()) << estimate.status();
    const geometry::PoseError error =
        geometry::ErrorBetween(estimate->world_from_camera, truth);
    EXPECT_LT(error.translation_m, kTolerance);
    EXPECT_LT(error.rotation_rad, 1e-7);
    EXPECT_EQ(estimate->found_camera,
              QueryCalibration(frame, *info_, depth_use).color);
  }

  const forest::ModelInfo* info_ = nullptr;
};

TEST_P(TurnedPoseTest, IsThatOfTheFrameAsItIs) {
  image::Frame frame = SomeFrame({GetParam(), true});
  ExpectThePoseOfTheFrame(frame, DepthUse::kIgnored,
                          camera::RgbdSensor::kColor);
  frame.depth = image::DepthImage{
      .width = kWidth,
      .height = kHeight,
      .values = std::vector<uint16_t>(kWidth * kHeight, 1000)};
  for (const camera::RgbdSensor sensor :
       {camera::RgbdSensor::kColor, camera::RgbdSensor::kDepth}) {
    ExpectThePoseOfTheFrame(frame, DepthUse::kRequired, sensor);
    // With cameras of its own.
    image::Frame other = frame;
    other.calibration = camera::RgbdCalibration{
        .color =
            camera::Camera::Parse("RADIAL,7,3.1,1.1,0.1,0.01", kWidth, kHeight)
                .value(),
        .depth =
            camera::Camera::Parse("PINHOLE,7,8,3,2", kWidth, kHeight).value(),
        .color_from_depth = {geometry::Rotation3::FromAxisAngle({0.3, 0.1, 0}),
                             {0, 0.2, 0}}};
    ExpectThePoseOfTheFrame(other, DepthUse::kRequired, sensor);
  }
}

// The pose is a depth camera's that took no picture.
TEST_P(TurnedPoseTest, OfADepthCameraIsRightWithoutDepthToo) {
  ExpectThePoseOfTheFrame(SomeFrame({GetParam(), true}), DepthUse::kIgnored,
                          camera::RgbdSensor::kDepth);
}

TEST_P(TurnedPoseTest, ComesWithTheFramesOwnPixels) {
  const OrientedLocalizer localizer(
      std::make_unique<FakeLocalizer>(
          [](const image::Frame& turned, const LocalizeOptions&) {
            PoseEstimate estimate = Localized(1);
            // Where the red pixel is.
            const camera::Pixel red =
                Turned({0, 0}, kWidth, kHeight, TurnOf(turned));
            const camera::Camera& camera = turned.calibration
                                               ? turned.calibration->color
                                               : camera::Camera();
            const std::optional<camera::Pixel> ray = camera.Unproject(red);
            estimate.correspondences.push_back(
                {red, Vec3{2 * ray->x, 2 * ray->y, 2}, {}, true});
            return estimate;
          },
          camera::RgbdSensor::kColor),
      true);
  image::Frame frame = SomeFrame({GetParam(), true});
  frame.calibration = localizer.info().calibration;
  const auto estimate = localizer.Localize(frame, {});
  ASSERT_TRUE(estimate.ok());
  const Correspondence& sample = estimate->correspondences.at(0);
  EXPECT_NEAR(sample.color_pixel.x, 0, kTolerance);
  EXPECT_NEAR(sample.color_pixel.y, 0, kTolerance);
  const camera::Pixel seen =
      frame.calibration->color.Project(sample.point_in_camera);
  EXPECT_NEAR(seen.x, 0, 1e-9);
  EXPECT_NEAR(seen.y, 0, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(EveryTurn, TurnedPoseTest,
                         testing::ValuesIn(image::kQuarterTurns));

}  // namespace
}  // namespace treeline::localizer
