#include "server/tools/app/import_command.h"

#include <algorithm>
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/base/testing_folder.h"
#include "common/dataset/dataset.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/testing_captures.h"

namespace treeline::tools_app {
namespace {

using testing::HasSubstr;

class ImportCommandTest : public testing::Test {
 protected:
  // treeline import CAPTURE --output OUT --quiet ARGUMENTS...
  absl::Status Import(std::vector<std::string> arguments,
                      std::stop_token stop = {}) const {
    CLI::App app("treeline");
    const cli::Command command = AddImportCommand(app);
    std::vector<std::string> all = {"import", folder_.Path("capture"),
                                    "--output", folder_.Path("out"), "--quiet"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    // CLI11 takes the arguments from the back.
    std::ranges::reverse(all);
    app.parse(all);
    EXPECT_TRUE(command.app->parsed());
    return command.run(std::move(stop));
  }

  const base::TestingFolder folder_;
};

TEST_F(ImportCommandTest, WhatItWritesIsADataset) {
  capture::WritePolycam(capture::MakeTrueScene(10), folder_.Path("capture"));
  ASSERT_EQ(Import({"--every", "2", "--max-side", "128"}), absl::OkStatus());
  const auto dataset =
      dataset::Dataset::Open({.uri = "7scenes:" + folder_.Path("out"),
                              .frame_list = folder_.Path("out/train.txt")});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->calibration().color.width(), 128);
}

// Polycam's 127 is medium.
TEST_F(ImportCommandTest, DepthOfTooLittleConfidenceIsLeftOut) {
  capture::WritePolycam(capture::MakeTrueScene(5), folder_.Path("capture"));
  ASSERT_EQ(Import({"--min-confidence", "2"}), absl::OkStatus());
  const auto dataset =
      dataset::Dataset::Open({.uri = "7scenes:" + folder_.Path("out")});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  const auto frame = dataset->Load(0);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(std::ranges::count(frame->depth->values, 0),
            static_cast<ptrdiff_t>(frame->depth->values.size()));
}

TEST_F(ImportCommandTest, WrongOptionsAreRefusedBeforeAnythingIsWritten) {
  capture::WriteStray(capture::MakeTrueScene(2), folder_.Path("capture"));
  EXPECT_THAT(Import({"--up", "north"}).message(), HasSubstr("up is 'north'"));
  EXPECT_THAT(Import({"--min-confidence", "3"}).message(),
              HasSubstr("none of 0, 1 and 2"));
  EXPECT_THAT(Import({"--every", "0"}).message(), HasSubstr("1 or more"));
  EXPECT_THAT(Import({"--depth-unit", "-1"}).message(), HasSubstr("outside"));
  EXPECT_THAT(Import({"--format", "polycam"}).message(),
              HasSubstr("no frame can be imported"));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("out")));
}

TEST_F(ImportCommandTest, ARecordingNeedsNoImport) {
  folder_.Write("capture/rgb.txt", "");
  EXPECT_THAT(Import({}).message(),
              AllOf(HasSubstr("needs no import"),
                    HasSubstr("--dataset tum:" + folder_.Path("capture"))));
}

TEST_F(ImportCommandTest, StoppingLeavesNothing) {
  capture::WriteStray(capture::MakeTrueScene(2), folder_.Path("capture"));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(Import({}, stop.get_token()).code(), absl::StatusCode::kCancelled);
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("out")));
}

}  // namespace
}  // namespace treeline::tools_app
