// treeline-server as operators know it: configuration, signals, health, log.
#include <httplib.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/metrics/testing_exposition.h"
#include "gmock/gmock.h"
#include "tests/integration/fixture.h"

namespace treeline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class Operations : public ServerTest {
 protected:
  // Runs treeline-server with variables in front and arguments behind.
  static ProgramResult Run(const std::vector<std::string>& arguments,
                           const std::vector<std::string>& variables = {}) {
    std::vector<std::string> argv = {"/usr/bin/env"};
    argv.insert(argv.end(), variables.begin(), variables.end());
    argv.emplace_back(TREELINE_SERVER_PROGRAM);
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    return RunProgram(argv);
  }
  // Waits until the server's log says `text`.
  void WaitForLog(const std::string& text) {
    while (server_->err().find(text) == std::string::npos) {
      ASSERT_TRUE(server_->IsRunning()) << server_->err();
      std::this_thread::yield();
    }
  }
};

TEST_F(Operations, PrintConfigTellsValuesAndTheirOrigin) {
  const std::string file =
      PutFile("site.yaml", "# ours\nmodels: /srv/m\nqueue: 5\ngrace_s: 2\n");
  const ProgramResult result =
      Run({"--config", file, "--drain-s", "0.5", "--print-config"},
          {"TREELINE_SERVER_QUEUE=9"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("models: \"/srv/m\"  # " + file + ":2\n"),
                    HasSubstr("queue: 9  # environment TREELINE_SERVER_QUEUE"),
                    HasSubstr("grace_s: 2  # " + file + ":4\n"),
                    HasSubstr("drain_s: 0.5  # flag --drain-s\n"),
                    HasSubstr("log_level: \"info\"  # default\n")));
}

TEST_F(Operations, WhatIsPrintedIsAConfiguration) {
  const ProgramResult first =
      Run({"--models", "a b", "--queue", "7", "--print-config"});
  const std::string file = PutFile("printed.yaml", first.out);
  // The variable that names the file is as good as the flag.
  const ProgramResult second =
      Run({"--print-config"}, {"TREELINE_SERVER_CONFIG=" + file});
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.out,
              AllOf(HasSubstr("models: \"a b\""), HasSubstr("queue: 7")));
}

TEST_F(Operations, SecretsInAddressesAreNotPrinted) {
  const ProgramResult result =
      Run({"--models", "https://user:hunter2@host/index?sig=abc", "--cache",
           "c", "--print-config"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("https://***@host/index?***"),
                    Not(HasSubstr("hunter2")), Not(HasSubstr("abc"))));
}

TEST_F(Operations, WrongConfigurationsExitWith2AndNameThePlace) {
  const std::string file =
      PutFile("site.yaml", "models: m\n\nqeue: 3\nqueue: 1\n");
  ProgramResult result = Run({"--config", file});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err,
            absl::StrCat("treeline-server: ", file,
                         ":3: no setting is called 'qeue'; did you mean "
                         "'queue'?\n"));
  result = Run({"--models", "m"}, {"TREELINE_SERVER_QUEUE=many"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("environment TREELINE_SERVER_QUEUE: "));
  EXPECT_EQ(Run({"--config", folder_ + "/missing.yaml"}).exit_code, 2);
  EXPECT_EQ(Run({"--config", file, "--print-config"}).exit_code, 2);
}

TEST_F(Operations, SettingsOfAFileAreInForce) {
  const std::string file = PutFile(
      "site.yaml", absl::StrCat("models: ", models_,
                                "\nlisten: 127.0.0.1:0\nadmin_listen: ''\n"
                                "http_listen: ''\ndrain_s: 0\n"));
  server_ = std::make_unique<Process>(
      std::vector<std::string>{TREELINE_SERVER_PROGRAM, "--config", file});
  ASSERT_TRUE(server_->WaitForLine("listening on ").has_value());
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->WaitForExit(), 0);
  EXPECT_THAT(server_->err(), HasSubstr("answering for 0 s more"));
}

TEST_F(Operations, VariablesOfNoSettingAreAWarning) {
  server_ = std::make_unique<Process>(std::vector<std::string>{
      "/usr/bin/env", "TREELINE_SERVER_QEUE=3",
      "TREELINE_SERVER_SERVICE_HOST=10.0.0.1", TREELINE_SERVER_PROGRAM,
      "--models", models_, "--listen", "127.0.0.1:0", "--admin-listen", "",
      "--http-listen", ""});
  ASSERT_TRUE(server_->WaitForLine("listening on ").has_value());
  EXPECT_THAT(server_->err(),
              AllOf(HasSubstr("TREELINE_SERVER_QEUE (did you mean "
                              "TREELINE_SERVER_QUEUE?)"),
                    HasSubstr("TREELINE_SERVER_SERVICE_HOST")));
}

