#include "evaluation/accuracy/method_runner.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/camera/calibration_json.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A room of which every other frame is for training.
class MethodRunnerTest : public ::testing::Test {
 protected:
  MethodRunnerTest() {
    const std::string room = folder_ / "room";
    training::WriteBoxRoomRecording(room, training::BoxRoomCalibration(),
                                    training::BoxRoomPoses(24));
    std::ofstream training(folder_ / "train.txt");
    std::ofstream test(folder_ / "test.txt");
    const dataset::Dataset all =
        dataset::Dataset::Open(tools::BoxRoomOptions(room)).value();
    for (int i = 0; i < all.size(); ++i) {
      (i % 4 == 1 ? test : training) << all.frame(i).stem << "\n";
    }
    flags_.dataset = flags_.training = tools::BoxRoomOptions(room);
    flags_.dataset.frame_list = folder_ / "test.txt";
    flags_.training.frame_list = folder_ / "train.txt";
    flags_.calibration_path = folder_ / "calibration.json";
    std::ofstream(flags_.calibration_path)
        << camera::CalibrationToJson(training::BoxRoomCalibration());
    flags_.models_folder = folder_ / "models";
    flags_.quiet = true;
  }

  void Compare(const std::string& methods) {
    flags_.compare_text = methods;
    flags_.methods = ParseMethods(methods).value();
    flags_.thresholds = StandardThresholds();
  }

  const tools::TestFolder folder_;
  EvaluateFlags flags_;
};

TEST_F(MethodRunnerTest, ComparesForestsAblationsAndBaselines) {
  Compare("rgbd,brf,orb-pnp,none=/no/such/model");
  flags_.sweeps = {*ParseSweep("backtracking=1,4"), *ParseSweep("trees=1,2")};
  flags_.sweep_methods = {flags_.methods[0]};
  flags_.foreign = {*ParseForeignSource("builtin,8")};
  flags_.report_path = folder_ / "report.html";
  auto runner = MethodRunner::Open(flags_, {});
  ASSERT_TRUE(runner.ok()) << runner.status();
  const auto methods = runner->EvaluateMethods();
  ASSERT_TRUE(methods.ok()) << methods.status();
  ASSERT_EQ(methods->size(), 4u);
  const EvaluatedMethod& rgbd = (*methods)[0];
  ASSERT_TRUE(rgbd.status.ok()) << rgbd.status;
  EXPECT_EQ(rgbd.results.size(), 6u);
  EXPECT_FALSE(rgbd.scene_errors_m.empty());
  EXPECT_FALSE(rgbd.splits.empty());
  EXPECT_FALSE(rgbd.pictures.empty());
  EXPECT_FALSE(rgbd.heat_maps.empty());
  EXPECT_EQ(rgbd.training_poses.size(), 18u);
  EXPECT_EQ(rgbd.foreign.size(), 2u);
  EXPECT_GT(rgbd.peak_memory_bytes, 0u);
  // The ablation asks the same model.
  EXPECT_EQ((*methods)[1].model.checksum, rgbd.model.checksum);
  EXPECT_EQ((*methods)[2].model.method, "orb-pnp");
  EXPECT_TRUE((*methods)[2].status.ok()) << (*methods)[2].status;
  EXPECT_EQ((*methods)[3].status.code(), absl::StatusCode::kNotFound);

  std::vector<std::string> problems;
  const auto sweeps = runner->RunSweeps(*methods, problems);
  ASSERT_TRUE(sweeps.ok()) << sweeps.status();
  EXPECT_THAT(problems, IsEmpty());
  ASSERT_EQ(sweeps->size(), 2u);
  EXPECT_EQ((*sweeps)[0].lines[0].points.size(), 2u);
  EXPECT_EQ((*sweeps)[1].lines[0].points[0].value, 1);
  EXPECT_LT((*sweeps)[1].lines[0].points[0].model_bytes,
            (*sweeps)[1].lines[0].points[1].model_bytes);
}

