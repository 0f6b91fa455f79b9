// treeline-server as a process: starting, refusing to, and stopping.
#include <csignal>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/blocking_counter.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "gmock/gmock.h"
#include "tests/integration/fixture.h"

namespace treeline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class ServerProcess : public ServerTest {
 protected:
  ProgramResult RunServer(const std::vector<std::string>& arguments) const {
    std::vector<std::string> argv = {TREELINE_SERVER_PROGRAM};
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    return RunProgram(argv);
  }
};

TEST_F(ServerProcess, HelpTeachesAndSucceeds) {
  const ProgramResult result = RunServer({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, AllOf(HasSubstr("--models"), HasSubstr("Examples:"),
                                HasSubstr("Exit codes:")));
}

TEST_F(ServerProcess, WrongUsageExitsWith2) {
  EXPECT_EQ(RunServer({}).exit_code, 2);
  EXPECT_EQ(RunServer({"--models", models_, "--no-such-flag"}).exit_code, 2);
  EXPECT_EQ(RunServer({"--models", models_, "--queue", "0"}).exit_code, 2);
  EXPECT_EQ(RunServer({"--models", models_, "--listen", "x"}).exit_code, 2);
}

TEST_F(ServerProcess, OtherMachinesAreShutOutUnlessAskedFor) {
  const ProgramResult result =
      RunServer({"--models", models_, "--listen", "0.0.0.0:0"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--insecure-any-address"));
}

TEST_F(ServerProcess, AMissingFolderOfModelsExitsWith1) {
  const ProgramResult result =
      RunServer({"--models", folder_ + "/missing", "--listen", "127.0.0.1:0"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr(folder_ + "/missing"));
}

TEST_F(ServerProcess, APortInUseExitsWith1AndSaysSo) {
  StartServer();
  const ProgramResult second =
      RunServer({"--models", models_, "--listen", address_});
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_THAT(second.err, AllOf(HasSubstr(address_), HasSubstr("in use")));
  EXPECT_EQ(second.out, "");
  // The first one does not mind.
  EXPECT_TRUE(client_->ListScenes({}).ok());
}

TEST_F(ServerProcess, AnEmptyFolderServesNoScenes) {
  StartServer();
  const auto scenes = client_->ListScenes({});
  ASSERT_TRUE(scenes.ok()) << scenes.status();
  EXPECT_TRUE(scenes->empty());
  EXPECT_THAT(server_->err(), HasSubstr("no scenes"));
}

TEST_F(ServerProcess, TerminateAndInterruptStopIt) {
  for (const int signal : {SIGTERM, SIGINT}) {
    StartServer();
    server_->Signal(signal);
    EXPECT_EQ(server_->WaitForExit(absl::Seconds(10)), 0) << signal;
    EXPECT_THAT(server_->err(), HasSubstr("stopped")) << signal;
  }
}

TEST_F(ServerProcess, ASecondSignalEndsItAtOnce) {
  StartServer({"--drain-s", "3600"});
  server_->Signal(SIGTERM);
  // The first signal must have been taken before the second comes.
  while (server_->err().find("stopping") == std::string::npos) {
    std::this_thread::yield();
  }
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->WaitForExit(absl::Seconds(10)), -SIGTERM);
}

// The order of a stop: calls are answered to the end, and none is lost.
TEST_F(ServerProcess, CallsAreAnsweredWhileItDrains) {
  PutRoom();
  StartServer({"--drain-s", "1"});
  const dataset::Dataset frames = HeldOutFrames();
  const relocalizer::LocalizeQuery query = QueryOf(frames, 0);
  ASSERT_TRUE(client_->Localize(query, {}).ok());
  server_->Signal(SIGTERM);
  while (server_->err().find("stopping") == std::string::npos) {
    std::this_thread::yield();
  }
  const auto answer = client_->Localize(query, {});
  EXPECT_TRUE(answer.ok()) << answer.status();
  client_.reset();  // an idle connection would be waited for
  EXPECT_EQ(server_->WaitForExit(), 0);
}

TEST_F(ServerProcess, StopsInTimeWhileClientsKeepAsking) {
  PutRoom();
  StartServer({"--drain-s", "0", "--grace-s", "1"});
  const dataset::Dataset frames = HeldOutFrames();
  const relocalizer::LocalizeQuery query = QueryOf(frames, 0);
  constexpr int kClients = 4;
  absl::BlockingCounter asking(kClients);
  std::vector<std::thread> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.emplace_back([&] {
      const auto client = relocalizer::ConnectRelocalizer(
                              {.server = address_, .max_attempts = 1})
                              .value();
      bool first = true;
      while (client->Localize(query, {}).ok()) {
        if (first) asking.DecrementCount();
        first = false;
      }
      if (first) asking.DecrementCount();
    });
  }
  asking.Wait();
  server_->Signal(SIGTERM);
  EXPECT_EQ(server_->WaitForExit(absl::Seconds(20)), 0);
  for (std::thread& client : clients) client.join();
}

}  // namespace
}  // namespace treeline
