// treeline learn --live as a process: a scene that is learnt while its frames
// arrive.
#include <csignal>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/base/testing_folder.h"
#include "common/camera/calibration_json.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"
#include "tests/integration/process.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class LearnLive : public testing::Test {
 protected:
  // The box room in so many frames.
  void Record(int frames) {
    poses_ = training::BoxRoomPoses(frames);
    camera::RgbdCalibration calibration = training::BoxRoomCalibration();
    calibration.pose_sensor = camera::RgbdSensor::kDepth;
    training::WriteBoxRoomRecording(folder_.Path("recording"), calibration,
                                    poses_, training::BoxRoomWalls::kTiled);
    folder_.Write("camera.json", camera::CalibrationToJson(calibration));
  }
  std::vector<std::string> Live(
      const std::string& source,
      const std::vector<std::string>& more_arguments = {}) const {
    std::vector<std::string> argv = {
        TREELINE_PROGRAM, "learn", "--live",       source,
        "--scene",        "box",   "--repository", folder_.Path("models")};
    argv.insert(argv.end(), more_arguments.begin(), more_arguments.end());
    return argv;
  }
  // The same with what `input` prints as standard input.
  ProgramResult LiveFrom(const std::string& input,
                         const std::string& more_flags = "") const {
    const std::string command = absl::StrCat(
        input, " | \"$0\" learn --live - --scene box --rate 0",
        " --repository '", folder_.Path("models"), "' --calibration '",
        folder_.Path("camera.json"), "' ", more_flags);
    return RunProgram({"/bin/sh", "-c", command, TREELINE_PROGRAM});
  }
  // Frame i as another program would name it.
  std::string Line(int i) const {
    const std::string frame =
        folder_.Path(absl::StrFormat("recording/seq-01/frame-%06d", i));
    std::string color = frame + ".color.png";
    if (!fs::exists(color)) color = frame + ".color.jpg";
    const geometry::Rigid3& pose = poses_[static_cast<size_t>(i)];
    return absl::StrFormat(
        "%s %s.depth.png %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", color, frame,
        pose.translation.x, pose.translation.y, pose.translation.z,
        pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w);
  }
  std::string model() const {
    return folder_.Path("models/box/1/model.treeline");
  }
  void ExpectNothingIsLeft() const {
    EXPECT_FALSE(fs::exists(folder_.Path("models/box")));
  }

  const base::TestingFolder folder_;
  std::vector<geometry::Rigid3> poses_;
};

