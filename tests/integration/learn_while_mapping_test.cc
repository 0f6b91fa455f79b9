// treeline-agent map --live --learn as a process: the place's scene is there
// while the robot still maps, and in the map's own poses when it has ended.
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/integration/process.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class LearnWhileMapping : public testing::Test {
 protected:
  std::vector<std::string> Map(
      const std::vector<std::string>& more_arguments) const {
    std::vector<std::string> argv = {
        TREELINE_AGENT, "map",    "--live",   "--simulate",        "cafe",
        "--learn",      models(), "--output", folder_.Path("cafe")};
    argv.insert(argv.end(), more_arguments.begin(), more_arguments.end());
    return argv;
  }
  std::string models() const { return folder_.Path("models"); }
  std::string model() const {
    return folder_.Path("models/cafe/1/model.treeline");
  }

  const base::TestingFolder folder_;
};

// Ctrl-C ends the drive.
TEST_F(LearnWhileMapping, TheSceneIsThereMeanwhileAndInTheEnd) {
  Process map(Map(
      {"--camera", "simulated", "--pace", "4", "--learner", TREELINE_PROGRAM}));
  const absl::Time end = absl::Now() + kPatience;
  const auto frames_wait = [this] {
    return base::SortedNamesIn(folder_.Path("cafe/learning")).size() > 80;
  };
  while (!(fs::exists(model()) && frames_wait()) && map.IsRunning() &&
         absl::Now() < end) {
    absl::SleepFor(absl::Milliseconds(20));
  }
  ASSERT_TRUE(map.IsRunning()) << map.err();
  EXPECT_EQ(RunProgram({TREELINE_PROGRAM, "inspect", model()}).exit_code, 0);
  map.Signal(SIGINT);
  ASSERT_EQ(map.WaitForExit(), 0) << map.err();
  EXPECT_THAT(map.out(), HasSubstr("Written to"));
  EXPECT_THAT(map.err(), HasSubstr("model.treeline: complete"));
  EXPECT_THAT(map.err(), HasSubstr(" skipped"));
  EXPECT_THAT(map.err(), Not(HasSubstr("warning")));
  EXPECT_FALSE(fs::exists(folder_.Path("cafe/learning")));
  // It is a scene of this map.
  folder_.Write("some.txt",
                "seq-01/frame-000003\nseq-01/frame-000015\n"
                "seq-01/frame-000027\n");
  const ProgramResult evaluated =
      RunProgram({TREELINE_PROGRAM, "evaluate", "--model", model(), "--dataset",
                  absl::StrCat("7scenes:", folder_.Path("cafe/keyframes")),
                  "--frames", folder_.Path("some.txt"), "--calibration",
                  folder_.Path("cafe/keyframes/calibration.json"), "--quiet"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  EXPECT_THAT(evaluated.out, HasSubstr("within 5 cm / 5 deg      100.0 %"));
}

TEST_F(LearnWhileMapping, AMapIsMadeWithoutTheLearner) {
  folder_.Write("learner", "#!/bin/sh\necho the disk is full\nexit 1\n");
  fs::permissions(folder_.Path("learner"), fs::perms::owner_all);
  const ProgramResult result =
      RunProgram(Map({"--camera", "simulated", "--pace", "20", "--seconds", "8",
                      "--learner", folder_.Path("learner")}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("The scene is learnt no further"));
  EXPECT_THAT(result.err, HasSubstr("the disk is full"));
  EXPECT_THAT(result.out, HasSubstr("Written to"));
}

TEST_F(LearnWhileMapping, SaysThatItNeedsACamera) {
  const ProgramResult result = RunProgram(Map({}));
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err,
              HasSubstr("--learn and --server are for --live with a camera"));
}

TEST_F(LearnWhileMapping, CalibratesADriveThatIsRecordedAlone) {
  const ProgramResult result = RunProgram(Map({"--calibrate"}));
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("--robot and --calibrate are for --log"));
}

}  // namespace
}  // namespace treeline
