#include "evaluation/accuracy/evaluation.h"

#include <time.h>

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::AllOf;
using ::testing::DoubleEq;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Optional;
using ::testing::SizeIs;

constexpr double kDegree = 3.14159265358979323846 / 180;

geometry::Rigid3 At(double x, double y, double z) {
  return {geometry::Rotation3{}, {x, y, z}};
}

EvaluationOptions Quiet() {
  EvaluationOptions options;
  options.quiet = true;
  return options;
}

forest::ModelInfo DepthPosedModel() {
  forest::ModelInfo info;
  info.calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return info;
}

// Time that passes only when told to.
class ManualClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override {
    absl::MutexLock lock(&mutex_);
    return now_;
  }
  void Advance_ms(double ms) {
    absl::MutexLock lock(&mutex_);
    now_ += std::chrono::duration_cast<base::MonotonicTime::duration>(
        std::chrono::duration<double, std::milli>(ms));
  }

 private:
  mutable absl::Mutex mutex_;
  base::MonotonicTime now_ ABSL_GUARDED_BY(mutex_);
};

FrameResult Localized(double translation_m, double rotation_deg) {
  FrameResult result;
  result.estimate = tools::LocalizedAt({});
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{translation_m, rotation_deg * kDegree};
  result.latency_ms = 1;
  result.decode_ms = 2;
  return result;
}

FrameResult Lost() {
  FrameResult result;
  result.true_world_from_camera = geometry::Rigid3{};
  result.latency_ms = 1;
  result.decode_ms = 2;
  return result;
}

FrameResult Failed() {
  FrameResult result;
  result.status = absl::NotFoundError("gone");
  result.true_world_from_camera = geometry::Rigid3{};
  return result;
}

TEST(Percentile, InterpolatesBetweenRanks) {
  EXPECT_THAT(Percentile({4, 1, 3, 2}, 0), Optional(DoubleEq(1)));
  EXPECT_THAT(Percentile({4, 1, 3, 2}, 50), Optional(DoubleEq(2.5)));
  EXPECT_THAT(Percentile({4, 1, 3, 2}, 100), Optional(DoubleEq(4)));
  EXPECT_THAT(Percentile({10, 20, 30}, 95), Optional(DoubleEq(29)));
  EXPECT_THAT(Percentile({7}, 99), Optional(DoubleEq(7)));
  EXPECT_EQ(Percentile({}, 50), std::nullopt);
}

TEST(Summarize, CountsErrorsAndLostFramesAsWrong) {
  const EvaluationSummary summary =
      Summarize({Localized(0.01, 1), Localized(0.04, 1), Lost(), Failed()});
  EXPECT_EQ(summary.frames, 4);
  EXPECT_EQ(summary.scored, 4);
  EXPECT_EQ(summary.localized, 2);
  EXPECT_EQ(summary.errors, 1);
  EXPECT_THAT(summary.correct_5cm_5deg, Optional(DoubleEq(0.5)));
  EXPECT_THAT(summary.correct_2cm_2deg, Optional(DoubleEq(0.25)));
}

TEST(Summarize, WantsBothPositionAndOrientationWithin) {
  const EvaluationSummary summary =
      Summarize({Localized(0.049, 4.9), Localized(0.049, 5.1),
                 Localized(0.051, 4.9), Localized(0.019, 2.1)});
  EXPECT_THAT(summary.correct_5cm_5deg, Optional(DoubleEq(0.5)));
  EXPECT_THAT(summary.correct_2cm_2deg, Optional(DoubleEq(0)));
}

TEST(CorrectShare, CountsErrorsAndLostFramesAsWrong) {
  const std::vector<FrameResult> results{Localized(0.08, 1), Localized(0.2, 1),
                                         Lost(), Failed()};
  EXPECT_THAT(CorrectShare(results, {0.1, 10}), Optional(DoubleEq(0.25)));
  EXPECT_THAT(CorrectShare(results, {0.3, 10}), Optional(DoubleEq(0.5)));
  EXPECT_THAT(CorrectShare(results, {0.3, 0.5}), Optional(DoubleEq(0)));
  EXPECT_FALSE(CorrectShare({}, {0.1, 10}).has_value());
}