TEST_F(LearnLive, LearnsARecordingThatIsPlayed) {
  Record(130);
  const std::string recording = folder_.Path("recording");
  const ProgramResult result =
      RunProgram(Live(recording, {"--rate", "0", "--calibration",
                                  folder_.Path("camera.json")}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("models/box/1/model.treeline: complete"));
  EXPECT_THAT(result.out, HasSubstr("130 frames"));
  EXPECT_THAT(result.out, HasSubstr("0 skipped"));
  EXPECT_THAT(result.out, HasSubstr("before it learnt them"));
  // Nothing else is left beside it.
  EXPECT_EQ(std::distance(
                fs::directory_iterator(fs::path(model()).parent_path()), {}),
            1);
  // It answers.
  folder_.Write("some.txt", "seq-01/frame-000020\nseq-01/frame-000090\n");
  const ProgramResult evaluated =
      RunProgram({TREELINE_PROGRAM, "evaluate", "--model", model(), "--dataset",
                  "7scenes:" + recording, "--frames", folder_.Path("some.txt"),
                  "--color-camera", "PINHOLE,145,145,100,75", "--depth-camera",
                  "PINHOLE,145,145,100,75", "--quiet"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  EXPECT_THAT(evaluated.out, HasSubstr("within 5 cm / 5 deg      100.0 %"));
}

TEST_F(LearnLive, LearnsWhatStandardInputNames) {
  Record(30);
  std::string lines = "# COLOR DEPTH tx ty tz qx qy qz qw\n";
  for (int i = 0; i < 30; ++i) absl::StrAppend(&lines, Line(i));
  folder_.Write("lines", absl::StrCat(lines, "no frame\n", Line(0)));
  const ProgramResult result =
      LiveFrom(absl::StrCat("cat '", folder_.Path("lines"), "'"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("31 frames"));
  EXPECT_THAT(result.out, HasSubstr("Too few frames to hold some back"));
  EXPECT_THAT(result.err, HasSubstr("1 frames were left out"));
  EXPECT_THAT(result.err, HasSubstr("line 32"));
  EXPECT_TRUE(fs::exists(model()));
}

TEST_F(LearnLive, PosesThatAreMeantOtherwiseAreRefused) {
  Record(30);
  for (geometry::Rigid3& pose : poses_) pose = pose.Inverse();
  std::string lines;
  for (int i = 0; i < 30; ++i) absl::StrAppend(&lines, Line(i));
  folder_.Write("lines", lines);
  const ProgramResult result =
      LiveFrom(absl::StrCat("cat '", folder_.Path("lines"), "'"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("standard input: poses and depth"));
  EXPECT_THAT(result.err, HasSubstr("inverse"));
  ExpectNothingIsLeft();
}

// Poses that were wrong and are put right before the end, and after it.
TEST_F(LearnLive, CorrectsPoses) {
  Record(30);
  const std::vector<geometry::Rigid3> right = poses_;
  for (size_t i = 0; i < poses_.size(); ++i) {
    poses_[i].translation.x += 0.05 * static_cast<double>(i);
  }
  std::string lines;
  for (int i = 0; i < 30; ++i) absl::StrAppend(&lines, Line(i));
  poses_ = right;
  const auto correction = [this](int i) {
    std::vector<std::string> fields = absl::StrSplit(Line(i), ' ');
    fields.erase(fields.begin() + 1);
    return absl::StrCat("pose ", absl::StrJoin(fields, " "));
  };
  for (int i = 0; i < 20; ++i) absl::StrAppend(&lines, correction(i));
  absl::StrAppend(&lines, "pose nobody.jpg 0 0 0 0 0 0 1\nend\n", Line(0));
  for (int i = 20; i < 30; ++i) absl::StrAppend(&lines, correction(i));
  folder_.Write("lines", lines);
  const std::string input = absl::StrCat("cat '", folder_.Path("lines"), "'");

  const ProgramResult without = LiveFrom(input);
  ASSERT_EQ(without.exit_code, 0) << without.err;
  EXPECT_THAT(without.err, HasSubstr("31 poses were not corrected: that takes "
                                     "--corrections"));
  fs::remove_all(folder_.Path("models"));

  const ProgramResult result = LiveFrom(input, "--corrections");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("30 frames"));
  EXPECT_THAT(result.out, HasSubstr("poses of 10 frames corrected"));
  EXPECT_THAT(result.err, HasSubstr("a frame after the end of frames"));
  EXPECT_EQ(std::distance(
                fs::directory_iterator(fs::path(model()).parent_path()), {}),
            1);
  folder_.Write("some.txt",
                "seq-01/frame-000003\nseq-01/frame-000012\n"
                "seq-01/frame-000027\n");
  const ProgramResult evaluated = RunProgram(
      {TREELINE_PROGRAM, "evaluate", "--model", model(), "--dataset",
       "7scenes:" + folder_.Path("recording"), "--frames",
       folder_.Path("some.txt"), "--color-camera", "PINHOLE,145,145,100,75",
       "--depth-camera", "PINHOLE,145,145,100,75", "--quiet"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  EXPECT_THAT(evaluated.out, HasSubstr("within 5 cm / 5 deg      100.0 %"));
}

// Ctrl-C ends the frames; what was learnt stays.
TEST_F(LearnLive, AnInterruptKeepsTheModel) {
  Record(40);
  // A frame every ten seconds: it would take minutes.
  Process learn(Live(folder_.Path("recording"),
                     {"--rate", "0.1", "--publish-every", "0", "--calibration",
                      folder_.Path("camera.json")}));
  const absl::Time end = absl::Now() + kPatience;
  while (!fs::exists(model()) && absl::Now() < end) {
    absl::SleepFor(absl::Milliseconds(20));
  }
  // The model so far is whole.
  EXPECT_EQ(RunProgram({TREELINE_PROGRAM, "inspect", model()}).exit_code, 0);
  learn.Signal(SIGINT);
  EXPECT_EQ(learn.WaitForExit(), 0) << learn.err();
  EXPECT_THAT(learn.out(), HasSubstr("complete"));
  EXPECT_EQ(RunProgram({TREELINE_PROGRAM, "inspect", model()}).exit_code, 0);
}

TEST_F(LearnLive, SaysWhatToDoAndLeavesNothing) {
  Record(1);
  const ProgramResult no_cameras = RunProgram(Live("-"));
  EXPECT_EQ(no_cameras.exit_code, 1);
  EXPECT_THAT(no_cameras.err, HasSubstr("--calibration FILE"));
  ExpectNothingIsLeft();

  folder_.Write("walk.r3d", "not a recording");
  const ProgramResult capture = RunProgram(Live(folder_.Path("walk.r3d")));
  EXPECT_EQ(capture.exit_code, 1);
  EXPECT_THAT(capture.err, HasSubstr("treeline import"));
  ExpectNothingIsLeft();

  const ProgramResult nonsense = LiveFrom("echo nonsense");
  EXPECT_EQ(nonsense.exit_code, 1);
  EXPECT_THAT(nonsense.err, HasSubstr("none of 1 frames could be learnt"));
  EXPECT_THAT(nonsense.err, HasSubstr("COLOR DEPTH tx ty tz qx qy qz qw"));
  ExpectNothingIsLeft();

  const ProgramResult nothing = LiveFrom("true");
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("no frame came"));
  ExpectNothingIsLeft();

  // There is no page of it.
  const ProgramResult page =
      RunProgram(Live(folder_.Path("recording"), {"--output", "page"}));
  EXPECT_EQ(page.exit_code, 2);
}

}  // namespace
}  // namespace treeline
