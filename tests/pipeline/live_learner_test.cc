// A scene that is learnt frame by frame, and what it answers meanwhile.
#include "server/core/training/live_learner.h"

#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/localizer/localizer.h"
#include "server/core/recognition/scene_descriptor.h"
#include "server/core/training/box_room_recording.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;
using training::LiveLearner;

camera::RgbdCalibration Calibration() {
  camera::RgbdCalibration calibration = training::BoxRoomCalibration();
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return calibration;
}

class LiveLearnerTest : public testing::Test {
 protected:
  // Until the end of the second block of frames that are learnt, and a few
  // more: then what was held back between the two has been asked about.
  static constexpr int kFrames = 125;

  static std::unique_ptr<LiveLearner> Create(int threads = 2,
                                             std::string memory_folder = "") {
    auto learner = LiveLearner::Create(
        TREELINE_BASE_MODEL, Calibration(),
        {.threads = threads, .memory_folder = std::move(memory_folder)});
    EXPECT_TRUE(learner.ok()) << learner.status();
    return *std::move(learner);
  }
  static image::Frame View(const geometry::Rigid3& pose) {
    return training::RenderBoxRoom(Calibration(), pose,
                                   training::BoxRoomWalls::kTiled);
  }
  // The first `count` frames of a loop of kFrames; returns how many were asked
  // about.
  int Teach(LiveLearner& learner, int count) const {
    const std::vector<geometry::Rigid3> poses = training::BoxRoomPoses(kFrames);
    int asked = 0;
    for (int i = 0; i < count; ++i) {
      const geometry::Rigid3& pose = poses[static_cast<size_t>(i)];
      auto trials = learner.Add("frame", View(pose), pose);
      EXPECT_TRUE(trials.ok()) << trials.status();
      if (!*trials) continue;
      auto outcomes = (*trials)->Run(folder_.Path("live"), 0, {});
      EXPECT_TRUE(outcomes.ok()) << outcomes.status();
      for (auto& of_frame : *outcomes) {
        learner.AddTrials(std::move(of_frame));
        ++asked;
      }
    }
    return asked;
  }
  // Of 12 views between those learnt, those placed within 5 cm and 5 degrees.
  // Wrong answers are failures unless there may be some.
  static int CountRight(const std::string& path, bool with_depth,
                        bool may_be_wrong = false) {
    const auto localizer = localizer::OpenLocalizer(path);
    EXPECT_TRUE(localizer.ok()) << localizer.status();
    const std::vector<geometry::Rigid3> poses =
        training::BoxRoomPoses(2 * kFrames);
    int right = 0;
    for (int i = 0; i < 12; ++i) {
      const geometry::Rigid3& depth_pose =
          poses[static_cast<size_t>(20 * i + 1)];
      image::Frame frame = View(depth_pose);
      if (!with_depth) frame.depth.reset();
      const auto estimate = (*localizer)->Localize(frame, {});
      EXPECT_TRUE(estimate.ok()) << estimate.status();
      if (estimate->outcome != localizer::Outcome::kLocalized) continue;
      const geometry::PoseError error = geometry::ErrorBetween(
          estimate->world_from_camera,
          camera::PoseOfSensor(depth_pose, camera::RgbdSensor::kDepth,
                               camera::RgbdSensor::kColor, Calibration()));
      if (!may_be_wrong) {
        EXPECT_LT(error.translation_m, 0.1) << "a wrong pose passed for right";
      }
      right += error.translation_m < 0.05 && error.rotation_rad < 0.087;
    }
    return right;
  }

  const base::TestingFolder folder_;
};

