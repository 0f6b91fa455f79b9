#include "server/app/config_reloader.h"

#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::server_app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class ConfigReloaderTest : public testing::Test {
 protected:
  ConfigReloaderTest()
      : path_(testing::TempDir() + "/config-reloader-" +
              testing::UnitTest::GetInstance()->current_test_info()->name() +
              ".yaml"),
        log_(
            std::make_shared<spdlog::logger>(
                "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(out_)),
            logging::LogFormat::kText) {
    sources_.file = path_;
  }
  ~ConfigReloaderTest() override { std::remove(path_.c_str()); }

  void PutFile(const std::string& text) { std::ofstream(path_) << text; }
  void Start(const std::string& text) {
    PutFile(text);
    auto initial =
        config::ResolveConfig(ServerConfigTable().settings(), sources_);
    ASSERT_TRUE(initial.ok()) << initial.status();
    reloader_ =
        std::make_unique<ConfigReloader>(sources_, *std::move(initial), log_,
                                         [this](const ServerConfig& config) {
                                           ++applied_;
                                           last_ = config;
                                         });
  }

  const std::string path_;
  std::ostringstream out_;
  logging::ProgramLog log_;
  config::ConfigSources sources_;
  std::unique_ptr<ConfigReloader> reloader_;
  int applied_ = 0;
  ServerConfig last_;
};

TEST_F(ConfigReloaderTest, LiveSettingsComeIntoForce) {
  Start("models: m\nlog_level: info\n");
  PutFile("models: m\nlog_level: debug\ngrace_s: 3\n");
  reloader_->Reload();
  EXPECT_EQ(applied_, 1);
  EXPECT_EQ(last_.log_level, "debug");
  EXPECT_EQ(reloader_->config().grace_s, 3);
  EXPECT_THAT(out_.str(), HasSubstr("changed: grace_s, log_level"));
  EXPECT_THAT(out_.str(), Not(HasSubstr("restart")));
}

TEST_F(ConfigReloaderTest, OthersNeedARestartAndAreSaidSoEachTime) {
  Start("models: m\n");
  PutFile("models: other\nqueue: 7\nlog_level: debug\n");
  reloader_->Reload();
  EXPECT_EQ(last_.models, "m");
  EXPECT_EQ(last_.queue, 64);
  EXPECT_EQ(last_.log_level, "debug");
  EXPECT_THAT(out_.str(), HasSubstr("needs a restart: models, queue"));
  out_.str("");
  reloader_->Reload();
  EXPECT_THAT(out_.str(), HasSubstr("changed: nothing"));
  EXPECT_THAT(out_.str(), HasSubstr("needs a restart: models, queue"));
}

TEST_F(ConfigReloaderTest, ABrokenFileChangesNothingAndIsExplained) {
  Start("models: m\n");
  PutFile("models: m\nlog_level: debug\nqeue: 3\n");
  reloader_->Reload();
  EXPECT_EQ(applied_, 0);
  EXPECT_EQ(reloader_->config().log_level, "info");
  EXPECT_THAT(out_.str(), HasSubstr("error configuration not reloaded"));
  EXPECT_THAT(out_.str(), HasSubstr(path_ + ":3: "));
  EXPECT_THAT(out_.str(), HasSubstr("did you mean 'queue'?"));
}

TEST_F(ConfigReloaderTest, AMissingFileChangesNothing) {
  Start("models: m\nlog_level: debug\n");
  std::remove(path_.c_str());
  reloader_->Reload();
  EXPECT_EQ(applied_, 0);
  EXPECT_EQ(reloader_->config().log_level, "debug");
  EXPECT_THAT(out_.str(), HasSubstr(path_));
}

TEST_F(ConfigReloaderTest, WhatDoesNotFitTogetherChangesNothing) {
  Start("models: m\n");
  PutFile("models: m\nlog_level: debug\ntls_cert: c\n");
  reloader_->Reload();
  EXPECT_EQ(applied_, 0);
  EXPECT_THAT(out_.str(), HasSubstr("--tls-key"));
}

TEST_F(ConfigReloaderTest, FlagsBeatTheFileAfterAReloadToo) {
  sources_.flags = {{"log_level", "error"}};
  Start("models: m\n");
  PutFile("models: m\nlog_level: debug\n");
  log_.SetLevel(logging::LogLevel::kDebug);
  reloader_->Reload();
  EXPECT_EQ(last_.log_level, "error");
  EXPECT_THAT(out_.str(), HasSubstr("changed: nothing"));
}

}  // namespace
}  // namespace treeline::server_app
