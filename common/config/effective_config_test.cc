#include "common/config/effective_config.h"

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "common/config/testing_settings.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::config {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kPrefix[] = "TREELINE_TEST_";

class EffectiveConfigTest : public testing::Test {
 protected:
  EffectiveConfigTest()
      : path_(testing::TempDir() + "/effective-config-" +
              testing::UnitTest::GetInstance()->current_test_info()->name() +
              ".yaml") {
    sources_.environment_prefix = kPrefix;
  }
  ~EffectiveConfigTest() override { std::remove(path_.c_str()); }

  void PutFile(const std::string& text) {
    std::ofstream(path_) << text;
    sources_.file = path_;
  }
  auto Resolve() const { return ResolveConfig(settings_, sources_); }
  std::string Error() const {
    const auto config = Resolve();
    EXPECT_TRUE(absl::IsInvalidArgument(config.status()));
    return std::string(config.status().message());
  }

  const std::vector<Setting> settings_ = TestTable().settings();
  const std::string path_;
  ConfigSources sources_;
};

TEST_F(EffectiveConfigTest, FlagsBeatTheEnvironmentBeatsTheFileBeatsDefaults) {
  PutFile("models: file\nqueue: 2\ndrain_s: 2\n");
  sources_.environment = {{"TREELINE_TEST_QUEUE", "3"},
                          {"TREELINE_TEST_DRAIN_S", "3"}};
  sources_.flags = {{"drain_s", "4"}};
  const auto config = Resolve();
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->at("log_level").origin, "default");
  EXPECT_EQ(config->at("models").origin, path_ + ":1");
  EXPECT_EQ(config->at("queue").value, ConfigValue(int64_t{3}));
  EXPECT_EQ(config->at("queue").origin, "environment TREELINE_TEST_QUEUE");
  EXPECT_EQ(config->at("drain_s").value, ConfigValue(4.0));
  EXPECT_EQ(config->at("drain_s").origin, "flag --drain-s");
}

TEST_F(EffectiveConfigTest, ErrorsNameTheSource) {
  sources_.flags = {{"models", "m"}, {"queue", "x"}};
  EXPECT_EQ(Error(), "flag --queue: queue: 'x' is not a whole number");
  sources_.environment = {{"TREELINE_TEST_QUEUE", "y"}};
  EXPECT_EQ(Error(),
            "environment TREELINE_TEST_QUEUE: queue: 'y' is not a whole "
            "number");
  PutFile("queue: z\n");
  EXPECT_EQ(Error(), path_ + ":1: queue: 'z' is not a whole number");
}

TEST_F(EffectiveConfigTest, WhatIsRequiredMustBeGiven) {
  EXPECT_EQ(Error(),
            "models must be given: --models, 'models' in the file, or "
            "TREELINE_TEST_MODELS");
}

TEST_F(EffectiveConfigTest, TheEnvironmentIsFilteredByPrefix) {
  const char* const environment[] = {"PATH=/bin", "TREELINE_TEST_QUEUE=3=4",
                                     "TREELINE_TESTQUEUE=1", "broken", nullptr};
  EXPECT_THAT(EnvironmentWith(environment, kPrefix),
              ElementsAre(testing::Pair("TREELINE_TEST_QUEUE", "3=4")));
}

TEST_F(EffectiveConfigTest, UnknownVariablesAreReportedNotRefused) {
  sources_.flags = {{"models", "m"}};
  sources_.environment = {{"TREELINE_TEST_QEUE", "3"},
                          {"TREELINE_TEST_QUEUE", "3"},
                          {"TREELINE_TEST_CONFIG", "f"},
                          {"TREELINE_TEST_PORT_50051_TCP_ADDR", "10.0.0.1"}};
  EXPECT_TRUE(Resolve().ok());
  EXPECT_THAT(
      UnknownVariables(settings_, sources_),
      ElementsAre("TREELINE_TEST_PORT_50051_TCP_ADDR",
                  "TREELINE_TEST_QEUE (did you mean TREELINE_TEST_QUEUE?)"));
}

TEST_F(EffectiveConfigTest, PrintsValuesWithTheirOrigin) {
  sources_.flags = {{"models", "https://u:p@h/m"}, {"cors_origin", "a,b"}};
  sources_.environment = {{"TREELINE_TEST_PASSWORD", "hunter2"}};
  const std::string text = PrintConfig(settings_, Resolve().value());
  EXPECT_THAT(text, HasSubstr("queue: 64  # default\n"));
  EXPECT_THAT(text,
              HasSubstr("models: \"https://***@h/m\"  # flag --models\n"));
  EXPECT_THAT(text, HasSubstr("cors_origin: [\"a\", \"b\"]  # flag"));
  EXPECT_THAT(text, HasSubstr("password: \"***\"  # environment "
                              "TREELINE_TEST_PASSWORD\n"));
  EXPECT_THAT(text, Not(HasSubstr("hunter2")));
}

TEST_F(EffectiveConfigTest, WhatIsPrintedReadsBackTheSame) {
  sources_.flags = {
      {"models", "a \"b\" \\ # c: 'd'\n\t\x01 \xc3\xa4 \xe2\x82\xac"},
      {"cors_origin", "https://a,[x],*"},
      {"drain_s", "0.1"}};
  const EffectiveConfig before = Resolve().value();
  PutFile(PrintConfig(settings_, before));
  sources_.flags.clear();
  const auto after = Resolve();
  ASSERT_TRUE(after.ok()) << after.status();
  EXPECT_THAT(ChangedSettings(settings_, before, *after), ElementsAre());
}

TEST_F(EffectiveConfigTest, ChangesAreNamed) {
  sources_.flags = {{"models", "m"}};
  const EffectiveConfig before = Resolve().value();
  sources_.flags = {{"models", "n"}, {"queue", "64"}, {"drain_s", "2"}};
  EXPECT_THAT(ChangedSettings(settings_, before, Resolve().value()),
              ElementsAre("models", "drain_s"));
}

}  // namespace
}  // namespace treeline::config
