#include "server/core/recognition/localize_among.h"

#include <map>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::recognition {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Answers as it was told.
class FakeLocalizer final : public localizer::Localizer {
 public:
  explicit FakeLocalizer(absl::StatusOr<localizer::PoseEstimate> answer)
      : answer_(std::move(answer)) {}

  absl::StatusOr<localizer::PoseEstimate> Localize(
      const image::Frame& frame,
      const localizer::LocalizeOptions& options) const override {
    calibration = frame.calibration;
    seed = options.seed;
    return answer_;
  }
  const forest::ModelInfo& info() const override { return info_; }
  localizer::DepthUse depth_use() const override {
    return localizer::DepthUse::kIgnored;
  }

  mutable std::optional<camera::RgbdCalibration> calibration;
  mutable uint64_t seed = 0;

 private:
  const absl::StatusOr<localizer::PoseEstimate> answer_;
  const forest::ModelInfo info_;
};

localizer::PoseEstimate Answer(bool localized, double confidence) {
  localizer::PoseEstimate estimate;
  estimate.outcome = localized ? localizer::Outcome::kLocalized
                               : localizer::Outcome::kNotLocalized;
  estimate.confidence = confidence;
  estimate.inliers = static_cast<int>(100 * confidence);
  estimate.timings.total_ms = 1;
  return estimate;
}

class LocalizeAmongTest : public testing::Test {
 protected:
  // The next in the ranking.
  FakeLocalizer& Add(const std::string& scene,
                     absl::StatusOr<localizer::PoseEstimate> answer) {
    auto localizer = std::make_shared<FakeLocalizer>(std::move(answer));
    ranking_.push_back({scene, 1.0 / static_cast<double>(ranking_.size() + 1)});
    scenes_[scene] = SceneToTry{localizer, std::nullopt};
    return *localizer;
  }
  void AddMissing(const std::string& scene, const absl::Status& status) {
    ranking_.push_back({scene, 0});
    scenes_[scene] = status;
  }

  absl::StatusOr<AmongResult> Run(const AmongOptions& options = {}) {
    return LocalizeAmong(
        frame_, ranking_,
        [this](const std::string& scene) {
          acquired_.push_back(scene);
          return scenes_.at(scene);
        },
        {.seed = 7, .stop = stop_.get_token()}, options);
  }

  image::Frame frame_{};
  std::vector<SceneScore> ranking_{};
  std::map<std::string, absl::StatusOr<SceneToTry>> scenes_{};
  std::vector<std::string> acquired_{};
  std::stop_source stop_{};
};

TEST_F(LocalizeAmongTest, ASurePoseEndsTheSearch) {
  const FakeLocalizer& first = Add("a", Answer(true, 0.99));
  Add("b", Answer(true, 1));
  const auto result = Run();
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->scene, "a");
  EXPECT_EQ(result->localizer.get(), &first);
  EXPECT_EQ(result->estimate.confidence, 0.99);
  EXPECT_EQ(first.seed, 7u);
  EXPECT_THAT(acquired_, ElementsAre("a"));
  ASSERT_EQ(result->considered.size(), 2u);
  EXPECT_TRUE(result->considered[0].tried);
  EXPECT_EQ(result->considered[0].similarity, 1);
  EXPECT_EQ(result->considered[0].outcome, localizer::Outcome::kLocalized);
  EXPECT_EQ(result->considered[0].inliers, 99);
  EXPECT_EQ(result->considered[1].scene, "b");
  EXPECT_FALSE(result->considered[1].tried);
}

TEST_F(LocalizeAmongTest, WithoutASureOneTheMostConfidentOfTheTriedDecides) {
  Add("a", Answer(true, 0.6));
  Add("b", Answer(true, 0.8));
  Add("c", Answer(true, 0.7));
  Add("d", Answer(true, 1));
  const auto result = Run({.max_tried = 3, .sure_confidence = 0.9});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->scene, "b");
  EXPECT_EQ(result->estimate.timings.total_ms, 3);
  EXPECT_THAT(acquired_, ElementsAre("a", "b", "c"));
}

