#include "nav_agent/service/stop_file.h"

#include <unistd.h>

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::agent_service {
namespace {

using ::testing::HasSubstr;
using ::testing::Optional;

class StopFileTest : public ::testing::Test {
 protected:
  void Put(const std::string& text) const {
    std::filesystem::create_directories(folder_);
    std::filesystem::remove(folder_ + "/stop");
    ASSERT_TRUE(base::WriteNewFile(folder_ + "/stop", text).ok());
  }

  const base::TestingFolder root_;
  const std::string folder_ = root_.path() + "/a/state";
};

TEST_F(StopFileTest, IsReleasedAtFirstAndKeepsWhatIsSaid) {
  StopFile first(folder_);
  EXPECT_EQ(first.why(), std::nullopt);
  ASSERT_TRUE(first.Hold("a child\non the way").ok());
  StopFile second(folder_);
  EXPECT_THAT(second.why(), Optional(std::string("a child on the way")));
  ASSERT_TRUE(second.Hold("another").ok());
  EXPECT_THAT(StopFile(folder_).why(),
              Optional(std::string("a child on the way")));
  ASSERT_TRUE(second.Release().ok());
  EXPECT_EQ(StopFile(folder_).why(), std::nullopt);
}

TEST_F(StopFileTest, AStopWithoutAReasonIsOne) {
  StopFile file(folder_);
  ASSERT_TRUE(file.Hold("").ok());
  EXPECT_THAT(StopFile(folder_).why(), Optional(std::string()));
}

TEST_F(StopFileTest, WhatIsNotUnderstoodIsAStop) {
  const std::string whole = StopFileText("a child");
  for (size_t size = 0; size < whole.size(); ++size) {
    Put(whole.substr(0, size));
    EXPECT_THAT(StopFile(folder_).why(), Optional(HasSubstr("not known")))
        << size;
  }
  for (const std::string& text :
       {std::string("\0\0\0\0", 4), whole + "x", std::string(100000, 'x'),
        std::string("treeline-stop 2\nreleased\n\nend\n"),
        std::string("treeline-stop 1\nrunning\n\nend\n")}) {
    Put(text);
    EXPECT_THAT(StopFile(folder_).why(), Optional(HasSubstr("not known")));
  }
  // It can be released, and is so afterwards.
  StopFile file(folder_);
  ASSERT_TRUE(file.Release().ok());
  EXPECT_EQ(StopFile(folder_).why(), std::nullopt);
}

TEST_F(StopFileTest, AFolderThatCannotBeMadeIsAStop) {
  std::filesystem::create_directories(root_.path() + "/a");
  ASSERT_TRUE(base::WriteNewFile(folder_, "a file").ok());
  StopFile file(folder_);
  EXPECT_TRUE(file.why().has_value());
  EXPECT_FALSE(file.Hold("a child").ok());
}

TEST_F(StopFileTest, AFileThatCannotBeWrittenIsEmptiedAndSoAStop) {
  StopFile file(folder_);
  // Where the temporary file would be is a folder: the write fails, as on a
  // full disk, and the old file, that says "released", would stay.
  std::filesystem::create_directories(folder_ + "/stop.tmp-" +
                                      std::to_string(getpid()) + "/x");
  EXPECT_FALSE(file.Hold("a child").ok());
  EXPECT_EQ(std::filesystem::file_size(folder_ + "/stop"), 0u);
  EXPECT_TRUE(StopFile(folder_).why().has_value());
}

TEST_F(StopFileTest, WithoutAFolderAStopHoldsAndIsNotKept) {
  StopFile file;
  EXPECT_EQ(file.why(), std::nullopt);
  const absl::Status kept = file.Hold("a child");
  EXPECT_THAT(std::string(kept.message()), HasSubstr("--state-dir"));
  EXPECT_THAT(file.why(), Optional(std::string("a child")));
  EXPECT_TRUE(file.Release().ok());
  EXPECT_EQ(file.why(), std::nullopt);
}

}  // namespace
}  // namespace treeline::agent_service
