#include "common/config/setting.h"

#include <string>
#include <vector>

#include "common/config/testing_settings.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::config {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Setting& Named(const std::string& name) {
  static const auto* const table = new ConfigTable<TestOptions>(TestTable());
  return *FindSetting(table->settings(), name);
}

std::string ErrorOf(const std::string& name, const std::string& text) {
  const auto value = ParseValue(Named(name), text);
  EXPECT_TRUE(absl::IsInvalidArgument(value.status())) << name << " " << text;
  return std::string(value.status().message());
}

TEST(Setting, HasANameForEachSource) {
  EXPECT_EQ(FlagName(Named("drain_s")), "--drain-s");
  EXPECT_EQ(EnvironmentName("TREELINE_SERVER_", Named("drain_s")),
            "TREELINE_SERVER_DRAIN_S");
  EXPECT_EQ(ValueName(Named("models")), "DIR|URL");
  EXPECT_EQ(ValueName(Named("queue")), "INT");
}

TEST(Setting, TextsBecomeValuesOfItsType) {
  EXPECT_EQ(*ParseValue(Named("queue"), "100000"),
            ConfigValue(int64_t{100000}));
  EXPECT_EQ(*ParseValue(Named("drain_s"), "1e-3"), ConfigValue(1e-3));
  EXPECT_EQ(*ParseValue(Named("load_all"), "true"), ConfigValue(true));
  EXPECT_EQ(*ParseValue(Named("models"), " a b"),
            ConfigValue(std::string(" a b")));
  EXPECT_EQ(*ParseValue(Named("cors_origin"), "a, b"),
            ConfigValue(std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(*ParseValue(Named("cors_origin"), ""),
            ConfigValue(std::vector<std::string>{}));
}

TEST(Setting, ValuesOfOtherTypesAreRefusedByName) {
  EXPECT_EQ(ErrorOf("queue", "many"), "queue: 'many' is not a whole number");
  EXPECT_THAT(ErrorOf("queue", "1.5"), HasSubstr("whole number"));
  EXPECT_THAT(ErrorOf("queue", ""), HasSubstr("whole number"));
  EXPECT_THAT(ErrorOf("queue", "99999999999999999999"),
              HasSubstr("whole number"));
  EXPECT_THAT(ErrorOf("drain_s", "nan"), HasSubstr("not a number"));
  EXPECT_THAT(ErrorOf("drain_s", "inf"), HasSubstr("not a number"));
  EXPECT_THAT(ErrorOf("load_all", "yes"), HasSubstr("true or false"));
  EXPECT_THAT(ErrorOf("cors_origin", "a,,b"), HasSubstr("empty element"));
  EXPECT_THAT(ErrorOf("models", ""), HasSubstr("must be given"));
}

TEST(Setting, BoundsBelongToTheValues) {
  EXPECT_TRUE(ParseValue(Named("queue"), "1").ok());
  EXPECT_EQ(ErrorOf("queue", "0"), "queue is 0; it must be 1..100000");
  EXPECT_THAT(ErrorOf("queue", "100001"), HasSubstr("1..100000"));
  EXPECT_THAT(ErrorOf("drain_s", "-0.5"), HasSubstr("0..3600"));
}

TEST(Setting, ChoicesAreNamed) {
  EXPECT_EQ(ErrorOf("log_level", "loud"),
            "log_level: 'loud' is not one of debug, info, error");
}

TEST(Setting, WhatElseMustHoldIsAsked) {
  Setting setting = Named("models");
  setting.check = [](const ConfigValue& value) -> absl::Status {
    if (std::get<std::string>(value) != "bad") return absl::OkStatus();
    return absl::InvalidArgumentError("it is bad");
  };
  EXPECT_TRUE(ParseValue(setting, "good").ok());
  EXPECT_EQ(ParseValue(setting, "bad").status().message(), "models: it is bad");
}

TEST(Setting, AMistypedSecretIsNotRepeated) {
  Setting setting = Named("password");
  setting.choices = {"a"};
  EXPECT_THAT(std::string(ParseValue(setting, "hunter2").status().message()),
              Not(HasSubstr("hunter2")));
}

TEST(Setting, SecretsAreNotShown) {
  const Setting& password = Named("password");
  EXPECT_EQ(ToYamlRedacted(password, std::string("hunter2")), "\"***\"");
  EXPECT_EQ(ToYamlRedacted(password, password.default_value), "\"\"");
  EXPECT_EQ(ToYamlRedacted(Named("models"), std::string("https://u:p@h/m?s=1")),
            "\"https://***@h/m?***\"");
}

TEST(Setting, AddressesLoseWhatMayBeSecret) {
  EXPECT_EQ(RedactAddress("models/a@b?c"), "models/a@b?c");
  EXPECT_EQ(RedactAddress("https://h:80/a/b"), "https://h:80/a/b");
  EXPECT_EQ(RedactAddress("https://u:p@x@h/a@b"), "https://***@h/a@b");
  EXPECT_EQ(RedactAddress("https://h?sig=1"), "https://h?***");
  EXPECT_EQ(RedactAddress("https://h/a#sig"), "https://h/a#***");
  EXPECT_EQ(RedactAddress("https://u:p@h"), "https://***@h");
}

TEST(Setting, SlipsOfTheFingerAreRecognized) {
  const auto table = TestTable();
  EXPECT_EQ(NearestName(table.settings(), "quuee"), "queue");
  EXPECT_EQ(NearestName(table.settings(), "log-level"), "log_level");
  EXPECT_EQ(NearestName(table.settings(), "LOG_LEVEL"), "log_level");
  EXPECT_EQ(NearestName(table.settings(), "cors_origins"), "cors_origin");
  EXPECT_EQ(NearestName(table.settings(), "temperature"), "");
  EXPECT_EQ(NearestName(table.settings(), std::string(1 << 20, 'q')), "");
}

}  // namespace
}  // namespace treeline::config
