// treeline learn as a process: from a phone's capture to a scene that answers.
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/testing_captures.h"
#include "server/tools/capture/testing_rtabmap.h"
#include "tests/integration/process.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class LearnProgram : public testing::Test {
 protected:
  std::vector<std::string> Learn(
      const std::string& source,
      const std::vector<std::string>& more_arguments = {},
      const std::string& trees = "2") const {
    std::vector<std::string> argv = {TREELINE_PROGRAM,
                                     "learn",
                                     source,
                                     "--scene",
                                     "box",
                                     "--repository",
                                     folder_.Path("models"),
                                     "--output",
                                     folder_.Path("learnt"),
                                     "--trees",
                                     trees};
    argv.insert(argv.end(), more_arguments.begin(), more_arguments.end());
    return argv;
  }

  // Neither a version that servers would look into, nor an output.
  void ExpectNothingIsLeft() const {
    EXPECT_FALSE(fs::exists(folder_.Path("learnt")));
    EXPECT_FALSE(fs::exists(folder_.Path("models/box")));
  }

  const base::TestingFolder folder_;
};

// The box room, filmed with a phone that has a depth camera.
TEST_F(LearnProgram, MakesASceneThatServesOfACapture) {
  capture::WriteStray(capture::MakeTrueScene(60), folder_.Path("capture"));
  const ProgramResult result = RunProgram(Learn(folder_.Path("capture")));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("[1/7] Import"));
  EXPECT_THAT(result.out, HasSubstr("60 frames of a stray capture"));
  EXPECT_THAT(result.out, HasSubstr("[7/7] Publish"));
  EXPECT_THAT(result.out, HasSubstr("learnt/page.html"));

  const auto page = base::ReadFile(folder_.Path("learnt/page.html"));
  ASSERT_TRUE(page.ok()) << page.status();
  // A camera in a patterned box is easy: nothing less is right here.
  EXPECT_THAT(*page, HasSubstr("It will work well where it was recorded."));
  EXPECT_THAT(*page, HasSubstr("colour alone"));
  EXPECT_THAT(*page, HasSubstr("class=\"plan\""));
  EXPECT_FALSE(fs::exists(folder_.Path("learnt/model.treeline")));

  // What was published answers the held-out frames, and has learnt all.
  const std::string model = folder_.Path("models/box/1/model.treeline");
  const std::string recording = folder_.Path("learnt/recording");
  const ProgramResult evaluated = RunProgram(
      {TREELINE_PROGRAM, "evaluate", "--model", model, "--dataset",
       "7scenes:" + recording, "--frames", recording + "/test.txt", "--quiet"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  EXPECT_THAT(evaluated.out, HasSubstr("localized                10"));
  const ProgramResult inspected =
      RunProgram({TREELINE_PROGRAM, "inspect", model});
  EXPECT_THAT(inspected.out, HasSubstr("universal"));
  EXPECT_THAT(inspected.out, HasSubstr("60"));

  // The next time it is the next version; the output must be another.
  const ProgramResult again = RunProgram(Learn(recording));
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.err, HasSubstr("is there already"));
  fs::rename(folder_.Path("learnt"), folder_.Path("first"));
  const ProgramResult next =
      RunProgram(Learn(folder_.Path("first/recording"), {"--only-tested"}));
  EXPECT_EQ(next.exit_code, 0) << next.err;
  EXPECT_THAT(next.out, HasSubstr("the recording's own cameras"));
  EXPECT_TRUE(fs::exists(folder_.Path("models/box/2/model.treeline")));
}