TEST(Summarize, TakesMediansOverLocalizedFramesAlone) {
  const EvaluationSummary summary =
      Summarize({Localized(0.01, 1), Lost(), Localized(0.03, 2),
                 Localized(0.2, 9), Failed(), Lost()});
  EXPECT_THAT(summary.median_translation_m, Optional(DoubleEq(0.03)));
  ASSERT_TRUE(summary.median_rotation_deg.has_value());
  EXPECT_NEAR(*summary.median_rotation_deg, 2, 1e-12);
}

TEST(Summarize, LeavesFramesWithoutTruthOutOfTheScore) {
  FrameResult unknown = Localized(0, 0);
  unknown.true_world_from_camera.reset();
  unknown.error.reset();
  const EvaluationSummary summary = Summarize({Localized(0.01, 1), unknown});
  EXPECT_EQ(summary.frames, 2);
  EXPECT_EQ(summary.localized, 2);
  EXPECT_EQ(summary.scored, 1);
  EXPECT_THAT(summary.correct_5cm_5deg, Optional(DoubleEq(1)));
}

TEST(Summarize, HasNoFiguresWithoutFrames) {
  const EvaluationSummary summary = Summarize({});
  EXPECT_EQ(summary.correct_5cm_5deg, std::nullopt);
  EXPECT_EQ(summary.median_translation_m, std::nullopt);
  EXPECT_FALSE(summary.latency_ms.has_value());
  EXPECT_FALSE(summary.decode_ms.has_value());
}

TEST(Summarize, TimesOnlyFramesThatGotThere) {
  FrameResult refused = Failed();
  refused.decode_ms = 8;
  const EvaluationSummary summary = Summarize({Localized(0, 0), refused});
  EXPECT_DOUBLE_EQ(summary.latency_ms->p50, 1);
  EXPECT_DOUBLE_EQ(summary.decode_ms->p50, 5);
}

TEST(Evaluate, ComparesEachFrameWithItsOwnTruth) {
  const tools::SmallRecording recording(
      3, {At(0, 0, 0), At(1, 0, 0), At(2, 0, 0)});
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame& frame, const localizer::LocalizeOptions&) {
        const int i = tools::FrameNumber(frame);
        return tools::LocalizedAt(At(i + 0.01 * i, 0, 0));
      });
  const auto results =
      Evaluate(localizer, recording.Open(), Quiet(), base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_THAT(*results, SizeIs(3));
  for (int i = 0; i < 3; ++i) {
    const FrameResult& result = (*results)[static_cast<size_t>(i)];
    EXPECT_EQ(result.stem, "seq-01/frame-00000" + std::to_string(i));
    ASSERT_TRUE(result.error.has_value());
    EXPECT_NEAR(result.error->translation_m, 0.01 * i, 1e-12);
    EXPECT_NEAR(result.error->rotation_rad, 0, 1e-12);
  }
}

// A refused pose has its error, and the frame still counts as not localized.
TEST(Evaluate, KeepsTheErrorOfAPoseThatWasRefused) {
  const tools::SmallRecording recording(2, {At(0, 0, 0), At(1, 0, 0)});
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame& frame, const localizer::LocalizeOptions&) {
        localizer::PoseEstimate estimate;
        estimate.inliers = tools::FrameNumber(frame) == 1 ? 9 : 0;
        estimate.world_from_camera = At(1.5, 0, 0);
        return estimate;
      });
  const auto results =
      Evaluate(localizer, recording.Open(), Quiet(), base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_FALSE((*results)[0].refused_error.has_value());
  ASSERT_TRUE((*results)[1].refused_error.has_value());
  EXPECT_NEAR((*results)[1].refused_error->translation_m, 0.5, 1e-12);
  EXPECT_FALSE((*results)[1].error.has_value());
  EXPECT_EQ(Summarize(*results).localized, 0);
}

