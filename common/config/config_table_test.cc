#include "common/config/config_table.h"

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/config/config_flags.h"
#include "common/config/testing_settings.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::config {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pair;

std::map<std::string, std::string> GivenBy(std::vector<std::string> arguments) {
  CLI::App app;
  const auto table = TestTable();
  const ConfigFlags flags(app, table.settings());
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  app.parse(arguments);
  return flags.Given();
}

TEST(ConfigTable, TakesTypesAndDefaultsFromTheStruct) {
  const auto table = TestTable();
  EXPECT_EQ(FindSetting(table.settings(), "queue")->default_value,
            ConfigValue(int64_t{64}));
  EXPECT_EQ(FindSetting(table.settings(), "drain_s")->default_value,
            ConfigValue(1.0));
}

TEST(ConfigTable, MakesTheStruct) {
  const auto table = TestTable();
  const auto config =
      ResolveConfig(table.settings(), {.flags = {{"models", "m"},
                                                 {"queue", "7"},
                                                 {"load_all", "true"},
                                                 {"cors_origin", "a,b"}}});
  ASSERT_TRUE(config.ok()) << config.status();
  const TestOptions made = table.Make(*config);
  EXPECT_EQ(made.models, "m");
  EXPECT_EQ(made.queue, 7);
  EXPECT_EQ(made.drain_s, 1);
  EXPECT_TRUE(made.load_all);
  EXPECT_THAT(made.cors_origin, ElementsAre("a", "b"));
}

TEST(ConfigTable, AnIntHoldsWhatIsAccepted) {
  struct Options {
    int number = 0;
  };
  ConfigTable<Options> table;
  table.Add(&Options::number, {.name = "number"});
  EXPECT_TRUE(ParseValue(table.settings()[0], "-2147483648").ok());
  EXPECT_FALSE(ParseValue(table.settings()[0], "2147483648").ok());
}

TEST(ConfigFlags, OnlyWhatWasGivenIsGiven) {
  EXPECT_TRUE(GivenBy({}).empty());
  EXPECT_THAT(GivenBy({"--queue", "7", "--drain-s=2"}),
              ElementsAre(Pair("drain_s", "2"), Pair("queue", "7")));
}

TEST(ConfigFlags, TheLastOneCountsAndListsAreJoined) {
  EXPECT_THAT(GivenBy({"--queue", "7", "--queue", "8"}),
              ElementsAre(Pair("queue", "8")));
  EXPECT_THAT(GivenBy({"--cors-origin", "a", "--cors-origin", "b,c"}),
              ElementsAre(Pair("cors_origin", "a,b,c")));
}

TEST(ConfigFlags, ATruthNeedsNoValueAndTakesOne) {
  EXPECT_THAT(GivenBy({"--load-all"}), ElementsAre(Pair("load_all", "true")));
  EXPECT_THAT(GivenBy({"--load-all=false"}),
              ElementsAre(Pair("load_all", "false")));
  EXPECT_THAT(GivenBy({"--load-all", "--load-all=false"}),
              ElementsAre(Pair("load_all", "false")));
}

TEST(ConfigFlags, EmptyTextsAreTexts) {
  EXPECT_THAT(GivenBy({"--models", ""}), ElementsAre(Pair("models", "")));
}

TEST(ConfigFlags, SecretsHaveNone) {
  EXPECT_THROW(GivenBy({"--password", "p"}), CLI::ParseError);
}

TEST(ConfigFlags, HelpIsMadeOfTheTable) {
  CLI::App app;
  const auto table = TestTable();
  const ConfigFlags flags(app, table.settings());
  const std::string help = app.help();
  EXPECT_THAT(help, HasSubstr("--models DIR|URL"));
  EXPECT_THAT(help, HasSubstr("Queries that may wait"));
  EXPECT_THAT(help, HasSubstr("1..100000"));
  EXPECT_THAT(help, HasSubstr("default 64"));
  EXPECT_THAT(help, Not(HasSubstr("password")));
}

}  // namespace
}  // namespace treeline::config
