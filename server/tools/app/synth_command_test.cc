#include "server/tools/app/synth_command.h"

#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/dataset/dataset.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::tools_app {
namespace {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

class SynthCommandTest : public ::testing::Test {
 protected:
  SynthCommandTest()
      : folder_(fs::temp_directory_path() /
                absl::StrCat("treeline-synth-", getpid(), "-",
                             ::testing::UnitTest::GetInstance()
                                 ->current_test_info()
                                 ->name())) {
    fs::remove_all(folder_);
  }
  ~SynthCommandTest() override { fs::remove_all(folder_); }

  // treeline synth record --output FOLDER --quiet ARGUMENTS...
  absl::Status Record(std::vector<std::string> arguments,
                      std::stop_token stop = {}) {
    CLI::App app("treeline");
    const cli::Command command = AddSynthCommand(app);
    std::vector<std::string> all = {"synth", "record", "--quiet", "--output",
                                    folder_.string()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    // CLI11 takes the arguments from the back.
    std::reverse(all.begin(), all.end());
    app.parse(all);
    EXPECT_TRUE(command.app->parsed());
    return command.run(std::move(stop));
  }

  const fs::path folder_;
};

TEST_F(SynthCommandTest, WhatItRecordsIsADataset) {
  ASSERT_EQ(Record({"--world", "room", "--frames", "6", "--seed", "5"}),
            absl::OkStatus());
  dataset::DatasetOptions options = {.uri = "7scenes:" + folder_.string()};
  const auto all = dataset::Dataset::Open(options);
  ASSERT_TRUE(all.ok()) << all.status();
  ASSERT_EQ(all->size(), 6);
  for (int i = 0; i < all->size(); ++i) {
    ASSERT_TRUE(all->frame(i).world_from_camera.has_value());
    const auto frame = all->Load(i);
    ASSERT_TRUE(frame.ok()) << frame.status();
    ASSERT_TRUE(frame->depth.has_value());
    // The room is 5 m long: most of it is within the camera's range.
    const auto& values = frame->depth->values;
    EXPECT_GT(std::count_if(values.begin(), values.end(), image::IsMeasured),
              640 * 480 / 2);
  }
  // 1/30 s apart: the camera moved, but not by more than 5 cm.
  const double step_m =
      geometry::Norm(all->frame(1).world_from_camera->translation -
                     all->frame(0).world_from_camera->translation);
  EXPECT_GT(step_m, 1e-4);
  EXPECT_LT(step_m, 0.05);

  options.frame_list = (folder_ / "train.txt").string();
  const auto train = dataset::Dataset::Open(options);
  options.frame_list = (folder_ / "test.txt").string();
  const auto test = dataset::Dataset::Open(options);
  ASSERT_TRUE(train.ok()) << train.status();
  ASSERT_TRUE(test.ok()) << test.status();
  EXPECT_EQ(train->size(), 4);  // 0, 1, 2, then 5 of the next cycle
  EXPECT_EQ(test->size(), 1);
  EXPECT_EQ(test->frame(0).stem, "seq-01/frame-000004");
}

TEST_F(SynthCommandTest, AnInterruptLeavesNothingBehind) {
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(Record({"--frames", "6"}, source.get_token()).code(),
            absl::StatusCode::kCancelled);
  EXPECT_TRUE(!fs::exists(folder_) || fs::is_empty(folder_));
}

TEST_F(SynthCommandTest, DoesNotRecordOverARecording) {
  fs::create_directories(folder_ / "seq-01");
  const absl::Status status = Record({"--frames", "6"});
  EXPECT_EQ(status.code(), absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(status.message(), HasSubstr("seq-01 is there already"));
}

TEST_F(SynthCommandTest, NamesWhatIsWrong) {
  EXPECT_THAT(Record({"--world", "moon"}).message(), HasSubstr("'moon'"));
  EXPECT_THAT(Record({"--world", "room:x"}).message(), HasSubstr("'room:x'"));
  EXPECT_THAT(Record({"--frames", "4"}).message(), HasSubstr("4 frames"));
  EXPECT_THROW(Record({"--format", "video"}).IgnoreError(),
               CLI::ValidationError);
}

}  // namespace
}  // namespace treeline::tools_app
