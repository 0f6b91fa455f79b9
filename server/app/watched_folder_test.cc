#include "server/app/watched_folder.h"

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::server_app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(WatchedFolderTest, TellsOfMisplacedModelsOnceWhenTheyAppear) {
  const base::TestingFolder folder;
  folder.Write("models/lab/1/model.treeline", "x");
  std::vector<std::string> told;
  WatchedFolder watched(folder.Path("models"),
                        [&](const std::string& path) { told.push_back(path); });
  ASSERT_TRUE(watched.List().ok());
  EXPECT_THAT(told, IsEmpty());

  folder.Write("models/first floor/1/model.treeline", "x");
  const auto listed = watched.List();
  ASSERT_TRUE(listed.ok()) << listed.status();
  EXPECT_EQ(listed->models.size(), 1);
  EXPECT_THAT(told, ElementsAre("first floor/1/model.treeline"));
  ASSERT_TRUE(watched.List().ok());
  EXPECT_EQ(told.size(), 1);

  // It went, and came again.
  std::filesystem::remove_all(folder.Path("models/first floor"));
  ASSERT_TRUE(watched.List().ok());
  folder.Write("models/first floor/1/model.treeline", "x");
  ASSERT_TRUE(watched.List().ok());
  EXPECT_EQ(told.size(), 2);
}

}  // namespace
}  // namespace treeline::server_app
