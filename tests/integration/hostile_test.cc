// Twenty of each attack side by side against the real server: its memory hardly
// grows, and honest clients are answered meanwhile.
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <httplib.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/http/testing_raw_client.h"
#include "gmock/gmock.h"
#include "tests/integration/fixture.h"
#include "tests/integration/hostile_payloads.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;

constexpr int kSideBySide = 20;
constexpr int64_t kMaxGrowth_mib = 200;
// Of connections and threads alone.
constexpr int64_t kMaxGrowthOfStrangers_mib = 50;
// Between two honest calls, so that they leave the processors to the attack.
constexpr absl::Duration kPauseOfHonest = absl::Milliseconds(50);

// MiB of a line like "VmRSS:   123456 kB"; the peak is VmHWM.
int64_t Memory_mib(pid_t pid, absl::string_view what) {
  std::ifstream status(absl::StrCat("/proc/", pid, "/status"));
  std::string line;
  while (std::getline(status, line)) {
    absl::string_view rest = line;
    if (!absl::ConsumePrefix(&rest, what)) continue;
    rest = absl::StripAsciiWhitespace(absl::StripSuffix(rest, "kB"));
    int64_t kib = 0;
    if (absl::SimpleAtoi(rest, &kib)) return kib / 1024;
  }
  return -1;
}

class HostileTest : public ServerTest {
 protected:
  HostileTest() : frames_(HeldOutFrames()) {
    // httplib's client writes on to a server that has hung up.
    std::signal(SIGPIPE, SIG_IGN);
  }

  void Start(const std::vector<std::string>& more_arguments) {
    PutRoom();
    StartServer(more_arguments);
    const auto line = server_->WaitForLine("http on ");
    ASSERT_TRUE(line.has_value());
    http_address_ = line->substr(std::string("http on ").size());
  }

  // Whether a probe is answered.
  bool Probe() const {
    httplib::Client client("http://" + http_address_);
    const auto answer = client.Get("/healthz");
    return answer && answer->status == 200;
  }

  // Whether a query and a probe are answered.
  bool HonestQuery() {
    const auto answer = client_->Localize(QueryOf(frames_, 0), {});
    EXPECT_TRUE(answer.ok()) << answer.status();
    return answer.ok() && Probe();
  }

  // The same where gRPC may have to end calls, whosever they are, because more
  // is arriving than it may hold: trying again helps.
  bool RetriedQuery() {
    for (int tries = 0; tries < 2000; ++tries) {
      const auto answer = client_->Localize(QueryOf(frames_, 0), {});
      if (answer.ok()) return Probe();
      if (!absl::IsUnavailable(answer.status()) &&
          !absl::IsResourceExhausted(answer.status())) {
        ADD_FAILURE() << answer.status();
        return false;
      }
    }
    return false;
  }

  // Runs `attack` kSideBySide times side by side, and `honest` meanwhile and
  // once afterwards, which must succeed each time.
  void Attack(const std::string& name, const std::function<void()>& attack,
              const std::function<bool()>& honest,
              int64_t max_growth_mib = kMaxGrowth_mib) {
    // Forget the peak so far.
    std::ofstream(absl::StrCat("/proc/", server_->pid(), "/clear_refs")) << 5;
    const int64_t before_mib = Memory_mib(server_->pid(), "VmRSS:");
    std::atomic<int> running = kSideBySide;
    std::vector<std::thread> attackers;
    for (int i = 0; i < kSideBySide; ++i) {
      attackers.emplace_back([&] {
        attack();
        --running;
      });
    }
    int asked = 0;
    int answered = 0;
    bool is_last = false;
    while (!is_last) {
      is_last = running == 0;
      if (!is_last) absl::SleepFor(kPauseOfHonest);
      ++asked;
      if (honest()) ++answered;
    }
    for (std::thread& attacker : attackers) attacker.join();
    const int64_t growth_mib =
        Memory_mib(server_->pid(), "VmHWM:") - before_mib;
    EXPECT_EQ(answered, asked) << name;
    EXPECT_LT(growth_mib, max_growth_mib) << name;
    EXPECT_TRUE(server_->IsRunning()) << name;
    std::printf("%-32s +%ld MiB, %d of %d honest calls answered\n",
                name.c_str(), static_cast<long>(growth_mib), answered, asked);
  }

  void PostHostile(const HostileRequest& request) const {
    httplib::Client client("http://" + http_address_);
    client.set_write_timeout(std::chrono::seconds(60));
    client.set_read_timeout(std::chrono::seconds(60));
    httplib::Headers headers;
    if (request.is_gzip) headers.emplace("Content-Encoding", "gzip");
    const auto answer =
        client.Post(request.path, headers, request.body, request.content_type);
    // Who is refused early may find the connection closed.
    EXPECT_GE(answer ? answer->status : 503, 400) << request.name;
  }

