#include "common/config/config_file.h"

#include <string>
#include <vector>

#include "common/config/testing_settings.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::config {
namespace {

using ::testing::HasSubstr;

auto Parse(const std::string& text) {
  return ParseConfigFile(text, "site.yaml", TestTable().settings());
}

std::string ErrorOf(const std::string& text) {
  const auto values = Parse(text);
  EXPECT_TRUE(absl::IsInvalidArgument(values.status())) << text;
  return std::string(values.status().message());
}

TEST(ConfigFile, StatesValuesWithTheirLines) {
  const auto values = Parse(
      "# our site\n"
      "models: /srv/models\n"
      "\n"
      "queue: 128\n"
      "drain_s: 2.5\n"
      "load_all: true\n"
      "cors_origin:\n"
      "  - https://a\n"
      "  - 'https://b'\n");
  ASSERT_TRUE(values.ok()) << values.status();
  EXPECT_EQ(values->at("models").value,
            ConfigValue(std::string("/srv/models")));
  EXPECT_EQ(values->at("models").line, 2);
  EXPECT_EQ(values->at("queue").value, ConfigValue(int64_t{128}));
  EXPECT_EQ(values->at("queue").line, 4);
  EXPECT_EQ(values->at("drain_s").value, ConfigValue(2.5));
  EXPECT_EQ(values->at("load_all").value, ConfigValue(true));
  EXPECT_EQ(values->at("cors_origin").value,
            ConfigValue(std::vector<std::string>{"https://a", "https://b"}));
  EXPECT_EQ(values->size(), 5u);
}

TEST(ConfigFile, TheSettingDecidesTheTypeNotTheText) {
  // To YAML these are a truth, a number and a date.
  for (const char* text : {"no", "1.0", "2026-11-21"}) {
    const auto values = Parse(std::string("models: ") + text + "\n");
    ASSERT_TRUE(values.ok()) << values.status();
    EXPECT_EQ(values->at("models").value, ConfigValue(std::string(text)));
  }
}

TEST(ConfigFile, MayBeEmpty) {
  EXPECT_TRUE(Parse("")->empty());
  EXPECT_TRUE(Parse("# nothing\n")->empty());
  EXPECT_TRUE(Parse("---\n")->empty());
}

TEST(ConfigFile, UnknownKeysAreErrorsWithTheNearestOne) {
  EXPECT_EQ(ErrorOf("models: m\n\nqeue: 3\n"),
            "site.yaml:3: no setting is called 'qeue'; did you mean 'queue'?");
  EXPECT_EQ(ErrorOf("temperature: 3\n"),
            "site.yaml:1: no setting is called 'temperature'");
}

TEST(ConfigFile, ErrorsNameTheLine) {
  EXPECT_EQ(ErrorOf("models: m\nqueue: many\n"),
            "site.yaml:2: queue: 'many' is not a whole number");
  EXPECT_EQ(ErrorOf("models: m\nqueue: 0\n"),
            "site.yaml:2: queue is 0; it must be 1..100000");
  EXPECT_EQ(ErrorOf("queue:\n"), "site.yaml:1: queue has no value");
  EXPECT_EQ(ErrorOf("queue: [1]\n"),
            "site.yaml:1: queue must be one value, not several");
  EXPECT_EQ(ErrorOf("\ncors_origin:\n  a: b\n"),
            "site.yaml:2: cors_origin must be a sequence of texts");
  EXPECT_EQ(ErrorOf("cors_origin: [a, [b]]\n"),
            "site.yaml:1: cors_origin: its elements must be texts");
}

TEST(ConfigFile, AKeyMayNotStandTwice) {
  EXPECT_EQ(ErrorOf("queue: 1\nmodels: m\nqueue: 2\n"),
            "site.yaml:3: queue stands there twice; also in line 1");
}

TEST(ConfigFile, WhatIsNoMapIsRefused) {
  EXPECT_THAT(ErrorOf("- a\n- b\n"), HasSubstr("site.yaml:1: "));
  EXPECT_THAT(ErrorOf("just a text\n"), HasSubstr("name: value"));
  EXPECT_THAT(ErrorOf("? [a]\n: b\n"), HasSubstr("must be a text"));
  EXPECT_THAT(ErrorOf("queue: 1\n---\nqueue: 2\n"),
              HasSubstr("a second document"));
}

TEST(ConfigFile, WhatIsNotYamlIsRefusedWithItsLine) {
  EXPECT_THAT(ErrorOf("queue: 1\nmodels: [a\n"), HasSubstr("site.yaml:"));
  EXPECT_THAT(ErrorOf("queue: 1\nmodels: *nowhere\n"),
              HasSubstr("site.yaml:2: not YAML"));
  EXPECT_THAT(ErrorOf(std::string("queue: 1\0\nmodels: m", 19)),
              HasSubstr("zero byte"));
  EXPECT_THAT(ErrorOf(std::string(100000, '[')), HasSubstr("not YAML"));
  EXPECT_THAT(ErrorOf(std::string(kMaxConfigFileBytes + 1, '#')),
              HasSubstr("more than"));
}

TEST(ConfigFile, AMissingFileIsNamed) {
  const auto values =
      ReadConfigFile("/nowhere/site.yaml", TestTable().settings());
  EXPECT_TRUE(absl::IsNotFound(values.status()));
  EXPECT_THAT(std::string(values.status().message()),
              HasSubstr("/nowhere/site.yaml"));
}

}  // namespace
}  // namespace treeline::config