// What users of RTAB-Map have: a walk in one file, its graph optimized.
TEST_F(LearnProgram, LearnsADatabaseOfRtabMap) {
  const std::string walk = folder_.Path("walk.db");
  capture::WriteRtabmap(capture::MakeTrueScene(60), walk);
  const ProgramResult result = RunProgram(Learn(walk));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("60 frames of a rtabmap capture"));
  const std::string recording = folder_.Path("learnt/recording");
  const ProgramResult evaluated = RunProgram(
      {TREELINE_PROGRAM, "evaluate", "--model",
       folder_.Path("models/box/1/model.treeline"), "--dataset",
       "7scenes:" + recording, "--frames", recording + "/test.txt", "--quiet"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  EXPECT_THAT(evaluated.out, HasSubstr("localized                10"));
}

// What a robot recorded: keyframes with a calibration beside them.
TEST_F(LearnProgram, LearnsTheKeyframesOfAMapBundle) {
  capture::WriteStray(capture::MakeTrueScene(40), folder_.Path("capture"));
  folder_.Write("map/bundle.yaml", "name: hall\n");
  const std::string keyframes = folder_.Path("map/keyframes");
  ASSERT_EQ(RunProgram({TREELINE_PROGRAM, "import", folder_.Path("capture"),
                        "--output", keyframes, "--quiet"})
                .exit_code,
            0);
  for (const char* list : {"/train.txt", "/test.txt"}) {
    fs::remove(keyframes + list);
  }
  fs::rename(keyframes + "/cameras.json", keyframes + "/calibration.json");
  const ProgramResult result =
      RunProgram({TREELINE_PROGRAM, "learn", folder_.Path("map"), "--trees",
                  "2", "--only-tested", "--repository", folder_.Path("models"),
                  "--output", folder_.Path("learnt")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("[1/7] Open"));
  EXPECT_THAT(result.out, HasSubstr("the map's own"));
  EXPECT_TRUE(fs::exists(folder_.Path("models/hall/1/model.treeline")));
  EXPECT_TRUE(fs::exists(folder_.Path("learnt/test.txt")));
  EXPECT_TRUE(fs::exists(folder_.Path("learnt/page.html")));
}

TEST_F(LearnProgram, AnInterruptLeavesNothing) {
  capture::WriteStray(capture::MakeTrueScene(40), folder_.Path("capture"));
  Process learn(Learn(folder_.Path("capture"), {}, "64"));
  // 64 trees take long.
  ASSERT_TRUE(learn.WaitForLine("[3/7] Train").has_value()) << learn.err();
  EXPECT_TRUE(fs::exists(folder_.Path("learnt/recording/train.txt")));
  learn.Signal(SIGINT);
  EXPECT_EQ(learn.WaitForExit(), 130);
  EXPECT_THAT(learn.err(), HasSubstr("interrupted"));
  ExpectNothingIsLeft();
}

TEST_F(LearnProgram, WhatCannotBeLearntIsSaidAndLeavesNothing) {
  capture::WriteStray(capture::MakeTrueScene(12), folder_.Path("capture"));
  const ProgramResult few = RunProgram(Learn(folder_.Path("capture")));
  EXPECT_EQ(few.exit_code, 1);
  EXPECT_THAT(few.err, HasSubstr("12 frames are too few"));
  ExpectNothingIsLeft();

  const ProgramResult nowhere = RunProgram(Learn(folder_.Path("nowhere")));
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_THAT(nowhere.err, HasSubstr("there is no"));

  folder_.Write("notes/readme.txt", "hello");
  const ProgramResult unknown = RunProgram(Learn(folder_.Path("notes")));
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("none of these formats"));
  ExpectNothingIsLeft();

  // A recording whose poses are missing: the robot's program finds them.
  capture::WriteStray(capture::MakeTrueScene(20), folder_.Path("twenty"));
  ASSERT_EQ(RunProgram({TREELINE_PROGRAM, "import", folder_.Path("twenty"),
                        "--output", folder_.Path("unposed"), "--quiet"})
                .exit_code,
            0);
  for (const auto& entry :
       fs::directory_iterator(folder_.Path("unposed/seq-01"))) {
    if (entry.path().string().ends_with(".pose.txt")) fs::remove(entry.path());
  }
  const ProgramResult unposed = RunProgram(Learn(folder_.Path("unposed")));
  EXPECT_EQ(unposed.exit_code, 1);
  EXPECT_THAT(unposed.err, HasSubstr("no frame has a pose"));
  EXPECT_THAT(unposed.err, HasSubstr("treeline-agent map --rgbd"));
  ExpectNothingIsLeft();
}

TEST_F(LearnProgram, AnUnwritableRepositoryIsSaidBeforeTheWork) {
  capture::WriteStray(capture::MakeTrueScene(20), folder_.Path("capture"));
  folder_.Write("models", "a file in the way");
  const ProgramResult result = RunProgram(Learn(folder_.Path("capture")));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("models"));
  EXPECT_THAT(result.out, Not(HasSubstr("[1/7]")));
  EXPECT_FALSE(fs::exists(folder_.Path("learnt")));
}

TEST_F(LearnProgram, ANameThatNoServerKnowsIsSaidBeforeTheWork) {
  capture::WriteStray(capture::MakeTrueScene(20), folder_.Path("capture"));
  for (const char* name : {"..", "a/b", "the hall"}) {
    const ProgramResult result =
        RunProgram({TREELINE_PROGRAM, "learn", folder_.Path("capture"),
                    "--scene", name, "--repository", folder_.Path("models"),
                    "--output", folder_.Path("learnt")});
    EXPECT_EQ(result.exit_code, 1) << name;
    EXPECT_THAT(result.err, HasSubstr("--scene"));
    EXPECT_THAT(result.out, Not(HasSubstr("[1/7]")));
    ExpectNothingIsLeft();
  }
  // Nor where a map has it.
  folder_.Write("map/bundle.yaml", "name: ../../elsewhere\n");
  const ProgramResult map = RunProgram(
      {TREELINE_PROGRAM, "learn", folder_.Path("map"), "--repository",
       folder_.Path("models"), "--output", folder_.Path("learnt")});
  EXPECT_EQ(map.exit_code, 1);
  EXPECT_THAT(map.err, HasSubstr("--scene"));
  ExpectNothingIsLeft();
}

}  // namespace
}  // namespace treeline
