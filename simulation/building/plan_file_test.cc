#include "simulation/building/plan_file.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "simulation/building/plan_generator.h"
#include "simulation/building/plan_geometry.h"
#include "simulation/building/shipped_worlds.h"

namespace treeline::building {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// Each section on a line of its own, so that lines are easy to count.
constexpr char kSmall[] =
    R"(size: [8, 6, 3]
rooms: [{name: hall, area: [0, 0, 8, 4]}, {name: store, area: [0, 4, 8, 6]}]
platforms: [{name: stage, area: [5, 0, 8, 2], height: 0.34}]
ramps: [{name: slope, from: [2, 1, 0], to: [5, 1, 0.34]}]
stairs: [{name: steps, from: [1, 3], count: 2}]
walls: [{name: screen, from: [4, 2.5], to: [4, 3.5], height: 2}]
doors: [{wall: store.south, at: 2}]
windows: [{wall: hall.east, at: 3}]
posters: [{wall: hall.west, at: 1}]
furniture: [{kind: chair, at: [1, 1]}]
movers: [{name: guest, kind: person, path: [[1, 1], [2, 3]]}]
places: [{name: start, at: [1, 2]}]
tour: [[1, 2], [2, 3], [1, 3]]
)";

std::string ErrorOf(const std::string& text) {
  return std::string(ParsePlan(text, "x.yaml").status().message());
}

// The error of the small file with `part` replaced.
std::string ErrorWith(const std::string& part, const std::string& by) {
  const std::string text = absl::StrReplaceAll(kSmall, {{part, by}});
  EXPECT_NE(text, kSmall) << part;
  return ErrorOf(text);
}

TEST(PlanFileTest, ReadsWhatIsThereAndFillsInWhatIsNot) {
  const auto plan = ParsePlan(kSmall, "x.yaml");
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_EQ(plan->rooms.size(), 2u);
  EXPECT_EQ(plan->rooms[0].height_m, 3);
  EXPECT_EQ(plan->rooms[1].walls[kNorth], "plaster");
  EXPECT_NEAR(plan->ramps[0].Slope(), 0.34 / 3, 1e-12);
  EXPECT_EQ(plan->doors[0].leaf, DoorLeaf::kNone);
  EXPECT_EQ(plan->furniture[0].width_m, 0.44);
  EXPECT_EQ(plan->tour.size(), 3u);
}

TEST(PlanFileTest, HasALightOfItsOwn) {
  EXPECT_EQ(ParsePlan(kSmall, "x.yaml")->lighting, Lighting::kDay);
  const std::string dark = absl::StrCat(kSmall, "lighting: half-lamps\n");
  const auto plan = ParsePlan(dark, "x.yaml");
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->lighting, Lighting::kHalfLamps);
  EXPECT_EQ(*ParsePlan(PlanText(*plan), "x.yaml"), *plan);
  EXPECT_THAT(ErrorOf(absl::StrCat(kSmall, "lighting: nihgt\n")),
              HasSubstr("x.yaml:14: there is no light 'nihgt'; did you mean "
                        "'night'?"));
}

TEST(PlanFileTest, GroundIsTheLowestThatIsNotBuried) {
  const auto plan = ParsePlan(kSmall, "x.yaml");
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(GroundAt(*plan, {.x_m = 1, .y_m = 3}), 0);
  EXPECT_EQ(GroundAt(*plan, {.x_m = 6, .y_m = 1}), 0.34);
  EXPECT_NEAR(GroundAt(*plan, {.x_m = 3.5, .y_m = 1}).value_or(9), 0.17, 1e-9);
  EXPECT_EQ(GroundAt(*plan, {.x_m = 6, .y_m = 1, .z_m = 0.3}), 0.34);
  EXPECT_FALSE(GroundAt(*plan, {.x_m = 6, .y_m = 1, .z_m = 2}).has_value());
  EXPECT_FALSE(GroundAt(*plan, {.x_m = 9, .y_m = 1}).has_value());
}

