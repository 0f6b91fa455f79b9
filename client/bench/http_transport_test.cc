// Calls over HTTP against a server that answers, refuses and stalls on demand.
#include "client/bench/http_transport.h"

#include <httplib.h>

#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>

#include "absl/synchronization/notification.h"
#include "client/bench/load_generator.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::bench {
namespace {

using ::testing::HasSubstr;

class HttpTransportTest : public testing::Test {
 protected:
  HttpTransportTest() : checker_({std::nullopt}, {}) {
    server_.Post(
        "/treeline.v1.RelocalizationService/Localize",
        [this](const httplib::Request& request, httplib::Response& response) {
          Answer(request, response);
        });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
    v1::LocalizeRequest request;
    request.set_scene("room");
    const grpc::Slice bytes(request.SerializeAsString());
    items_.push_back({.scene = "room",
                      .stem = "",
                      .encoding = "",
                      .request = grpc::ByteBuffer(&bytes, 1),
                      .world_from_camera = {}});
  }
  ~HttpTransportTest() override {
    if (!go_on_.HasBeenNotified()) go_on_.Notify();
    server_.stop();
    thread_.join();
  }

  void Answer(const httplib::Request& request, httplib::Response& response) {
    const int call = ++calls_;
    if (stall_) go_on_.WaitForNotification();
    if (request.get_header_value("Content-Type") != "application/proto" ||
        request.get_header_value("Connect-Timeout-Ms").empty() ||
        request.body != std::string("\x0a\x04room")) {
      response.status = 400;
      return;
    }
    if (refuse_every_ > 0 && call % refuse_every_ == 0) {
      response.status = 503;
      // RetryInfo of 1 s.
      response.set_content(
          R"({"code":"unavailable","message":"full","details":[{"type":
              "google.rpc.RetryInfo","value":"CgIIAQ"}]})",
          "application/json");
      return;
    }
    v1::LocalizeResponse answer;
    answer.set_outcome(v1::OUTCOME_NOT_LOCALIZED);
    answer.set_scene("room");
    response.set_content(answer.SerializeAsString(), "application/proto");
  }

  std::string Address() const { return "127.0.0.1:" + std::to_string(port_); }

  std::unique_ptr<Transport> Open(const std::string& server) {
    auto transport =
        MakeHttpTransport(Target::kConnect, {.server = server}, 16, items_);
    EXPECT_TRUE(transport.ok()) << transport.status();
    return *std::move(transport);
  }

  // What one call comes to.
  absl::Status AskOnce(Transport& transport, std::chrono::milliseconds timeout,
                       bool cancel = false) {
    absl::Status status;
    absl::Notification done;
    const auto call = transport.Ask(0, 0, timeout, [&](const Reply& reply) {
      status = reply.status;
      done.Notify();
    });
    if (cancel) {
      while (calls_ == 0) std::this_thread::yield();
      call->Cancel();
    }
    done.WaitForNotification();
    return status;
  }

  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
  std::atomic<int> calls_ = 0;
  int refuse_every_ = 0;
  bool stall_ = false;
  absl::Notification go_on_;
  std::vector<WorkItem> items_;
  AnswerChecker checker_;
};

TEST_F(HttpTransportTest, GeneratesLoad) {
  refuse_every_ = 5;
  LoadGenerator generator(Open(Address()), items_, checker_);
  const LoadRun run =
      generator.Run({.concurrency = 4, .duration_s = 0.3, .warm_up_s = 0.05},
                    {}, [](const Glance&, double) {});
  EXPECT_GT(run.tally.counts[static_cast<size_t>(CallKind::kOk)], 8);
  EXPECT_GT(run.tally.counts[static_cast<size_t>(CallKind::kShed)], 2);
  EXPECT_EQ(run.tally.counts[static_cast<size_t>(CallKind::kOk)] +
                run.tally.counts[static_cast<size_t>(CallKind::kShed)],
            run.tally.total());
  EXPECT_EQ(run.tally.checks.different, 0);
  EXPECT_EQ(run.tally.server.total.count(), 0);
}

