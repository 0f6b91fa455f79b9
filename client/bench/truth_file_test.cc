#include "client/bench/truth_file.h"

#include <unistd.h>

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

class TruthFileTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(root_); }
  void TearDown() override { std::filesystem::remove_all(root_); }

  absl::StatusOr<std::optional<geometry::Rigid3>> Read(
      const std::string& text) const {
    EXPECT_TRUE(base::WriteFileAtomically(root_ + "/f.pose.txt", text).ok());
    return ReadTruth(root_, "f");
  }

  const std::string root_ =
      testing::TempDir() + "/truth-" + std::to_string(getpid());
};

TEST_F(TruthFileTest, ReadsTheMatrix) {
  const auto pose = Read("1 0 0 4\n0 0 -1 5\n0 1 0 6\n0 0 0 1\n");
  ASSERT_TRUE(pose.ok()) << pose.status();
  ASSERT_TRUE(pose->has_value());
  EXPECT_EQ((*pose)->translation, (geometry::Vec3{4, 5, 6}));
  const geometry::Vec3 turned = (*pose)->rotation * geometry::Vec3{0, 1, 0};
  EXPECT_NEAR(turned.z, 1, 1e-12);
}

TEST_F(TruthFileTest, NoFileAndNoPoseAreNotKnown) {
  EXPECT_EQ(ReadTruth(root_, "none").value(), std::nullopt);
  EXPECT_EQ(Read("nan nan nan nan\nnan nan nan nan\n"
                 "nan nan nan nan\nnan nan nan nan\n")
                .value(),
            std::nullopt);
}

TEST_F(TruthFileTest, SomethingElseNamesTheFile) {
  for (const char* text : {"", "1 2 3", "1 0 0 4 0 1 0 5 0 0 x 6 0 0 0 1",
                           "2 0 0 4 0 2 0 5 0 0 2 6 0 0 0 1",
                           "1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1 7"}) {
    const absl::Status status = Read(text).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(status.message()),
                testing::HasSubstr("f.pose.txt"));
  }
}

}  // namespace
}  // namespace treeline::bench