  void CallHostile(const HostileRequest& request, bool compressed) const {
    grpc::ChannelArguments arguments;
    // A connection of its own.
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    grpc::GenericStub stub(grpc::CreateCustomChannel(
        address_, grpc::InsecureChannelCredentials(), arguments));
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() +
                         std::chrono::seconds(60));
    if (compressed) context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
    const grpc::Slice slice(request.body);
    const grpc::ByteBuffer in(&slice, 1);
    grpc::ByteBuffer out;
    absl::Notification done;
    stub.UnaryCall(&context, request.method, grpc::StubOptions(), &in, &out,
                   [&](const grpc::Status& status) {
                     EXPECT_FALSE(status.ok()) << request.name;
                     done.Notify();
                   });
    done.WaitForNotification();
  }

  const dataset::Dataset frames_;
  std::string http_address_;
};

TEST_F(HostileTest, TakesNoMemoryOverHttp) {
  Start({"--drain-s", "0"});
  ASSERT_TRUE(HonestQuery());
  for (const HostileRequest& request : HostileHttpRequests()) {
    Attack(
        "http " + request.name, [&] { PostHostile(request); },
        [&] { return HonestQuery(); });
  }
}

TEST_F(HostileTest, TakesNoMemoryOverGrpc) {
  Start({"--drain-s", "0"});
  ASSERT_TRUE(HonestQuery());
  for (const HostileRequest& request : HostileGrpcRequests()) {
    Attack(
        "grpc " + request.name, [&] { CallHostile(request, false); },
        [&] { return RetriedQuery(); });
  }
  const HostileRequest bomb = HostileGrpcRequests().front();
  Attack(
      "grpc gzip " + bomb.name, [&] { CallHostile(bomb, true); },
      [&] { return HonestQuery(); });
}

// Who is not let in does not even get its request read.
TEST_F(HostileTest, TakesNothingWithoutAToken) {
  // No key at all: every token is refused.
  const std::string keys = PutFile("keys.json", R"({"keys":[]})");
  Start({"--drain-s", "0", "--auth-keys", keys});
  for (const HostileRequest& request : HostileHttpRequests()) {
    if (request.path == "/geopose") continue;
    Attack(
        "http " + request.name, [&] { PostHostile(request); },
        [&] { return Probe(); }, kMaxGrowthOfStrangers_mib);
  }
  const HostileRequest scenes = HostileGrpcRequests().front();
  for (const bool compressed : {true, false}) {
    Attack(
        "grpc " + scenes.name, [&] { CallHostile(scenes, compressed); },
        [&] { return Probe(); }, kMaxGrowthOfStrangers_mib);
  }
}

TEST_F(HostileTest, TellsStrangersNoNamesOfScenes) {
  const std::string keys = PutFile("keys.json", R"({"keys":[]})");
  Start({"--drain-s", "0", "--auth-keys", keys});
  httplib::Client client("http://" + http_address_);
  for (const char* path : {"/metrics", "/healthz", "/readyz", "/geopose"}) {
    const auto answer = client.Get(path);
    ASSERT_TRUE(answer);
    EXPECT_THAT(answer->body, ::testing::Not(HasSubstr("room"))) << path;
  }
  EXPECT_EQ(client.Get("/metrics")->status, 401);
}

// More connections than the server has, none of which ever says all it has to
// say.
TEST_F(HostileTest, SlowRequestsShutOutNobody) {
  Start({"--drain-s", "0"});
  std::vector<std::unique_ptr<http::RawClient>> slow;
  for (int i = 0; i < 300; ++i) {
    slow.push_back(std::make_unique<http::RawClient>(http_address_));
    slow.back()->Send(
        "POST /treeline.v1.SceneService/ListScenes HTTP/1.1\r\n"
        "Content-Type: application/json\r\nContent-Length: 1000000\r\n\r\n{");
    ASSERT_TRUE(Probe()) << i;
  }
  // Once it is known how slow they are, others are served too.
  httplib::Client client("http://" + http_address_);
  std::string answer;
  while (answer.find("room") == std::string::npos) {
    const auto scenes = client.Post("/treeline.v1.SceneService/ListScenes",
                                    "{}", "application/json");
    if (scenes) answer = scenes->body;
  }
  EXPECT_TRUE(server_->IsRunning());
}

}  // namespace
}  // namespace treeline