// The true pose is that of the picture as it is sent.
TEST(Evaluate, TurnsTheTruthWithThePicture) {
  const tools::SmallRecording recording(1, {At(1, 2, 3)});
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame& frame, const localizer::LocalizeOptions&) {
        EXPECT_EQ(frame.color.width, 6);
        EXPECT_EQ(frame.color.height, 8);
        EXPECT_EQ(frame.calibration->color.width(), 6);
        return tools::LocalizedAt(At(1, 2, 3));
      });
  EvaluationOptions options = Quiet();
  options.perturbation = ParsePerturbations("rotate:90").value().front();
  // The small pictures are of another size than the model's.
  options.calibration = recording.Open().calibration();
  const auto results =
      Evaluate(localizer, recording.Open(), options, base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_TRUE((*results)[0].status.ok()) << (*results)[0].status;
  const geometry::Rigid3& truth = *(*results)[0].true_world_from_camera;
  EXPECT_NEAR((*results)[0].error->translation_m, 0, 1e-12);
  EXPECT_NEAR((*results)[0].error->rotation_rad, 90 * kDegree, 1e-9);
  // What was to the right of the camera is below it in the turned picture.
  const geometry::Vec3 right_in_world =
      truth.rotation * geometry::Vec3{0, 1, 0};
  EXPECT_NEAR(right_in_world.x, 1, 1e-12);
}

TEST(Evaluate, KnowsNoTruthOfAMirroredPicture) {
  const tools::SmallRecording recording(1, {At(0, 0, 0)});
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame&, const localizer::LocalizeOptions&) {
        return tools::LocalizedAt(At(0, 0, 0));
      });
  EvaluationOptions options = Quiet();
  options.perturbation = ParsePerturbations("mirror").value().front();
  const auto results =
      Evaluate(localizer, recording.Open(), options, base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_FALSE((*results)[0].true_world_from_camera.has_value());
  EXPECT_FALSE((*results)[0].error.has_value());
  EXPECT_TRUE((*results)[0].localized());
}

TEST(Evaluate, LocalizesFramesWithoutTruthAndDoesNotScoreThem) {
  const tools::SmallRecording recording(2, {At(0, 0, 0)});
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame&, const localizer::LocalizeOptions&) {
        return tools::LocalizedAt({});
      });
  const auto results =
      Evaluate(localizer, recording.Open(), Quiet(), base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_TRUE((*results)[1].localized());
  EXPECT_FALSE((*results)[1].error.has_value());
  EXPECT_EQ(Summarize(*results).scored, 1);
}

TEST(Evaluate, NamesTheFileOfAFrameThatVanishedAndGoesOn) {
  const tools::SmallRecording recording(3, std::vector<geometry::Rigid3>(3));
  const dataset::Dataset dataset = recording.Open();
  std::filesystem::remove(recording.ColorPath(0));
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame&, const localizer::LocalizeOptions&) {
        return tools::LocalizedAt({});
      });
  const auto results =
      Evaluate(localizer, dataset, Quiet(), base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_THAT(std::string((*results)[0].status.message()),
              HasSubstr(recording.ColorPath(0)));
  EXPECT_FALSE((*results)[0].latency_ms.has_value());
  EXPECT_TRUE((*results)[1].localized());
  EXPECT_TRUE((*results)[2].localized());
}

TEST(Evaluate, NamesTheFileOfAnImageThatDoesNotDecode) {
  const tools::SmallRecording recording(2, std::vector<geometry::Rigid3>(2));
  const dataset::Dataset dataset = recording.Open();
  std::filesystem::resize_file(recording.ColorPath(1), 40);
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame&, const localizer::LocalizeOptions&) {
        return tools::LocalizedAt({});
      });
  const auto results =
      Evaluate(localizer, dataset, Quiet(), base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_TRUE((*results)[0].status.ok());
  EXPECT_THAT(std::string((*results)[1].status.message()),
              HasSubstr(recording.ColorPath(1)));
  EXPECT_FALSE((*results)[1].decode_ms.has_value());
}

TEST(Evaluate, CountsAFrameThatTheLocalizerRefusesAsAnError) {
  const tools::SmallRecording recording(2, std::vector<geometry::Rigid3>(2));
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame& frame, const localizer::LocalizeOptions&)
          -> absl::StatusOr<localizer::PoseEstimate> {
        if (tools::FrameNumber(frame) == 0) {
          return absl::InvalidArgumentError("no depth");
        }
        return tools::LocalizedAt({});
      });
  const auto results =
      Evaluate(localizer, recording.Open(), Quiet(), base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_THAT(std::string((*results)[0].status.message()),
              AllOf(HasSubstr("no depth"), HasSubstr(recording.ColorPath(0))));
  const EvaluationSummary summary = Summarize(*results);
  EXPECT_EQ(summary.errors, 1);
  EXPECT_THAT(summary.correct_5cm_5deg, Optional(DoubleEq(0.5)));
}

