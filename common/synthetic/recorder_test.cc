#include "common/synthetic/recorder.h"

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <map>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/synthetic/testing_world.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

class RecorderTest : public ::testing::Test {
 protected:
  RecorderTest()
      : folder_(fs::temp_directory_path() /
                absl::StrCat("treeline-recorder-", getpid(), "-",
                             ::testing::UnitTest::GetInstance()
                                 ->current_test_info()
                                 ->name())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~RecorderTest() override { fs::remove_all(folder_); }

  RecordOptions Options(const char* name) const {
    RecordOptions options;
    options.folder = (folder_ / name).string();
    options.frames = 5;
    return options;
  }

  std::map<std::string, std::string> Contents(const char* name) const {
    std::map<std::string, std::string> contents;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / name)) {
      if (!entry.is_regular_file()) continue;
      contents[fs::relative(entry.path(), folder_ / name).string()] =
          *ReadFile(entry.path().string());
    }
    return contents;
  }

  const fs::path folder_;
};

TEST_F(RecorderTest, SameSeedSameBytesOnOneAndTwoThreads) {
  RecordOptions options = Options("one");
  options.threads = 1;
  std::atomic<int> done = 0;
  ASSERT_EQ(RecordWorld(options, [&] { ++done; }, {}), absl::OkStatus());
  EXPECT_EQ(done, 5);
  options.folder = Options("two").folder;
  options.threads = 2;
  ASSERT_EQ(RecordWorld(options, {}, {}), absl::OkStatus());

  const auto one = Contents("one");
  EXPECT_EQ(one.size(), 3u * 5 + 3);
  EXPECT_EQ(one, Contents("two"));
  EXPECT_THAT(one.at("recording.txt"), HasSubstr("world room\n"));
  EXPECT_THAT(one.at("recording.txt"),
              HasSubstr("color_from_depth 1 0 0 0 -0.025 0 0\n"));
  EXPECT_EQ(one.at("train.txt"),
            "seq-01/frame-000000\nseq-01/frame-000001\nseq-01/frame-000002\n");
  EXPECT_EQ(one.at("test.txt"), "seq-01/frame-000004\n");
}

TEST_F(RecorderTest, StoppingLeavesNothing) {
  std::stop_source source;
  // After the first frame.
  EXPECT_EQ(RecordIn(
                TestingWorld(), Options("stopped"),
                [&] { source.request_stop(); }, source.get_token())
                .code(),
            absl::StatusCode::kCancelled);
  EXPECT_TRUE(Contents("stopped").empty());
  EXPECT_FALSE(fs::exists(folder_ / "stopped" / "seq-01"));
}

TEST_F(RecorderTest, DoesNotRecordOverARecording) {
  ASSERT_EQ(RecordIn(TestingWorld(), Options("once"), {}, {}),
            absl::OkStatus());
  const auto before = Contents("once");
  EXPECT_EQ(RecordIn(TestingWorld(), Options("once"), {}, {}).code(),
            absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(Contents("once"), before);
}

TEST_F(RecorderTest, AFolderThatCannotBeMadeIsNamed) {
  ASSERT_EQ(WriteFileAtomically((folder_ / "file").string(), "x"),
            absl::OkStatus());
  const absl::Status status =
      RecordIn(TestingWorld(), Options("file/below"), {}, {});
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(status.message(), HasSubstr("file/below"));
}

TEST_F(RecorderTest, OptionsAreChecked) {
  const auto error = [&](auto change) {
    RecordOptions options = Options("bad");
    change(options);
    const absl::Status status = RecordWorld(options, {}, {});
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_FALSE(fs::exists(folder_ / "bad" / "seq-01"));
    return std::string(status.message());
  };
  EXPECT_THAT(error([](auto& o) { o.frames = 4; }), HasSubstr("4 frames"));
  EXPECT_THAT(error([](auto& o) { o.folder = ""; }), HasSubstr("no folder"));
  EXPECT_THAT(error([](auto& o) { o.rate_hz = 0; }), HasSubstr("0 Hz"));
  EXPECT_THAT(error([](auto& o) { o.jpeg_quality = 0; }),
              HasSubstr("JPEG quality"));
  EXPECT_THAT(error([](auto& o) { o.world = "moon"; }), HasSubstr("'moon'"));
}

}  // namespace
}  // namespace treeline
