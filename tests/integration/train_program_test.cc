// treeline train as a process: interruptions, full disks, wrong arguments.
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "tests/integration/fixture.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;

class TrainProgram : public ServerTest {
 protected:
  std::vector<std::string> Train(
      const std::vector<std::string>& more_arguments) const {
    std::vector<std::string> argv = {
        TREELINE_PROGRAM, "train",
        "--dataset",      "7scenes:" + RecordingFolder(),
        "--frames",       RecordingFolder() + "/train.txt"};
    argv.insert(argv.end(), more_arguments.begin(), more_arguments.end());
    return argv;
  }

  // How many files lie anywhere under `folder`.
  static int FilesIn(const std::string& folder) {
    int files = 0;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(folder)) {
      files += entry.is_regular_file();
    }
    return files;
  }
};

TEST_F(TrainProgram, AnInterruptLeavesNoHalfModel) {
  const std::string output = folder_ + "/interrupted/1/model.treeline";
  Process train(Train({"--trees", "64", "--output", output}));
  // Calibration is over, and 64 trees take long.
  ASSERT_TRUE(train.WaitForLine("colour camera").has_value()) << train.err();
  train.Signal(SIGINT);
  EXPECT_EQ(train.WaitForExit(), 130);
  EXPECT_THAT(train.err(), HasSubstr("interrupted"));
  EXPECT_EQ(FilesIn(folder_ + "/interrupted"), 0);
}

TEST_F(TrainProgram, AnInterruptLeavesNoEmptyVersion) {
  const std::string repository = folder_ + "/repository";
  Process train(
      Train({"--trees", "64", "--repository", repository, "--scene", "room"}));
  ASSERT_TRUE(train.WaitForLine("colour camera").has_value()) << train.err();
  EXPECT_TRUE(std::filesystem::exists(repository + "/room/1"));
  train.Signal(SIGINT);
  EXPECT_EQ(train.WaitForExit(), 130);
  EXPECT_FALSE(std::filesystem::exists(repository + "/room"));
}

TEST_F(TrainProgram, AFullDiskLeavesTheOldModel) {
  const std::string output = PutFile("model.treeline", "the old one");
  // A limit on file sizes fails the write as a full disk does.
  std::string command = "trap '' XFSZ; ulimit -f 64; exec";
  for (const std::string& argument :
       Train({"--trees", "1", "--samples-per-frame", "100", "--calibration",
              "nominal", "--quiet", "--output", output})) {
    command += " '" + argument + "'";
  }
  const int files = FilesIn(folder_);
  const ProgramResult result = RunProgram({"/bin/bash", "-c", command});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr(output));
  EXPECT_THAT(result.err, HasSubstr("File too large"));
  EXPECT_EQ(std::filesystem::file_size(output), 11u);
  EXPECT_EQ(FilesIn(folder_), files);
}

TEST_F(TrainProgram, AnUnwritableOutputIsSaidBeforeTheWork) {
  const ProgramResult result =
      RunProgram(Train({"--output", "/proc/nowhere/model.treeline"}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("/proc/nowhere"));
  EXPECT_EQ(result.out, "") << "it calibrated first";
}

TEST_F(TrainProgram, WrongArgumentsAreNamed) {
  const std::string output = folder_ + "/model.treeline";
  const ProgramResult method =
      RunProgram(Train({"--method", "magic", "--output", output}));
  EXPECT_EQ(method.exit_code, 1);
  EXPECT_THAT(method.err, HasSubstr("magic"));
  const ProgramResult trees =
      RunProgram(Train({"--trees", "0", "--output", output}));
  EXPECT_EQ(trees.exit_code, 1);
  EXPECT_THAT(trees.err, HasSubstr("trees is 0"));
  const ProgramResult calibration = RunProgram(
      Train({"--calibration", folder_ + "/none.json", "--output", output}));
  EXPECT_EQ(calibration.exit_code, 1);
  EXPECT_THAT(calibration.err, HasSubstr("none.json"));
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{},
        {"--dataset", "7scenes:x"},
        {"--output", "x"},
        {"--dataset", "7scenes:x", "--map", "y"}}) {
    std::vector<std::string> command = {TREELINE_PROGRAM, "train"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const ProgramResult unclear = RunProgram(command);
    EXPECT_EQ(unclear.exit_code, 2);
    EXPECT_THAT(unclear.err, HasSubstr("Give --"));
  }
  const ProgramResult map =
      RunProgram({TREELINE_PROGRAM, "train", "--map", folder_ + "/nowhere",
                  "--output", output});
  EXPECT_EQ(map.exit_code, 1);
  EXPECT_THAT(map.err, HasSubstr("treeline-agent map"));
  EXPECT_FALSE(std::filesystem::exists(output));
}

}  // namespace
}  // namespace treeline