TEST(PlanFileTest, MistakesAreNamedWithTheirLines) {
  EXPECT_EQ(ErrorWith("count: 2", "cuont: 2"),
            "x.yaml:5: unknown key 'cuont'; did you mean 'count'?");
  EXPECT_EQ(ErrorWith("size: [8, 6, 3]", "size: [8, 6, 300]"),
            "x.yaml:1: size[2] is 300; it must be 2..200");
  EXPECT_EQ(ErrorWith("at: 2}", "at: 7.9}"),
            "x.yaml:7: the door from 7.425 to 8.375 m is not within its wall, "
            "which goes from 0 to 8 m");
  EXPECT_EQ(ErrorWith("wall: store.south", "wall: store.sout"),
            "x.yaml:7: there is no wall 'store.sout'; did you mean "
            "'store.south'?");
  EXPECT_EQ(ErrorWith("wall: store.south, at: 2", "wall: hall.west, at: 2"),
            "x.yaml:7: there is not one room behind all of this door; doors to "
            "the outside have 'leaf: closed'");
  EXPECT_EQ(ErrorWith("to: [5, 1, 0.34]", "to: [5, 1, 0]"),
            "x.yaml:4: ramp 'slope' does not rise from its beginning to its "
            "end");
  EXPECT_EQ(ErrorWith("to: [5, 1, 0.34]", "to: [5, 1]"),
            "x.yaml:4: a ramp goes from [x, y, z] to [x, y, z]");
  EXPECT_EQ(ErrorWith("kind: chair, at: [1, 1]", "kind: chair, at: [0.1, 1]"),
            "x.yaml:10: its corner at [-0.12, 0.78] is outside of all rooms");
  EXPECT_EQ(ErrorWith("kind: chair", "kind: chiar"),
            "x.yaml:10: unknown furniture 'chiar'; did you mean 'chair'?");
  EXPECT_EQ(ErrorWith("kind: chair,", "kind: chair, width: 2,"),
            "x.yaml:10: a chair has one width only: 0.44");
  EXPECT_EQ(ErrorWith("name: store,", "name: hall,"),
            "x.yaml:2: something is called 'hall' already");
  EXPECT_EQ(ErrorWith("name: slope", "name: stage"),
            "x.yaml:4: something is called 'stage' already");
  EXPECT_EQ(ErrorWith("area: [0, 4, 8, 6]", "area: [0, 3, 8, 6]"),
            "x.yaml:2: room 'store' overlaps 'hall'");
  EXPECT_EQ(ErrorWith("height: 0.34}", "height: 3.2}"),
            "x.yaml:3: its top at 3.2 m is above the building, which is 3 m "
            "high");
  EXPECT_EQ(ErrorWith("at: [1, 2]}]", "at: [1, 2, 1]}]"),
            "x.yaml:12: there is no ground at [1, 2, 1]");
  EXPECT_EQ(ErrorWith("at: [1, 2]}]", "at: [1, 7]}]"),
            "x.yaml:12: 7 m is outside the building, which ends at 6 m");
  EXPECT_EQ(ErrorWith("{wall: hall.east, at: 3}",
                      "{wall: hall.east, at: 3}, {wall: hall.east, at: 2.4}"),
            "x.yaml:8: it overlaps a window at 3 m");
  EXPECT_EQ(ErrorWith("wall: hall.west, at: 1", "wall: screen, at: 0.5"),
            "x.yaml:9: a poster hangs on 'screen.left' or '.right'");
  EXPECT_EQ(ErrorWith("[[1, 2], [2, 3], [1, 3]]", "[[1, 2], [2, 3]]"),
            "x.yaml:1: a 'tour' of at least 3 corners is missing");
  EXPECT_EQ(ErrorWith("[{name: start, at: [1, 2]}]", "[]"),
            "x.yaml:1: there are no places; a robot must start somewhere");
  EXPECT_THAT(
      ErrorWith("area: [0, 0, 8, 4]}", "area: [0, 0, 8, 4], floor: lava}"),
      StartsWith("x.yaml:2: unknown finish 'lava'"));
}

TEST(PlanFileTest, ThereMayNotBeTooManyThings) {
  std::string chairs;
  for (int i = 0; i < 501; ++i) absl::StrAppend(&chairs, "  - {}\n");
  EXPECT_EQ(ErrorWith("furniture: [{kind: chair, at: [1, 1]}]",
                      absl::StrCat("furniture:\n", chairs)),
            "x.yaml:511: more than 500 in 'furniture'");
}

TEST(PlanFileTest, ADoorIsInBothRoomsOfItsWall) {
  // The same place from the other room, and another one beyond its edge.
  EXPECT_EQ(
      ErrorWith("{wall: store.south, at: 2}",
                "{wall: store.south, at: 2}, {wall: hall.north, at: 2.5}"),
      "x.yaml:7: it overlaps a door at 2 m");
}

TEST(PlanFileTest, ShippedWorldsAreReadAndWrittenAlike) {
  ASSERT_EQ(ShippedWorlds().size(), 4u);
  for (const ShippedWorld& shipped : ShippedWorlds()) {
    const auto plan = ParsePlan(shipped.text, shipped.name);
    ASSERT_TRUE(plan.ok()) << plan.status();
    const auto again = ParsePlan(PlanText(*plan), "again");
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_TRUE(*plan == *again) << shipped.name;
  }
}

TEST(PlanFileTest, DrawnBuildingsAreReadAndWrittenAlike) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    const BuildingPlan plan = DrawPlan(seed, 0);
    const auto again = ParsePlan(PlanText(plan), "again");
    ASSERT_TRUE(again.ok()) << seed << ": " << again.status();
    EXPECT_TRUE(plan == *again) << seed;
  }
}

TEST(PlanFileTest, TheExampleOnThePageIsAWorld) {
  const auto page = base::ReadFile(TREELINE_WORLD_FILES_PAGE, 1 << 20);
  ASSERT_TRUE(page.ok()) << page.status();
  const size_t begin = page->find("```yaml\n");
  ASSERT_NE(begin, std::string::npos);
  const size_t end = page->find("```", begin + 8);
  const auto plan =
      ParsePlan(page->substr(begin + 8, end - begin - 8), "example");
  EXPECT_TRUE(plan.ok()) << plan.status();
  EXPECT_THAT(*page, HasSubstr("office_chair"));
}

}  // namespace
}  // namespace treeline::building
