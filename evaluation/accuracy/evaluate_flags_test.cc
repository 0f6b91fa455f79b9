#include "evaluation/accuracy/evaluate_flags.h"

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::accuracy {
namespace {

using ::testing::HasSubstr;

// Empty if the command line is good, else what is wrong with it.
std::string Parse(EvaluateFlags& flags, std::vector<std::string> arguments,
                  const std::string& dataset = "tum:test") {
  CLI::App app;
  AddEvaluateFlags(app, flags);
  arguments.insert(arguments.end(), {"--dataset", dataset});
  // CLI11 takes them from the back.
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
  return "";
}

std::string Problem(const std::vector<std::string>& arguments) {
  EvaluateFlags flags;
  return Parse(flags, arguments);
}

TEST(EvaluateFlags, AreOneModelOrOneBaselineOrAComparison) {
  EvaluateFlags model;
  EXPECT_EQ(Parse(model, {"--model", "m"}), "");
  ASSERT_EQ(model.methods.size(), 1u);
  EXPECT_EQ(model.methods[0].model_path, "m");
  EXPECT_FALSE(model.comparing());
  EvaluateFlags compared;
  EXPECT_EQ(Parse(compared, {"--compare", "rgbd,orb-pnp,x=y",
                             "--training-dataset", "tum:train"}),
            "");
  EXPECT_EQ(compared.methods.size(), 3u);
  EXPECT_TRUE(compared.comparing());
  EXPECT_THAT(Problem({}), HasSubstr("--model, --baseline or --compare"));
  EXPECT_THAT(Problem({"--model", "m", "--compare", "a=b"}),
              HasSubstr("--compare"));
  EXPECT_THAT(Problem({"--compare", "magic"}), HasSubstr("magic"));
}

TEST(EvaluateFlags, WantATrainingRecordingForWhatIsLearned) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{
           {"--baseline", "orb-pnp"},
           {"--compare", "rgbd"},
           {"--compare", "a=b,sift-pnp"},
           {"--model", "m", "--sweep", "balanced-levels=0,8"},
           {"--model", "m", "--training-frames", "f"}}) {
    EXPECT_THAT(Problem(arguments), HasSubstr("--training-dataset"));
  }
  EXPECT_EQ(Problem({"--compare", "a=b"}), "");
  EXPECT_EQ(Problem({"--model", "m", "--sweep", "trees=1..3"}), "");
}

TEST(EvaluateFlags, OfAStructureAddAThresholdThatNeedsNoUnit) {
  EvaluateFlags flags;
  EXPECT_EQ(Parse(flags, {"--model", "m"}, "colmap:a,b"), "");
  EXPECT_EQ(flags.thresholds.back(), kRelativeThreshold);
  EvaluateFlags given;
  EXPECT_EQ(
      Parse(given, {"--model", "m", "--threshold", "0.5%,2"}, "nvm:a.nvm"), "");
  EXPECT_EQ(given.thresholds.size(), 4u);
  EXPECT_NE(given.thresholds.back(), kRelativeThreshold);
}

TEST(EvaluateFlags, TakeRepeatedThresholdsForeignPicturesAndSweeps) {
  EvaluateFlags flags;
  EXPECT_EQ(
      Parse(flags, {"--model", "m", "--threshold", "1,1", "--threshold", "5,5",
                    "--foreign", "builtin,9", "--foreign", "tum:a,b.txt",
                    "--sweep", "samples=100,200", "--sweep", "trees=1..2"}),
      "");
  // 5,5 is there anyway.
  EXPECT_EQ(flags.thresholds.size(), 4u);
  EXPECT_EQ(flags.foreign.size(), 2u);
  EXPECT_EQ(flags.sweeps.size(), 2u);
  EXPECT_EQ(flags.sweep_methods.size(), 1u);
  EXPECT_THAT(Problem({"--model", "m", "--threshold", "5"}),
              HasSubstr("--threshold"));
  EXPECT_THAT(Problem({"--model", "m", "--foreign", "x"}),
              HasSubstr("--foreign"));
  EXPECT_THAT(Problem({"--model", "m", "--sweep", "x=1"}),
              HasSubstr("--sweep"));
}

TEST(EvaluateFlags, TakeAListOfPerturbations) {
  EvaluateFlags flags;
  EXPECT_EQ(Parse(flags, {"--model", "m", "--perturb", "gamma,no-depth+blur:5",
                          "--perturb-frames", "40"}),
            "");
  ASSERT_EQ(flags.perturbations.size(), 3u);
  EXPECT_EQ(flags.perturbations[2].Name(), "no-depth+blur:5");
  EXPECT_EQ(flags.perturbed_frames, 40);
  EXPECT_THAT(Problem({"--model", "m", "--perturb", "sepia"}),
              HasSubstr("sepia"));
  EXPECT_THAT(
      Problem({"--model", "m", "--perturb", "all", "--perturb-frames", "-1"}),
      HasSubstr("--perturb-frames"));
}

TEST(EvaluateFlags, SweepTheFirstForestUnlessTold) {
  EvaluateFlags flags;
  EXPECT_EQ(Parse(flags,
                  {"--compare", "sift-pnp,brf,rgbd,old=m", "--training-dataset",
                   "tum:train", "--sweep", "backtracking=1..3"}),
            "");
  ASSERT_EQ(flags.sweep_methods.size(), 1u);
  EXPECT_EQ(flags.sweep_methods[0].name, "rgbd");
  EvaluateFlags told;
  EXPECT_EQ(Parse(told, {"--compare", "rgbd,old=m", "--training-dataset",
                         "tum:train", "--sweep", "backtracking=1..3",
                         "--sweep-methods", "old,rgbd"}),
            "");
  EXPECT_EQ(told.sweep_methods.size(), 2u);
  EXPECT_THAT(Problem({"--baseline", "orb-pnp", "--training-dataset", "tum:t",
                       "--sweep", "backtracking=1..3"}),
              HasSubstr("no forest"));
  EXPECT_THAT(
      Problem({"--compare", "a=m,sift-pnp", "--training-dataset", "tum:t",
               "--sweep", "trees=1..3", "--sweep-methods", "sift-pnp"}),
      HasSubstr("sift-pnp"));
}

}  // namespace
}  // namespace treeline::accuracy