TEST_F(LiveLearnerTest, AnswersMeanwhileAndAtTheEnd) {
  const std::unique_ptr<LiveLearner> learner = Create();
  // One in five of 20 that are held back.
  EXPECT_EQ(Teach(*learner, kFrames), 4);
  const auto model = learner->Finish();
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->info.training_frames, kFrames);
  EXPECT_EQ(model->info.method, "universal");
  // With depth and without.
  EXPECT_EQ(model->asked, 8);
  EXPECT_GE(model->right, 7);
  EXPECT_EQ(model->wrong, 0);
  const std::string path = folder_.Path("live");
  ASSERT_TRUE(model->Write(path).ok());
  EXPECT_GE(CountRight(path, true), 11);
  EXPECT_GE(CountRight(path, false), 11);
  const auto descriptor = recognition::ReadSceneDescriptor(path);
  ASSERT_TRUE(descriptor.ok()) << descriptor.status();
  EXPECT_EQ(descriptor->images(), kFrames);
}

TEST_F(LiveLearnerTest, ModelSoFarLeavesOutWhatIsHeldBack) {
  const std::unique_ptr<LiveLearner> learner = Create();
  // 40 are learnt, and 12 more wait.
  Teach(*learner, 52);
  const auto so_far = learner->Model();
  const auto all = learner->Finish();
  ASSERT_TRUE(so_far.ok() && all.ok());
  EXPECT_LT(so_far->forest.payloads.size(), all->forest.payloads.size());
  EXPECT_LT(so_far->keyframes.size(), all->keyframes.size());
  // Nothing was asked: its confidence is that of other scenes, and careful.
  EXPECT_EQ(all->asked, 0);
  ASSERT_TRUE(all->info.confidence.has_value());
  EXPECT_EQ(all->info.confidence->weights,
            forest::ConfidenceModel::Typical().weights);
  EXPECT_GE(all->info.confidence->threshold, 0.5);
}

TEST_F(LiveLearnerTest, DoesNotDependOnThreads) {
  const auto bytes = [&](int threads) {
    const std::unique_ptr<LiveLearner> learner = Create(threads);
    Teach(*learner, 12);
    const auto model = learner->Finish();
    EXPECT_TRUE(model.ok()) << model.status();
    EXPECT_TRUE(model->Write(folder_.Path("model")).ok());
    return base::ReadFile(folder_.Path("model")).value();
  };
  EXPECT_TRUE(bytes(1) == bytes(3));
}

// As if SLAM had been off by more and more until it closed a loop.
TEST_F(LiveLearnerTest, CorrectedPosesGiveWhatRightOnesGive) {
  constexpr int kTaught = 50;  // some are held back
  const std::vector<geometry::Rigid3> poses = training::BoxRoomPoses(kFrames);
  const std::string memory = folder_.Path("");
  const auto teach = [&](LiveLearner& learner, double drift_m) {
    for (int i = 0; i < kTaught; ++i) {
      const geometry::Rigid3& pose = poses[static_cast<size_t>(i)];
      geometry::Rigid3 estimated = pose;
      estimated.translation.x += drift_m * i;
      ASSERT_TRUE(learner.Add("frame", View(pose), estimated).ok());
    }
  };
  const auto write = [&](absl::StatusOr<training::LiveModel> model,
                         const std::string& name) {
    ASSERT_TRUE(model.ok()) << model.status();
    ASSERT_TRUE(model->Write(folder_.Path(name)).ok());
  };
  const std::unique_ptr<LiveLearner> right = Create();
  teach(*right, 0);
  const auto right_model = right->Finish();
  write(right_model, "right");

  const std::unique_ptr<LiveLearner> drifted = Create(2, memory);
  teach(*drifted, 0.02);
  const auto correct = [&](int first, int end) {
    for (int i = first; i < end; ++i) {
      ASSERT_TRUE(drifted->Correct(i, poses[static_cast<size_t>(i)]).ok());
    }
  };
  write(drifted->Model(), "drifted");
  EXPECT_LT(CountRight(folder_.Path("drifted"), true, /*may_be_wrong=*/true),
            CountRight(folder_.Path("right"), true));
  // What is held back is corrected, too; and some of it at the end.
  correct(0, 45);
  EXPECT_TRUE(drifted->Model().ok());
  EXPECT_TRUE(drifted->Finish().ok());
  correct(45, kTaught);
  const auto corrected = drifted->Model();
  ASSERT_TRUE(corrected.ok()) << corrected.status();
  // To the bit.
  EXPECT_EQ(corrected->forest.payloads.size(),
            right_model->forest.payloads.size());
  EXPECT_EQ(std::memcmp(corrected->forest.payloads.data(),
                        right_model->forest.payloads.data(),
                        corrected->forest.payloads.size() *
                            sizeof(corrected->forest.payloads[0])),
            0);
  write(corrected, "corrected");
  EXPECT_EQ(CountRight(folder_.Path("corrected"), true),
            CountRight(folder_.Path("right"), true));
  EXPECT_EQ(CountRight(folder_.Path("corrected"), false),
            CountRight(folder_.Path("right"), false));
  EXPECT_TRUE(absl::IsOutOfRange(drifted->Correct(kTaught, {})));
  EXPECT_TRUE(absl::IsFailedPrecondition(right->Correct(0, {})));
}

