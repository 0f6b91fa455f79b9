#include "nav_agent/service/zone_book.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "nav_agent/service/testing_navigator.h"

namespace treeline::agent_service {
namespace {

using ::testing::HasSubstr;

// On the lower of the two levels of TwoLevelMap.
zones::Zone Box(const std::string& name) {
  return {
      .name = name,
      .kind = zones::ZoneKind::kKeepOut,
      .level = 0,
      .corners_in_map = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}};
}

class ZoneBookTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::unique_ptr<ZoneBook>> Open() const {
    return ZoneBook::Open(TwoLevelMap(),
                          {.masks = {}, .folder = folder_.path()});
  }
  std::string path() const { return folder_.Path("zones"); }
  // What the robot was told last.
  ZoneBook::Apply Tell() {
    return [this](const std::shared_ptr<const zones::ZoneMap>& zones) {
      if (answer_.ok()) told_ = zones;
      return answer_;
    };
  }

  const base::TestingFolder folder_;
  absl::Status answer_;
  std::shared_ptr<const zones::ZoneMap> told_;
};

TEST_F(ZoneBookTest, ARestartFindsWhatWasDrawn) {
  auto book = Open();
  ASSERT_TRUE(book.ok()) << book.status();
  EXPECT_TRUE((*book)->keeping().ok());
  EXPECT_TRUE((*book)->contents().map->empty());
  auto put = (*book)->Put({Box("a"), Box("b")}, Tell());
  ASSERT_TRUE(put.ok()) << put.status();
  EXPECT_EQ(put->revision, 2U);
  EXPECT_TRUE(told_->IsKeptOut(0, geometry::Vec2{0, 0}));
  zones::Zone moved = Box("a");
  moved.level = 1;
  ASSERT_TRUE((*book)->Put({moved}, Tell()).ok());
  ASSERT_TRUE((*book)->Remove({"b"}, Tell()).ok());
  EXPECT_FALSE(told_->IsKeptOut(0, geometry::Vec2{0, 0}));
  const auto again = Open();
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ((*again)->contents().zones, std::vector<zones::Zone>{moved});
  EXPECT_TRUE((*again)->contents().map->IsKeptOut(1, geometry::Vec2{0, 0}));
}

TEST_F(ZoneBookTest, ADamagedFileIsAnErrorThatSaysWhatToDo) {
  ASSERT_TRUE((*Open())->Put({Box("a")}, Tell()).ok());
  const std::string whole = *base::ReadFile(path());
  for (const std::string& damaged :
       {std::string(), whole.substr(0, whole.size() / 2), whole + "x",
        std::string("\0\xff", 2)}) {
    ASSERT_TRUE(base::WriteFileAtomically(path(), damaged).ok());
    const absl::Status status = Open().status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
    EXPECT_THAT(status.message(), HasSubstr(path()));
    EXPECT_THAT(status.message(), HasSubstr("remove the file"));
    // It is left as it was, for whoever mends it.
    EXPECT_EQ(*base::ReadFile(path()), damaged);
  }
}

TEST_F(ZoneBookTest, ZonesOfAnotherMapAreAnError) {
  zones::Zone far = Box("far");
  ASSERT_TRUE((*Open())->Put({far}, Tell()).ok());
  auto small = std::make_shared<behavior::NavigatorMap>(*TwoLevelMap());
  for (traversability::TraversableLevel& level : small->levels.levels) {
    level.grid.map_from_grid.translation = {100, 100};
  }
  const absl::Status status =
      ZoneBook::Open(small, {.masks = {}, .folder = folder_.path()}).status();
  EXPECT_THAT(status.message(), HasSubstr("'far' lies beside the map"));
  EXPECT_THAT(status.message(), HasSubstr("are they of another map?"));
}

TEST_F(ZoneBookTest, WhatCannotBeKeptIsNotPut) {
  const auto book = *Open();
  ASSERT_TRUE(book->Put({Box("a")}, Tell()).ok());
  const auto before = told_;
  // A full disk, as far as files are concerned: the new one cannot be made.
  std::filesystem::create_directories(
      absl::StrCat(path(), ".tmp-", ::getpid(), "/in-the-way"));
  const absl::Status status = book->Put({Box("b")}, Tell()).status();
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(status.message(), HasSubstr("the zones stay as they were"));
  EXPECT_EQ(told_, before);
  EXPECT_EQ(book->contents().zones.size(), 1U);
  EXPECT_EQ(book->revision(), 2U);
  EXPECT_EQ((*Open())->contents().zones.size(), 1U);
}

TEST_F(ZoneBookTest, WhatTheRobotDoesNotTakeIsNotKept) {
  const auto book = *Open();
  ASSERT_TRUE(book->Put({Box("a")}, Tell()).ok());
  answer_ = absl::DeadlineExceededError("no step took it");
  EXPECT_EQ(book->Put({Box("b")}, Tell()).status(), answer_);
  EXPECT_EQ(book->Remove({"a"}, Tell()).status(), answer_);
  EXPECT_EQ(book->contents().zones.size(), 1U);
  EXPECT_EQ((*Open())->contents().zones.size(), 1U);
}

TEST_F(ZoneBookTest, AllOrNothing) {
  const auto book = *Open();
  zones::Zone bad = Box("bad");
  bad.corners_in_map.resize(2);
  EXPECT_THAT(book->Put({Box("a"), bad}, Tell()).status().message(),
              HasSubstr("zone 'bad' has 2 corners"));
  EXPECT_THAT(book->Put({Box("a"), Box("a")}, Tell()).status().message(),
              HasSubstr("two zones are called 'a'"));
  ASSERT_TRUE(book->Put({Box("a")}, Tell()).ok());
  EXPECT_TRUE(absl::IsNotFound(book->Remove({"a", "gone"}, Tell()).status()));
  EXPECT_EQ(book->contents().zones.size(), 1U);
}

TEST_F(ZoneBookTest, WithoutAFolderNothingIsKept) {
  ZoneBook book(TwoLevelMap());
  ASSERT_TRUE(book.Put({Box("a")}, Tell()).ok());
  EXPECT_THAT(book.keeping().message(), HasSubstr("without --state-dir"));
}

TEST_F(ZoneBookTest, AMaskIsSaidInRuns) {
  core::ValueGrid values = {.width = 8,
                            .height = 6,
                            .resolution_m = 0.5,
                            .map_from_grid = {{-1, -1}, 0},
                            .values = std::vector<uint8_t>(48, 0)};
  for (const size_t cell : {0, 1, 3, 9, 47}) values.values[cell] = 100;
  zones::ZoneMask mask;
  mask.name = "mask.yaml";
  mask.values = std::make_shared<const core::ValueGrid>(values);
  const auto book =
      *ZoneBook::Open(TwoLevelMap(), {.masks = {mask}, .folder = ""});
  EXPECT_EQ(book->RunsOf(mask),
            (std::vector<int32_t>{0, 0, 2, 0, 3, 4, 1, 1, 2, 5, 7, 8}));
}

}  // namespace
}  // namespace treeline::agent_service
