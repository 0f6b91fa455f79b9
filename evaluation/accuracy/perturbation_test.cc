#include "evaluation/accuracy/perturbation.h"

#include <set>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::accuracy {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> Names(absl::string_view text) {
  std::vector<std::string> names;
  const auto perturbations = ParsePerturbations(text);
  EXPECT_TRUE(perturbations.ok()) << perturbations.status();
  for (const Perturbation& perturbation : *perturbations) {
    names.push_back(perturbation.Name());
  }
  return names;
}

Perturbation Only(absl::string_view text) {
  return ParsePerturbations(text).value().front();
}

image::Frame SomeFrame() {
  const camera::RgbdCalibration calibration = training::BoxRoomCalibration();
  image::Frame frame = training::RenderBoxRoom(calibration, {});
  frame.calibration = calibration;
  return frame;
}

std::string Problem(absl::string_view text) {
  const auto perturbations = ParsePerturbations(text);
  EXPECT_EQ(perturbations.status().code(), absl::StatusCode::kInvalidArgument)
      << text;
  return std::string(perturbations.status().message());
}

TEST(ParsePerturbations, TakesKindsStrengthsAndTheirChains) {
  EXPECT_THAT(Names("gamma"), ElementsAre("gamma:0.5", "gamma:2"));
  EXPECT_THAT(Names("gamma:1.5,blur:20"), ElementsAre("gamma:1.5", "blur:20"));
  EXPECT_THAT(Names("mirror"), ElementsAre("mirror"));
  EXPECT_THAT(Names("no-depth+gamma"),
              ElementsAre("no-depth+gamma:0.5", "no-depth+gamma:2"));
  EXPECT_THAT(Names("gamma,gamma:2,gamma:3"),
              ElementsAre("gamma:0.5", "gamma:2", "gamma:3"));
}

TEST(ParsePerturbations, AllIsEveryKindAtItsUsualStrengths) {
  std::set<std::string> kinds;
  const auto all = ParsePerturbations("all");
  ASSERT_TRUE(all.ok()) << all.status();
  for (const Perturbation& perturbation : *all) {
    ASSERT_EQ(perturbation.steps.size(), 1u);
    kinds.insert(perturbation.steps[0].kind->name);
  }
  EXPECT_EQ(kinds.size(), PerturbationKinds().size());
  EXPECT_EQ(Names("no-depth+all").size(), Names("all").size());
}

// What every name says is what it was parsed from.
TEST(ParsePerturbations, ReadsTheNamesItGives) {
  for (const std::string& name : Names("all,no-depth+rotate+cover")) {
    EXPECT_THAT(Names(name), ElementsAre(name));
  }
}

TEST(ParsePerturbations, SaysWhatIsWrong) {
  EXPECT_THAT(Problem("sepia"), HasSubstr("grey, white-balance"));
  EXPECT_THAT(Problem(""), HasSubstr("all or one of"));
  EXPECT_THAT(Problem("gamma,"), HasSubstr("all or one of"));
  EXPECT_THAT(Problem("gamma:x"), HasSubstr("KIND:STRENGTH"));
  EXPECT_THAT(Problem("gamma:1:2"), HasSubstr("KIND:STRENGTH"));
  EXPECT_THAT(Problem("gamma:0"), HasSubstr("[0.05, 20]"));
  EXPECT_THAT(Problem("gamma:nan"), HasSubstr("[0.05, 20]"));
  EXPECT_THAT(Problem("mirror:1"), HasSubstr("no strength"));
  EXPECT_THAT(Problem("rotate:45"), HasSubstr("roll"));
  EXPECT_THAT(Problem("all+all"), HasSubstr("too many"));
}

TEST(Perturbation, KnowsWhenNoPlaceIsShown) {
  EXPECT_TRUE(Only("mirror").is_foreign());
  EXPECT_TRUE(Only("no-depth+mirror").is_foreign());
  EXPECT_FALSE(Only("rotate:90").is_foreign());
  EXPECT_FALSE(Perturbation().is_foreign());
  EXPECT_EQ(Perturbation().Name(), "as it is");
}

TEST(Perturb, WorksWithEveryKindAtItsUsualStrengths) {
  const image::Frame frame = SomeFrame();
  const auto all = ParsePerturbations("all");
  ASSERT_TRUE(all.ok()) << all.status();
  for (const Perturbation& perturbation : *all) {
    const auto perturbed = Perturb(perturbation, frame, 0, "f");
    ASSERT_TRUE(perturbed.ok())
        << perturbation.Name() << ": " << perturbed.status();
    const image::Frame& result = perturbed->frame;
    ASSERT_TRUE(result.calibration.has_value());
    EXPECT_EQ(result.calibration->color.width(), result.color.width);
    EXPECT_EQ(result.calibration->color.height(), result.color.height);
    if (result.depth) {
      EXPECT_EQ(result.calibration->depth.width(), result.depth->width);
      EXPECT_EQ(result.calibration->depth.height(), result.depth->height);
    }
    EXPECT_TRUE(result.color.rgb != frame.color.rgb || !result.depth ||
                result.depth->values != frame.depth->values ||
                result.calibration != frame.calibration)
        << perturbation.Name() << " changes nothing";
  }
}

TEST(Perturb, DependsOnSeedAndFrameAlone) {
  const image::Frame frame = SomeFrame();
  const auto rgb = [&](const char* text, uint64_t seed, const char* name) {
    return Perturb(Only(text), frame, seed, name)->frame.color.rgb;
  };
  EXPECT_EQ(rgb("cover", 1, "a"), rgb("cover", 1, "a"));
  EXPECT_NE(rgb("cover", 1, "a"), rgb("cover", 2, "a"));
  EXPECT_NE(rgb("cover", 1, "a"), rgb("cover", 1, "b"));
  // What comes before a step does not change its draws.
  EXPECT_EQ(rgb("depth-holes:0.3+cover:0.2", 1, "a"), rgb("cover:0.2", 1, "a"));
}

TEST(Perturb, WantsACalibration) {
  image::Frame frame = SomeFrame();
  frame.calibration.reset();
  EXPECT_EQ(Perturb(Only("crop"), frame, 0, "f").status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(PerturbationHelp, NamesEveryKind) {
  for (const PerturbationKind& kind : PerturbationKinds()) {
    EXPECT_THAT(PerturbationHelp(), HasSubstr(kind.name));
  }
}

}  // namespace
}  // namespace treeline::accuracy