// It learns on, and says why poses stay as they are.
TEST_F(LiveLearnerTest, WithoutRoomForSamplesPosesStay) {
  const std::unique_ptr<LiveLearner> learner = Create(2, folder_.Path(""));
  const geometry::Rigid3 pose = training::BoxRoomPoses(kFrames)[0];
  ASSERT_TRUE(learner->Add("first", View(pose), pose).ok());
  ASSERT_TRUE(learner->Correct(0, pose).ok());
  {
    // Files may have no more than that frame's samples.
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small{.rlim_cur = 500'000, .rlim_max = limit.rlim_max};
    std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    const auto added = learner->Add("second", View(pose), pose);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    ASSERT_TRUE(added.ok()) << added.status();
  }
  EXPECT_THAT(learner->Correct(0, pose).message(),
              HasSubstr("poses cannot be corrected any more"));
  EXPECT_TRUE(learner->Add("third", View(pose), pose).ok());
  const auto model = learner->Finish();
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->info.training_frames, 3);
}

TEST_F(LiveLearnerTest, SaysWhatIsWrongWithAFrameAndGoesOn) {
  const std::unique_ptr<LiveLearner> learner = Create();
  const geometry::Rigid3 pose = training::BoxRoomPoses(kFrames)[0];
  EXPECT_THAT(learner->Finish().status().message(), HasSubstr("usable depth"));
  image::Frame frame = View(pose);
  frame.depth.reset();
  EXPECT_THAT(learner->Add("without", frame, pose).status().message(),
              HasSubstr("without depth"));
  frame = View(pose);
  frame.color.width /= 2;
  EXPECT_THAT(learner->Add("narrow", frame, pose).status().message(),
              HasSubstr("narrow: colour 100 x 150"));
  // Depth in which nothing was measured is no error: the next may have some.
  frame = View(pose);
  for (uint16_t& value : frame.depth->values) value = 0;
  EXPECT_TRUE(learner->Add("blind", frame, pose).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(learner->Model().status()));
  EXPECT_TRUE(learner->Add("good", View(pose), pose).ok());
  EXPECT_EQ(learner->frames(), 2);
  EXPECT_TRUE(learner->Finish().ok());
}

TEST_F(LiveLearnerTest, RefusesBasesOfOtherKinds) {
  const auto learner =
      LiveLearner::Create(TREELINE_RGB_BASE_MODEL, Calibration(), {});
  EXPECT_TRUE(absl::IsInvalidArgument(learner.status()));
  EXPECT_THAT(learner.status().message(), HasSubstr("method rgb"));
  EXPECT_TRUE(absl::IsNotFound(
      LiveLearner::Create(folder_.Path("nowhere"), Calibration(), {})
          .status()));
}

}  // namespace
}  // namespace treeline
