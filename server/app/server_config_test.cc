#include "server/app/server_config.h"

#include <map>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::server_app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

absl::StatusOr<ServerConfig> Made(std::map<std::string, std::string> flags) {
  flags.insert({"models", "m"});
  const auto config =
      config::ResolveConfig(ServerConfigTable().settings(), {.flags = flags});
  if (!config.ok()) return config.status();
  ServerConfig made = ServerConfigTable().Make(*config);
  const absl::Status valid = made.Validate();
  if (!valid.ok()) return valid;
  return made;
}

std::string ErrorOf(const std::map<std::string, std::string>& flags) {
  const auto config = Made(flags);
  EXPECT_TRUE(absl::IsInvalidArgument(config.status())) << config.status();
  return std::string(config.status().message());
}

TEST(ServerConfig, DefaultsAreValid) {
  const auto config = Made({});
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->listen, "127.0.0.1:50051");
  EXPECT_EQ(config->admin_listen, "127.0.0.1:50052");
  EXPECT_EQ(config->http_listen, "127.0.0.1:8080");
}

TEST(ServerConfig, EverySettingHasOneNameAndHelp) {
  std::set<std::string> names;
  for (const config::Setting& setting : ServerConfigTable().settings()) {
    EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
    EXPECT_FALSE(setting.help.empty()) << setting.name;
    EXPECT_NE(setting.help.back(), '.') << setting.name;
    if (!setting.required) {
      EXPECT_TRUE(config::CheckValue(setting, setting.default_value).ok())
          << setting.name;
    }
  }
}

TEST(ServerConfig, FloodLimitsFollowTheProcessors) {
  ServerConfig config;
  config.flood_limit = 300;
  config.flood_open_calls = 20;
  const auto limits = FloodLimitsOf(config, 4);
  ASSERT_TRUE(limits.has_value());
  EXPECT_EQ(limits->calls_per_s, 1200);
  EXPECT_EQ(limits->open_calls, 20);
  EXPECT_TRUE(limits->Validate().ok());
  // Of a machine that does not say.
  EXPECT_EQ(FloodLimitsOf(config, 0)->calls_per_s, 300);
  config.flood_limit = 0;
  EXPECT_FALSE(FloodLimitsOf(config, 4).has_value());
}

TEST(ServerConfig, WhatBelongsTogetherIsGivenTogether) {
  EXPECT_THAT(ErrorOf({{"tls_cert", "c"}}), HasSubstr("--tls-key"));
  EXPECT_THAT(ErrorOf({{"tls_key", "k"}}), HasSubstr("--tls-cert"));
  EXPECT_THAT(ErrorOf({{"tls_client_ca", "c"}}), HasSubstr("--tls-cert"));
  EXPECT_THAT(ErrorOf({{"tls_cert", "c"},
                       {"tls_key", "k"},
                       {"tls_require_client_cert", "true"}}),
              HasSubstr("--tls-client-ca"));
  EXPECT_THAT(ErrorOf({{"auth_audience", "a"}}), HasSubstr("--auth-keys"));
  EXPECT_THAT(ErrorOf({{"models", "https://h/m"}}), HasSubstr("--cache"));
  EXPECT_TRUE(Made({{"models", "https://h/m"}, {"cache", "c"}}).ok());
  EXPECT_THAT(ErrorOf({{"models", "m"}, {"models_keys", "k"}}),
              HasSubstr("--models with a web address"));
}

TEST(ServerConfig, AddressesAreChecked) {
  EXPECT_THAT(ErrorOf({{"listen", "x"}}), HasSubstr("listen: "));
  EXPECT_THAT(ErrorOf({{"http_listen", "127.0.0.1:99999"}}),
              HasSubstr("http_listen: "));
  EXPECT_THAT(ErrorOf({{"listen", ""}}), HasSubstr("must be given"));
  EXPECT_TRUE(Made({{"http_listen", ""}, {"admin_listen", ""}}).ok());
  EXPECT_THAT(ErrorOf({{"listen", "0.0.0.0:0"}}),
              HasSubstr("--insecure-any-address"));
}

TEST(ServerConfig, OriginsHaveNoPath) {
  EXPECT_TRUE(Made({{"cors_origin", "https://a,http://b:8080"}}).ok());
  for (const char* origin : {"a", "https://", "https://a/", "ftp://a",
                             "https://a b", "https://*.a", "https://u@a"}) {
    EXPECT_THAT(ErrorOf({{"cors_origin", origin}}), HasSubstr("an origin"))
        << origin;
  }
}

// What --help offers and what the start accepts must not differ.
TEST(ServerConfig, AllOriginsAreNeitherOfferedNorTaken) {
  EXPECT_THAT(ErrorOf({{"cors_origin", "*"}}), HasSubstr("no * for all"));
  for (const config::Setting& setting : ServerConfigTable().settings()) {
    if (setting.name != "cors_origin") continue;
    EXPECT_THAT(setting.help, Not(HasSubstr("*")));
  }
}

TEST(ServerConfig, OperatorsFromElsewhereMustSayWhoTheyAre) {
  ServerConfig config;
  config.models = "m";
  config.tls_cert = "c";
  config.tls_key = "k";
  config.admin_listen = "0.0.0.0:50052";
  EXPECT_EQ(config.Validate().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(config.Validate().message()),
              HasSubstr("--auth-keys"));
  config.auth_keys = "keys";
  EXPECT_TRUE(config.Validate().ok()) << config.Validate();
}

TEST(ServerConfig, ReachesTheService) {
  const auto config = Made({{"queue", "3"}, {"max_megapixels", "0.5"}});
  ASSERT_TRUE(config.ok()) << config.status();
  const service::DispatcherOptions options = DispatcherOptionsOf(*config);
  EXPECT_EQ(options.queue, 3);
  EXPECT_EQ(options.decode_limits.max_pixels, 500000);
}

// The page and the table must not drift apart.
TEST(ServerConfig, TheDocumentNamesEverySetting) {
  const auto page = base::ReadFile(TREELINE_SETTINGS_PAGE);
  ASSERT_TRUE(page.ok()) << page.status();
  for (const config::Setting& setting : ServerConfigTable().settings()) {
    EXPECT_THAT(*page, HasSubstr(absl::StrCat("| `", setting.name, "` |")));
  }
}

}  // namespace
}  // namespace treeline::server_app
