#include "nav_agent/recording/wean_map.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::recording {
namespace {

using testing::HasSubstr;

TEST(WeanMap, RowsRunAlongXAndHighNumbersAreFree) {
  const absl::StatusOr<core::OccupancyGrid> map = ParseWeanMap(
      "robot_specifications->resolution     20\n\nglobal_map[0]: 3 2\n"
      "-1.0 0.0 \n0.95 0.5 \n1.0 -1.0\n",
      "m");
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->width, 3);
  EXPECT_EQ(map->height, 2);
  EXPECT_DOUBLE_EQ(map->resolution_m, 0.2);
  EXPECT_EQ(map->At({0, 0}), core::Occupancy::kUnknown);
  EXPECT_EQ(map->At({0, 1}), core::Occupancy::kOccupied);
  EXPECT_EQ(map->At({1, 0}), core::Occupancy::kFree);
  EXPECT_EQ(map->At({1, 1}), core::Occupancy::kUnknown);
  EXPECT_EQ(map->At({2, 0}), core::Occupancy::kFree);
}

TEST(WeanMap, SaysWhatIsWrong) {
  const auto error = [](absl::string_view text) {
    return std::string(ParseWeanMap(text, "m").status().message());
  };
  EXPECT_EQ(error("nothing\n"), "m: there is no line 'global_map[0]:'");
  EXPECT_THAT(error("global_map[0]: 100 100\n1 1\n"), HasSubstr("its size"));
  EXPECT_THAT(error("global_map[0]: -1 2\n1 1\n"), HasSubstr("its size"));
  EXPECT_EQ(error("global_map[0]: 1 2\n1 x\n"),
            "m: cell 0, 1 is missing or not in -1..1");
  EXPECT_EQ(error("global_map[0]: 1 2\n1    \n"),
            "m: cell 0, 1 is missing or not in -1..1");
  EXPECT_THAT(error("robot_specifications->resolution 0\n"),
              HasSubstr("resolution"));
}

}  // namespace
}  // namespace treeline::recording
