#include "common/base/input_file.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::base {
namespace {

class InputFileTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = testing::TempDir() + "/input_file_test_" + std::to_string(getpid());
    Write("0123456789");
  }
  void TearDown() override { std::filesystem::remove(path_); }

  // In place: the file keeps its inode.
  void Write(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  static absl::StatusOr<std::string> Read(const InputFile& file,
                                          uint64_t offset, size_t bytes) {
    std::vector<uint8_t> buffer(bytes);
    const absl::Status status = file.ReadAt(offset, buffer);
    if (!status.ok()) return status;
    return std::string(buffer.begin(), buffer.end());
  }

  std::string path_;
};

TEST_F(InputFileTest, ReadsAtAnyPlace) {
  const auto file = InputFile::Open(path_);
  ASSERT_TRUE(file.ok()) << file.status();
  file->Prefetch();
  EXPECT_EQ(file->size(), 10u);
  EXPECT_EQ(Read(*file, 3, 4).value(), "3456");
  EXPECT_EQ(Read(*file, 0, 10).value(), "0123456789");
  EXPECT_EQ(Read(*file, 10, 0).value(), "");
}

TEST_F(InputFileTest, AFileThatGotShorterIsDataLoss) {
  const auto file = InputFile::Open(path_);
  ASSERT_TRUE(file.ok()) << file.status();
  std::filesystem::resize_file(path_, 5);
  EXPECT_EQ(Read(*file, 0, 5).value(), "01234");
  EXPECT_TRUE(absl::IsDataLoss(Read(*file, 3, 4).status()));
  EXPECT_TRUE(absl::IsDataLoss(Read(*file, 10, 1).status()));
}

TEST_F(InputFileTest, ADeletedFileCanStillBeRead) {
  const auto file = InputFile::Open(path_);
  ASSERT_TRUE(file.ok()) << file.status();
  std::filesystem::remove(path_);
  EXPECT_EQ(Read(*file, 0, 10).value(), "0123456789");
}

TEST_F(InputFileTest, AMissingFileOrAFolderIsRefused) {
  EXPECT_TRUE(absl::IsNotFound(InputFile::Open(path_ + ".none").status()));
  EXPECT_TRUE(
      absl::IsInvalidArgument(InputFile::Open(testing::TempDir()).status()));
}

}  // namespace
}  // namespace treeline::base
