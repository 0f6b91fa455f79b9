#include "server/tools/training_place.h"

#include <unistd.h>

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "gtest/gtest.h"

namespace treeline::tools {
namespace {

class TrainingPlaceTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  const std::string folder_ =
      testing::TempDir() + "/training-place-" + std::to_string(getpid());
};

TEST_F(TrainingPlaceTest, AModelBecomesTheNextVersion) {
  const auto first = NextModelPath(folder_, "attic");
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(*first, folder_ + "/attic/1/model.treeline");
  std::filesystem::create_directories(folder_ + "/attic/12");
  std::filesystem::create_directories(folder_ + "/attic/notes");
  EXPECT_EQ(*NextModelPath(folder_, "attic"),
            folder_ + "/attic/13/model.treeline");
  EXPECT_FALSE(NextModelPath(folder_, "").ok());
  EXPECT_FALSE(NextModelPath(folder_, "../attic").ok());
  // Servers know no such scenes, and ".." is not even in the repository.
  for (const char* name : {"..", ".attic", "the attic", "attic\n"}) {
    EXPECT_FALSE(NextModelPath(folder_, name).ok()) << name;
  }
}

TEST_F(TrainingPlaceTest, AMapBundleNamesItsScene) {
  EXPECT_EQ(SceneOfMapBundle(folder_).status().code(),
            absl::StatusCode::kNotFound);
  ASSERT_TRUE(
      base::WriteFileAtomically(folder_ + "/bundle.yaml", "name: attic\n")
          .ok());
  EXPECT_EQ(*SceneOfMapBundle(folder_), "attic");
  ASSERT_TRUE(
      base::WriteFileAtomically(folder_ + "/bundle.yaml", "scene: x\n").ok());
  EXPECT_EQ(SceneOfMapBundle(folder_).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::tools