TEST_F(Operations, HangupReloadsWhatIsLiveAndKeepsTheRest) {
  const std::string file = PutFile("site.yaml", "log_level: info\n");
  StartServer({"--config", file, "--drain-s", "0"});
  ASSERT_TRUE(client_->ListScenes({}).ok());
  EXPECT_THAT(server_->err(), Not(HasSubstr("rpc=ListScenes")));

  PutFile("site.yaml", "log_level: debug\nqueue: 7\n");
  server_->Signal(SIGHUP);
  WaitForLog("needs a restart: queue");
  EXPECT_THAT(server_->err(), HasSubstr("reloaded; changed: log_level"));
  ASSERT_TRUE(client_->ListScenes({}).ok());
  WaitForLog("rpc=ListScenes");
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->WaitForExit(), 0);
}

TEST_F(Operations, HangupWithABrokenFileChangesNothing) {
  const std::string file = PutFile("site.yaml", "log_level: info\n");
  StartServer({"--config", file, "--drain-s", "0"});
  PutFile("site.yaml", "log_level: loud\n");
  server_->Signal(SIGHUP);
  WaitForLog("not reloaded");
  EXPECT_THAT(server_->err(), HasSubstr(file + ":1: log_level: 'loud' is not"));
  EXPECT_TRUE(client_->ListScenes({}).ok());
  // Repaired, it is taken.
  PutFile("site.yaml", "log_level: debug\n");
  server_->Signal(SIGHUP);
  WaitForLog("reloaded; changed: log_level");
}

// One that nobody has asked for must not end the process either.
TEST_F(Operations, HangupWithoutAFileIsHarmless) {
  StartServer();
  server_->Signal(SIGHUP);
  WaitForLog("reloaded; changed: nothing");
  EXPECT_TRUE(client_->ListScenes({}).ok());
}

TEST_F(Operations, HealthcheckTellsServingFromStopping) {
  StartServer({"--drain-s", "3600"});
  ProgramResult result = Run({"healthcheck", "--server", address_});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_EQ(result.out, absl::StrCat("healthy: ", address_, " is SERVING\n"));
  EXPECT_EQ(result.err, "");

  server_->Signal(SIGTERM);
  WaitForLog("stopping");
  // The line comes before health turns.
  do {
    result = Run({"healthcheck", "--server", address_});
  } while (result.exit_code == 0);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out,
              AllOf(StartsWith("unhealthy: "), HasSubstr("NOT_SERVING")));
}

TEST_F(Operations, HealthcheckOfNobodyIsUnhealthy) {
  StartServer();
  server_->Signal(SIGTERM);
  ASSERT_EQ(server_->WaitForExit(), 0);
  const ProgramResult result = Run({"healthcheck", "--server", address_});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, StartsWith("unhealthy: "));
}

TEST_F(Operations, HealthcheckOfAnUnknownSceneIsUnhealthy) {
  StartServer();
  const ProgramResult result =
      Run({"healthcheck", "--server", address_, "--scene", "attic"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, HasSubstr("scene attic"));
}

TEST_F(Operations, HealthcheckKnowsScenesApart) {
  PutRoom();
  PutModel("broken", "1", "no model");
  StartServer({"--load-all", "--drain-s", "0"});
  // Health of scenes follows the repository within a second or so.
  ProgramResult result;
  do {
    result = Run({"healthcheck", "--server", address_, "--scene", "room"});
  } while (result.exit_code != 0 && server_->IsRunning());
  EXPECT_THAT(result.out, HasSubstr("scene room is SERVING"));
  result = Run({"healthcheck", "--server", address_, "--scene", "broken"});
  EXPECT_EQ(result.exit_code, 1) << result.out;
}

// Where the server said that it serves HTTP.
class OperationsHttp : public Operations {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    PutRoom();
  }
  std::string Get(const std::string& path, int expected_code) {
    const std::string prefix = "http on ";
    const auto line = server_->WaitForLine(prefix);
    EXPECT_TRUE(line.has_value()) << server_->err();
    if (!line) return "";
    httplib::Client client("http://" + line->substr(prefix.size()));
    const auto response = client.Get(path);
    EXPECT_TRUE(response) << path;
    if (!response) return "";
    EXPECT_EQ(response->status, expected_code) << path;
    return response->body;
  }
  std::map<std::string, metrics::ParsedFamily> Metrics() {
    auto metrics = metrics::ParseExposition(Get("/metrics", 200));
    EXPECT_TRUE(metrics.ok()) << metrics.status();
    return metrics.value_or(std::map<std::string, metrics::ParsedFamily>());
  }
};