TEST(Evaluate, TimesTheLocalizerAlone) {
  const tools::SmallRecording recording(2, std::vector<geometry::Rigid3>(2));
  ManualClock clock;
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [&](const image::Frame& frame, const localizer::LocalizeOptions&) {
        clock.Advance_ms(7 + tools::FrameNumber(frame));
        return tools::LocalizedAt({});
      });
  const auto results = Evaluate(localizer, recording.Open(), Quiet(), clock);
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_THAT((*results)[0].latency_ms, Optional(DoubleEq(7)));
  EXPECT_THAT((*results)[1].latency_ms, Optional(DoubleEq(8)));
  EXPECT_THAT((*results)[1].decode_ms, Optional(DoubleEq(0)));
}

TEST(Evaluate, CountsProcessorTimeAndNotWaiting) {
  const tools::SmallRecording recording(2, std::vector<geometry::Rigid3>(2));
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame& frame, const localizer::LocalizeOptions&) {
        // One frame computes until 20 ms of processor time are spent, the
        // other does next to nothing.
        timespec now{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
        const double start_s = double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
        double elapsed_s = 0;
        while (tools::FrameNumber(frame) == 1 && elapsed_s < 0.02) {
          clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
          elapsed_s = double(now.tv_sec) + 1e-9 * double(now.tv_nsec) - start_s;
        }
        return tools::LocalizedAt({});
      });
  const auto results =
      Evaluate(localizer, recording.Open(), Quiet(), base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_LT(*(*results)[0].cpu_ms, 10);
  EXPECT_GE(*(*results)[1].cpu_ms, 20);
}

TEST(Evaluate, WarmsUpWithOneQueryThatIsNotCounted) {
  const tools::SmallRecording recording(3, std::vector<geometry::Rigid3>(3));
  std::atomic<int> queries{0};
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [&](const image::Frame&, const localizer::LocalizeOptions&) {
        ++queries;
        return tools::LocalizedAt({});
      });
  ASSERT_TRUE(
      Evaluate(localizer, recording.Open(), Quiet(), base::SteadyClock()).ok());
  EXPECT_EQ(queries, 4);
}

TEST(Evaluate, GivesEveryQueryTheSameSeedAndCalibration) {
  const tools::SmallRecording recording(4, std::vector<geometry::Rigid3>(4));
  camera::RgbdCalibration calibration;
  calibration.depth_scale = 1.25;
  EvaluationOptions options = Quiet();
  options.seed = 99;
  options.calibration = calibration;
  std::vector<uint64_t> seeds;
  std::vector<bool> told;
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [&](const image::Frame& frame, const localizer::LocalizeOptions& query) {
        seeds.push_back(query.seed);
        told.push_back(frame.calibration == calibration);
        return tools::LocalizedAt({});
      });
  ASSERT_TRUE(
      Evaluate(localizer, recording.Open(), options, base::SteadyClock()).ok());
  EXPECT_THAT(seeds, Each(99u));
  EXPECT_THAT(told, Each(true));
}

TEST(Evaluate, LeavesTheScenesCalibrationInPlaceByDefault) {
  const tools::SmallRecording recording(1, std::vector<geometry::Rigid3>(1));
  bool told = true;
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [&](const image::Frame& frame, const localizer::LocalizeOptions&) {
        told = frame.calibration.has_value();
        return tools::LocalizedAt({});
      });
  ASSERT_TRUE(
      Evaluate(localizer, recording.Open(), Quiet(), base::SteadyClock()).ok());
  EXPECT_FALSE(told);
}

