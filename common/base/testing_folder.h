// A folder of a test's own, for tests alone.
#ifndef COMMON_BASE_TESTING_FOLDER_H_
#define COMMON_BASE_TESTING_FOLDER_H_

#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "common/base/file.h"
#include "gtest/gtest.h"

namespace treeline::base {

// Empty at first, and removed with all that is in it. No two tests share one,
// nor do two processes that run the same test.
class TestingFolder {
 public:
  TestingFolder() : path_(absl::StrCat(::testing::TempDir(), Name())) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TestingFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TestingFolder(const TestingFolder&) = delete;
  TestingFolder& operator=(const TestingFolder&) = delete;

  const std::string& path() const { return path_; }
  // What `name` is called from outside.
  std::string Path(const std::string& name) const {
    return absl::StrCat(path_, "/", name);
  }
  // Writes a file, and the folders that it lies in; returns its path.
  std::string Write(const std::string& name, absl::string_view contents) const {
    std::string path = Path(name);
    EXPECT_TRUE(MakeParentFolder(path).ok()) << path;
    EXPECT_TRUE(WriteFileAtomically(path, contents).ok()) << path;
    return path;
  }

 private:
  static std::string Name() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    // Names of tests with parameters have slashes.
    return absl::StrReplaceAll(
        absl::StrCat("treeline-", getpid(), "-", test->test_suite_name(), "-",
                     test->name()),
        {{"/", "-"}});
  }

  const std::string path_;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_TESTING_FOLDER_H_