TEST_F(MethodRunnerTest, AsksAboutChangedFramesToo) {
  Compare("orb-pnp");
  flags_.perturbations = ParsePerturbations("rotate:180,exposure:0").value();
  flags_.perturbed_frames = 3;
  auto runner = MethodRunner::Open(flags_, {});
  ASSERT_TRUE(runner.ok()) << runner.status();
  const auto methods = runner->EvaluateMethods();
  ASSERT_TRUE(methods.ok()) << methods.status();
  const EvaluatedMethod& method = methods->front();
  ASSERT_TRUE(method.status.ok()) << method.status;
  ASSERT_EQ(method.perturbed.size(), 3u);
  EXPECT_EQ(method.perturbed[0].perturbation.Name(), "as it is");
  for (const PerturbedResults& perturbed : method.perturbed) {
    ASSERT_EQ(perturbed.results.size(), 3u);
  }
  // The first, third and fifth of six.
  EXPECT_EQ(method.perturbed[0].results[1].stem, method.results[2].stem);
  EXPECT_EQ(Summarize(method.perturbed[0].results).correct_5cm_5deg,
            Summarize(method.perturbed[1].results).correct_5cm_5deg)
      << "ORB does not mind which side is up";
  EXPECT_GT(Summarize(method.perturbed[0].results).localized, 0);
  EXPECT_EQ(Summarize(method.perturbed[2].results).localized, 0)
      << "a black picture shows nothing";
}

TEST_F(MethodRunnerTest, NamesFramesThatVanishAndGoesOn) {
  Compare("orb-pnp");
  auto runner = MethodRunner::Open(flags_, {});
  ASSERT_TRUE(runner.ok()) << runner.status();
  const dataset::Dataset test = dataset::Dataset::Open(flags_.dataset).value();
  std::filesystem::remove(test.frame(3).color_path);
  const auto methods = runner->EvaluateMethods();
  ASSERT_TRUE(methods.ok()) << methods.status();
  const EvaluatedMethod& method = methods->front();
  ASSERT_TRUE(method.status.ok()) << method.status;
  EXPECT_EQ(Summarize(method.results).errors, 1);
  EXPECT_THAT(std::string(method.results[3].status.message()),
              HasSubstr(test.frame(3).color_path));
}

TEST_F(MethodRunnerTest, SaysWhichLineOfASweepFailed) {
  Compare("none=/no/such/model");
  flags_.sweeps = {*ParseSweep("backtracking=1,4")};
  flags_.sweep_methods = flags_.methods;
  auto runner = MethodRunner::Open(flags_, {});
  ASSERT_TRUE(runner.ok()) << runner.status();
  const auto methods = runner->EvaluateMethods();
  ASSERT_TRUE(methods.ok()) << methods.status();
  std::vector<std::string> problems;
  const auto sweeps = runner->RunSweeps(*methods, problems);
  ASSERT_TRUE(sweeps.ok()) << sweeps.status();
  EXPECT_THAT(*sweeps, IsEmpty());
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_THAT(problems[0], HasSubstr("sweep of backtracking, none"));
}

TEST_F(MethodRunnerTest, RefusesForeignRecordingsThatAreNotThereAtOnce) {
  Compare("orb-pnp");
  flags_.foreign = {*ParseForeignSource("tum:/no/such/folder")};
  EXPECT_EQ(MethodRunner::Open(flags_, {}).status().code(),
            absl::StatusCode::kNotFound);
}

TEST_F(MethodRunnerTest, StopsWhenInterruptedAndLeavesNoModel) {
  Compare("rgbd");
  std::stop_source source;
  source.request_stop();
  auto runner = MethodRunner::Open(flags_, source.get_token());
  ASSERT_TRUE(runner.ok()) << runner.status();
  EXPECT_EQ(runner->EvaluateMethods().status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "models"));
}

}  // namespace
}  // namespace treeline::accuracy