TEST_F(LocalizeAmongTest, LocalizedBeatsNotLocalizedAndEarlierBeatsEqual) {
  Add("a", Answer(false, 0.9));
  Add("b", Answer(true, 0.6));
  Add("c", Answer(true, 0.6));
  EXPECT_EQ(Run()->scene, "b");
}

TEST_F(LocalizeAmongTest, ConfidenceWithoutAPoseEndsNothing) {
  Add("a", Answer(false, 1));
  Add("b", Answer(false, 0.5));
  const auto result = Run();
  EXPECT_EQ(result->scene, "a");
  EXPECT_EQ(result->estimate.outcome, localizer::Outcome::kNotLocalized);
  EXPECT_TRUE(result->considered[1].tried);
}

TEST_F(LocalizeAmongTest, ScenesThatCannotBeTriedAreSkippedAndDoNotCount) {
  AddMissing("a", absl::DataLossError("corrupt"));
  Add("b", absl::InvalidArgumentError("no depth"));
  Add("c", Answer(true, 0.7));
  const auto result = Run({.max_tried = 1});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->scene, "c");
  EXPECT_EQ(result->considered[0].status.code(), absl::StatusCode::kDataLoss);
  EXPECT_FALSE(result->considered[0].tried);
  EXPECT_EQ(result->considered[1].status.code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(result->considered[1].tried);
}

TEST_F(LocalizeAmongTest, IfNoneCanBeTriedTheFirstErrorIsTheAnswer) {
  AddMissing("a", absl::FailedPreconditionError("not loaded"));
  AddMissing("b", absl::DataLossError("corrupt"));
  EXPECT_EQ(Run().status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST_F(LocalizeAmongTest, NoScenesAreNotLocalized) {
  const auto result = Run();
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->scene, "");
  EXPECT_EQ(result->localizer, nullptr);
  EXPECT_EQ(result->estimate.outcome, localizer::Outcome::kNotLocalized);
  EXPECT_THAT(result->considered, IsEmpty());
}

TEST_F(LocalizeAmongTest, EverySceneGetsItsOwnCalibration) {
  const FakeLocalizer& first = Add("a", Answer(true, 0.5));
  const FakeLocalizer& second = Add("b", Answer(true, 0.5));
  camera::RgbdCalibration calibration;
  calibration.depth_scale = 0.9;
  scenes_["a"]->calibration = calibration;
  frame_.calibration = camera::RgbdCalibration{};
  ASSERT_TRUE(Run().ok());
  EXPECT_EQ(first.calibration, calibration);
  EXPECT_EQ(second.calibration, std::nullopt);
}

TEST_F(LocalizeAmongTest, AStopBetweenScenesIsCancelled) {
  Add("a", Answer(true, 0.5));
  stop_.request_stop();
  EXPECT_EQ(Run().status().code(), absl::StatusCode::kCancelled);
  EXPECT_THAT(acquired_, IsEmpty());
}

TEST_F(LocalizeAmongTest, CancelledAndDeadlineEndEverything) {
  Add("a", Answer(true, 0.5));
  AddMissing("b", absl::DeadlineExceededError("too late"));
  EXPECT_EQ(Run().status().code(), absl::StatusCode::kDeadlineExceeded);
  scenes_["b"] = SceneToTry{
      std::make_shared<FakeLocalizer>(absl::CancelledError("stopped")),
      std::nullopt};
  EXPECT_EQ(Run().status().code(), absl::StatusCode::kCancelled);
}

TEST_F(LocalizeAmongTest, BadOptionsAreInvalid) {
  Add("a", Answer(true, 0.5));
  for (const AmongOptions& options :
       {AmongOptions{.max_tried = 0}, AmongOptions{.sure_confidence = 1.5},
        AmongOptions{.sure_confidence = std::nan("")}}) {
    EXPECT_EQ(Run(options).status().code(), absl::StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace treeline::recognition