TEST_F(OperationsHttp, MetricsCountEachCallExactlyOnce) {
  StartServer();
  const dataset::Dataset frames = HeldOutFrames();
  constexpr int kCalls = 3;
  for (int i = 0; i < kCalls; ++i) {
    ASSERT_TRUE(client_->Localize(QueryOf(frames, 0), {}).ok());
  }
  relocalizer::LocalizeQuery query = QueryOf(frames, 0);
  query.scene = "attic";
  ASSERT_FALSE(client_->Localize(query, {}).ok());
  ASSERT_TRUE(client_->ListScenes({}).ok());
  const auto metrics = Metrics();
  double ok = 0;
  double all = 0;
  for (const auto& [key, value] :
       metrics.at("treeline_requests_total").samples) {
    all += value;
    if (key.find("rpc=Localize,status=OK") != std::string::npos) ok += value;
  }
  EXPECT_EQ(ok, kCalls);
  EXPECT_EQ(all, kCalls + 2);
  EXPECT_EQ(metrics::SampleOf(metrics,
                              "treeline_request_seconds_count{rpc=Localize}"),
            kCalls + 1);
  EXPECT_EQ(metrics::SampleOf(metrics, "treeline_confidence_count{scene=room}"),
            kCalls);
  EXPECT_EQ(
      metrics::SampleOf(metrics,
                        "treeline_stage_seconds_count{method=rgbd,stage=forest,"
                        "status=OK}"),
      kCalls);
  EXPECT_EQ(metrics::SampleOf(metrics, "treeline_scenes{state=READY}"), 1);
  EXPECT_GE(metrics::SampleOf(metrics, "treeline_workers"), 1);
  // Answers are sent before their worker is free.
  while (metrics::SampleOf(Metrics(), "treeline_in_flight") != 0) {
  }
  // Nothing that the client made up.
  EXPECT_THAT(Get("/metrics", 200), Not(HasSubstr("attic")));
}

TEST_F(OperationsHttp, ReadinessEndsWhenItDrainsAndLivenessDoesNot) {
  StartServer({"--drain-s", "3600"});
  Get("/healthz", 200);
  Get("/readyz", 200);
  server_->Signal(SIGTERM);
  WaitForLog("stopping");
  while (Run({"healthcheck", "--server", address_}).exit_code == 0) {
  }
  Get("/readyz", 503);
  Get("/healthz", 200);
}

TEST_F(OperationsHttp, FailedQueriesAreKeptOnlyWhereAskedFor) {
  const std::string kept = folder_ + "/kept";
  StartServer({"--record", kept, "--drain-s", "0"});
  relocalizer::LocalizeQuery query = QueryOf(HeldOutFrames(), 0);
  ASSERT_TRUE(client_->Localize(query, {}).ok());
  query.frame.color = wire::EncodedImage{"not an image"};
  ASSERT_TRUE(absl::IsInvalidArgument(client_->Localize(query, {}).status()));
  client_.reset();
  server_->Signal(SIGTERM);
  ASSERT_EQ(server_->WaitForExit(), 0);
  int requests = 0;
  int answers = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kept)) {
    requests += entry.path().extension() == ".binpb";
    answers += entry.path().extension() == ".json";
  }
  EXPECT_EQ(requests, 1);
  EXPECT_EQ(answers, 1);
}

TEST_F(Operations, HealthcheckUsedWronglyExitsWith2) {
  EXPECT_EQ(Run({"healthcheck", "--no-such-flag"}).exit_code, 2);
  EXPECT_EQ(Run({"healthcheck", "--timeout-s", "0"}).exit_code, 2);
  EXPECT_EQ(Run({"healthcheck", "--tls-name", "n"}).exit_code, 2);
  EXPECT_EQ(Run({"healthcheck", "--help"}).exit_code, 0);
}

TEST_F(Operations, TheJsonLogIsOneObjectALine) {
  PutModel("broken\xff", "1", "no model");  // not a name: passed over
  PutModel("broken", "1", "no model");
  StartServer(
      {"--log-format", "json", "--log-level", "debug", "--drain-s", "0"});
  ASSERT_FALSE(client_->GetScene("attic \"\n", {}).ok());
  client_.reset();
  server_->Signal(SIGTERM);
  ASSERT_EQ(server_->WaitForExit(), 0);
  bool told_of_call = false;
  bool told_of_scene = false;
  for (const absl::string_view line :
       absl::StrSplit(server_->err(), '\n', absl::SkipEmpty())) {
    const auto object =
        nlohmann::json::parse(std::string(line), nullptr, false);
    ASSERT_TRUE(object.is_object()) << line;
    EXPECT_TRUE(object.contains("ts") && object.contains("level")) << line;
    if (object.value("rpc", "") == "GetScene") {
      told_of_call = true;
      EXPECT_EQ(object["scene"], "attic \"\n");
      EXPECT_EQ(object["status"], "INVALID_ARGUMENT");
    }
    if (object.value("state", "") == "FAILED") {
      told_of_scene = true;
      EXPECT_EQ(object["scene"], "broken");
    }
  }
  EXPECT_TRUE(told_of_call);
  EXPECT_TRUE(told_of_scene);
}

}  // namespace
}  // namespace treeline