TEST(Evaluate, GivesTheSameResultsForAnyThreadCount) {
  const std::vector<geometry::Rigid3> poses(20);
  const tools::SmallRecording recording(20, poses);
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [](const image::Frame& frame, const localizer::LocalizeOptions& query) {
        return tools::LocalizedAt(
            At(tools::FrameNumber(frame), 0.5 * double(query.seed), 0));
      });
  std::vector<std::vector<geometry::Rigid3>> answers;
  for (int threads : {1, 2, 8}) {
    EvaluationOptions options = Quiet();
    options.seed = 3;
    options.threads = threads;
    const auto results =
        Evaluate(localizer, recording.Open(), options, base::SteadyClock());
    ASSERT_TRUE(results.ok()) << results.status();
    answers.emplace_back();
    for (const FrameResult& result : *results) {
      answers.back().push_back(result.estimate.world_from_camera);
    }
  }
  EXPECT_EQ(answers[0][7], At(7, 1.5, 0));
  EXPECT_EQ(answers[1], answers[0]);
  EXPECT_EQ(answers[2], answers[0]);
}

TEST(Evaluate, StopsWhenInterrupted) {
  const tools::SmallRecording recording(10, std::vector<geometry::Rigid3>(10));
  std::stop_source source;
  std::atomic<int> queries{0};
  EvaluationOptions options = Quiet();
  options.stop = source.get_token();
  const tools::FunctionLocalizer localizer(
      DepthPosedModel(),
      [&](const image::Frame&, const localizer::LocalizeOptions&) {
        if (++queries == 4) source.request_stop();
        return tools::LocalizedAt({});
      });
  EXPECT_EQ(Evaluate(localizer, recording.Open(), options, base::SteadyClock())
                .status()
                .code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(queries, 4);
}

TEST(Evaluate, RefusesAThreadCountOutOfRange) {
  const tools::SmallRecording recording(1, {});
  const tools::FunctionLocalizer localizer(
      {}, [](const image::Frame&, const localizer::LocalizeOptions&) {
        return tools::LocalizedAt({});
      });
  EvaluationOptions options = Quiet();
  options.threads = 0;
  EXPECT_EQ(Evaluate(localizer, recording.Open(), options, base::SteadyClock())
                .status()
                .code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(Evaluate, ConvertsTheTruthToTheModelsPoseSensor) {
  // The recording's poses are of the depth camera, the model's of the colour
  // camera, which sits 10 cm to the right of it: a point of the depth frame
  // has x smaller by 0.1 there.
  const tools::SmallRecording recording(1, {At(1, 2, 3)});
  forest::ModelInfo info;
  info.calibration.pose_sensor = camera::RgbdSensor::kColor;
  info.calibration.color_from_depth.translation = {-0.1, 0, 0};
  const tools::FunctionLocalizer localizer(
      info, [](const image::Frame&, const localizer::LocalizeOptions&) {
        return tools::LocalizedAt(At(1.1, 2, 3));
      });
  const auto results =
      Evaluate(localizer, recording.Open(), Quiet(), base::SteadyClock());
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_TRUE((*results)[0].error.has_value());
  EXPECT_NEAR((*results)[0].error->translation_m, 0, 1e-12);
}

TEST(PoseOfSensor, ConvertsBothWaysWithARotationBetweenTheCameras) {
  camera::RgbdCalibration calibration;
  calibration.color_from_depth = {
      geometry::Rotation3::FromAxisAngle({0, 0, 90 * kDegree}), {0.1, 0, 0}};
  const geometry::Rigid3 world_from_color = {
      geometry::Rotation3::FromAxisAngle({0.3, 0, 0}), {5, 6, 7}};
  const geometry::Rigid3 world_from_depth =
      camera::PoseOfSensor(world_from_color, camera::RgbdSensor::kColor,
                           camera::RgbdSensor::kDepth, calibration);
  // One point, once through each camera.
  const geometry::Vec3 in_depth{1, 2, 3};
  const geometry::Vec3 in_color = calibration.color_from_depth * in_depth;
  EXPECT_NEAR(
      geometry::Norm(world_from_depth * in_depth - world_from_color * in_color),
      0, 1e-12);
  const geometry::Rigid3 back =
      camera::PoseOfSensor(world_from_depth, camera::RgbdSensor::kDepth,
                           camera::RgbdSensor::kColor, calibration);
  EXPECT_NEAR(geometry::Norm(back.translation - world_from_color.translation),
              0, 1e-12);
  EXPECT_EQ(camera::PoseOfSensor(back, camera::RgbdSensor::kColor,
                                 camera::RgbdSensor::kColor, calibration),
            back);
}

}  // namespace
}  // namespace treeline::accuracy