TEST_F(HttpTransportTest, OffersARate) {
  LoadGenerator generator(Open(Address()), items_, checker_);
  const LoadRun run =
      generator.Run({.rate_per_s = 200, .duration_s = 0.5, .warm_up_s = 0}, {},
                    [](const Glance&, double) {});
  // A Poisson process of 100: ten standard deviations.
  EXPECT_NEAR(static_cast<double>(run.tally.total()), 100, 100);
  EXPECT_GT(run.tally.total(), 0);
}

TEST_F(HttpTransportTest, CallsEndInTime) {
  stall_ = true;
  const auto transport = Open(Address());
  EXPECT_EQ(AskOnce(*transport, std::chrono::milliseconds(30)).code(),
            absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(AskOnce(*transport, std::chrono::milliseconds(-1)).code(),
            absl::StatusCode::kDeadlineExceeded);
}

TEST_F(HttpTransportTest, CallsAreCancelled) {
  stall_ = true;
  const auto transport = Open(Address());
  EXPECT_EQ(AskOnce(*transport, std::chrono::minutes(2), true).code(),
            absl::StatusCode::kCancelled);
}

TEST_F(HttpTransportTest, AServerThatIsNotThereIsUnavailable) {
  const auto transport = Open("127.0.0.1:1");
  EXPECT_EQ(AskOnce(*transport, std::chrono::seconds(30)).code(),
            absl::StatusCode::kUnavailable);
}

TEST_F(HttpTransportTest, ServersAreAskedInTurn) {
  // Of two, one is not there.
  const auto transport = Open(Address() + ",127.0.0.1:1");
  for (size_t number = 0; number < 4; ++number) {
    absl::Status status;
    absl::Notification done;
    transport->Ask(number, 0, std::chrono::seconds(30),
                   [&](const Reply& reply) {
                     status = reply.status;
                     done.Notify();
                   });
    done.WaitForNotification();
    EXPECT_EQ(status.ok(), number % 2 == 0) << status;
  }
}

TEST_F(HttpTransportTest, RefusesWhatItCannotDo) {
  const auto error = [&](const relocalizer::ConnectOptions& options) {
    return std::string(MakeHttpTransport(Target::kConnect, options, 1, items_)
                           .status()
                           .message());
  };
  EXPECT_THAT(error({.server = "127.0.0.1:1",
                     .tls = {.ca_file = "/ca.pem", .server_name = "other"}}),
              HasSubstr("--tls-server-name"));
  EXPECT_THAT(error({.server = "127.0.0.1:1", .token_file = "/no/token"}),
              HasSubstr("/no/token"));
  // gRPC's names are none over HTTP, and curl would ask a host "unix".
  for (const char* server :
       {"unix:/run/x", "dns:///localhost:1", "127.0.0.1:1@robot"}) {
    EXPECT_THAT(error({.server = server}), HasSubstr("HOST:PORT")) << server;
  }
  ASSERT_EQ(setenv("TREELINE_TEST_TOKEN", "secret", 1), 0);
  EXPECT_THAT(
      error({.server = "unix:80", .token_variable = "TREELINE_TEST_TOKEN"}),
      HasSubstr("in the clear"));
}

TEST_F(HttpTransportTest, ATokenPassesNoProxy) {
  // As a proxy the server would be asked, and there is none at its address.
  ASSERT_EQ(setenv("TREELINE_TEST_TOKEN", "secret", 1), 0);
  ASSERT_EQ(setenv("http_proxy", Address().c_str(), 1), 0);
  auto transport = MakeHttpTransport(
      Target::kConnect,
      {.server = "127.0.0.1:1", .token_variable = "TREELINE_TEST_TOKEN"}, 1,
      items_);
  ASSERT_TRUE(transport.ok()) << transport.status();
  EXPECT_EQ(AskOnce(**transport, std::chrono::seconds(30)).code(),
            absl::StatusCode::kUnavailable);
  ASSERT_EQ(unsetenv("http_proxy"), 0);
  EXPECT_EQ(calls_, 0);
}

}  // namespace
}  // namespace treeline::bench
