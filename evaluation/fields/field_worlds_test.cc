#include "evaluation/fields/field_worlds.h"

#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::fields {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(FieldWorlds, AFolderIsItsWorldsInTheOrderOfTheirNumbers) {
  const base::TestingFolder folder;
  for (const char* file :
       {"world_10.world", "world_2.world", "a.yaml", "world_2.txt", "b.sdf"}) {
    folder.Write(file, "");
  }
  const auto worlds = WorldsCalled(folder.path());
  ASSERT_TRUE(worlds.ok()) << worlds.status();
  EXPECT_THAT(*worlds, ElementsAre(folder.Path("a.yaml"), folder.Path("b.sdf"),
                                   folder.Path("world_2.world"),
                                   folder.Path("world_10.world")));
}

TEST(FieldWorlds, OtherNamesStandForThemselves) {
  EXPECT_THAT(*WorldsCalled("cafe"), ElementsAre("cafe"));
  EXPECT_THAT(*WorldsCalled("none/x.world"), ElementsAre("none/x.world"));
  const base::TestingFolder folder;
  EXPECT_THAT(std::string(WorldsCalled(folder.path()).status().message()),
              HasSubstr("there is no file of a world"));
}

}  // namespace
}  // namespace treeline::fields
