#include "common/tracing/otlp_exporter.h"

#include <httplib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::tracing {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

// Of what must not take its time; how long it takes is bounded by 0.5 s more.
constexpr milliseconds kPatience{300};
constexpr auto kLongestStop = std::chrono::seconds(20);

// A collector that answers as the test says.
class Collector {
 public:
  using Answer =
      std::function<void(const httplib::Request&, httplib::Response&)>;

  explicit Collector(Answer answer) {
    server_.Post("/v1/traces", [this, answer = std::move(answer)](
                                   const httplib::Request& request,
                                   httplib::Response& response) {
      answer(request, response);
      ++requests_;
    });
    server_.Post("/elsewhere", [this](const httplib::Request&,
                                      httplib::Response&) { ++elsewhere_; });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~Collector() {
    server_.stop();
    thread_.join();
  }

  TracingOptions Options() const {
    TracingOptions options;
    options.endpoint =
        "http://127.0.0.1:" + std::to_string(port_) + "/v1/traces";
    options.headers = {{"x-key", "s3cret"}};
    return options;
  }
  int requests() const { return requests_; }
  int elsewhere() const { return elsewhere_; }

 private:
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
  std::atomic<int> requests_ = 0;
  std::atomic<int> elsewhere_ = 0;
};

// Takes connections and says nothing; or, closed, takes none.
class Silence {
 public:
  Silence() {
    fd_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof(address)),
              0);
    listen(fd_, 8);
    socklen_t length = sizeof(address);
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &length);
    options_.endpoint =
        "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/";
  }
  ~Silence() { Close(); }
  void Close() {
    if (fd_ >= 0) close(std::exchange(fd_, -1));
  }
  const TracingOptions& Options() const { return options_; }

 private:
  int fd_ = -1;
  TracingOptions options_;
};

ExporterLimits Quick() {
  return {.delay = milliseconds(1),
          .first_wait = milliseconds(1),
          .longest_wait = milliseconds(2)};
}

std::vector<Span> Spans(size_t count) {
  Span span;
  span.context = {"0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331", true};
  span.name = "query";
  return std::vector<Span>(count, span);
}

std::unique_ptr<OtlpExporter> Started(const TracingOptions& options,
                                      const ExporterLimits& limits = Quick(),
                                      OtlpExporter::OnHealth on_health = {}) {
  auto exporter =
      OtlpExporter::Start(options, "1", std::move(on_health), limits);
  EXPECT_TRUE(exporter.ok()) << exporter.status();
  return *std::move(exporter);
}

// Until the exporter is through with so many, whatever came of them.
void WaitFor(const OtlpExporter& exporter, uint64_t spans) {
  for (;;) {
    const SpanCounts counts = exporter.counts();
    if (counts.sent + counts.failed + counts.dropped >= spans) return;
    std::this_thread::yield();
  }
}

void ExpectQuickStop(OtlpExporter& exporter) {
  const auto began = std::chrono::steady_clock::now();
  exporter.Stop(kPatience);
  EXPECT_LT(std::chrono::steady_clock::now() - began, kLongestStop);
}

TEST(OtlpExporter, SendsWhatItGetsWithItsHeaders) {
  std::string type;
  std::string key;
  std::string body;
  Collector collector([&](const httplib::Request& request, httplib::Response&) {
    type = request.get_header_value("Content-Type");
    key = request.get_header_value("x-key");
    body = request.body;
  });
  const auto exporter = Started(collector.Options());
  exporter->Add(Spans(3));
  WaitFor(*exporter, 3);
  EXPECT_EQ(exporter->counts().sent, 3u);
  EXPECT_EQ(type, "application/x-protobuf");
  EXPECT_EQ(key, "s3cret");
  EXPECT_THAT(body, HasSubstr("query"));
}

TEST(OtlpExporter, AStopSendsWhatWaits) {
  Collector collector([](const httplib::Request&, httplib::Response&) {});
  const auto exporter = Started(
      collector.Options(), {.max_batch = 2, .delay = std::chrono::hours(1)});
  exporter->Add(Spans(1));
  exporter->Add(Spans(4));
  exporter->Stop(std::chrono::minutes(1));
  EXPECT_EQ(exporter->counts().sent, 5u);
  EXPECT_EQ(collector.requests(), 3);
  exporter->Add(Spans(1));
  EXPECT_EQ(exporter->counts().dropped, 1u);
}

TEST(OtlpExporter, TriesAgainWhileTheCollectorHasTooMuchToDo) {
  std::atomic<int> calls = 0;
  Collector collector(
      [&](const httplib::Request&, httplib::Response& response) {
        const int call = calls++;
        if (call == 0) response.status = 429;
        if (call == 1) response.status = 503;
      });
  std::vector<absl::Status> health;
  const auto exporter =
      Started(collector.Options(), Quick(),
              [&](const absl::Status& status) { health.push_back(status); });
  exporter->Add(Spans(2));
  WaitFor(*exporter, 2);
  exporter->Stop(kPatience);
  EXPECT_EQ(exporter->counts().sent, 2u);
  EXPECT_EQ(calls, 3);
  // Told once of each change.
  ASSERT_EQ(health.size(), 2u);
  EXPECT_TRUE(absl::IsUnavailable(health[0]));
  EXPECT_TRUE(health[1].ok());
}

TEST(OtlpExporter, LeavesTheCollectorAloneForAsLongAsItWants) {
  std::atomic<int> calls = 0;
  std::chrono::steady_clock::time_point first;
  std::chrono::steady_clock::time_point second;
  Collector collector(
      [&](const httplib::Request&, httplib::Response& response) {
        if (calls++ == 0) {
          first = std::chrono::steady_clock::now();
          response.status = 503;
          response.set_header("Retry-After", "1");
        } else {
          second = std::chrono::steady_clock::now();
        }
      });
  const auto exporter = Started(collector.Options());
  exporter->Add(Spans(1));
  WaitFor(*exporter, 1);
  EXPECT_GE(second - first, milliseconds(900));
}

TEST(OtlpExporter, WhatIsRefusedIsNotSentAgain) {
  Collector collector([](const httplib::Request&, httplib::Response& response) {
    response.status = 400;
  });
  const auto exporter = Started(collector.Options());
  exporter->Add(Spans(2));
  WaitFor(*exporter, 2);
  EXPECT_EQ(exporter->counts().failed, 2u);
  EXPECT_EQ(collector.requests(), 1);
}

// Headers with keys must not go where a stranger points.
TEST(OtlpExporter, FollowsNoRedirection) {
  Collector collector([](const httplib::Request&, httplib::Response& response) {
    response.set_redirect("/elsewhere", 307);
  });
  const auto exporter = Started(collector.Options());
  exporter->Add(Spans(1));
  WaitFor(*exporter, 1);
  EXPECT_EQ(exporter->counts().failed, 1u);
  EXPECT_EQ(collector.elsewhere(), 0);
}

TEST(OtlpExporter, AHugeAnswerIsNotReadToItsEnd) {
  std::atomic<size_t> told = 0;
  Collector collector(
      [&](const httplib::Request&, httplib::Response& response) {
        response.set_content_provider(
            size_t{1} << 30, "text/plain",
            [&](size_t, size_t, httplib::DataSink& sink) {
              const std::string piece(65536, 'x');
              told += piece.size();
              return sink.write(piece.data(), piece.size());
            });
      });
  const auto exporter = Started(collector.Options());
  exporter->Add(Spans(1));
  WaitFor(*exporter, 1);
  EXPECT_EQ(exporter->counts().sent, 1u);
  EXPECT_LT(told, size_t{64} << 20);
}

TEST(OtlpExporter, ACollectorThatIsNotThereCostsItsSpansAlone) {
  Silence nobody;
  nobody.Close();
  ExporterLimits limits = Quick();
  limits.max_attempts = 2;
  const auto exporter = Started(nobody.Options(), limits);
  exporter->Add(Spans(2));
  WaitFor(*exporter, 2);
  EXPECT_EQ(exporter->counts().failed, 2u);
  exporter->Add(Spans(1));
  ExpectQuickStop(*exporter);
}

TEST(OtlpExporter, ACollectorThatNeverAnswersHoldsNobodyUp) {
  const Silence silence;
  ExporterLimits limits = Quick();
  limits.max_queued = 8;
  limits.max_batch = 4;
  const auto exporter = Started(silence.Options(), limits);
  for (int i = 0; i < 100; ++i) exporter->Add(Spans(1));
  EXPECT_GE(exporter->counts().dropped, 88u);
  ExpectQuickStop(*exporter);
  EXPECT_EQ(exporter->counts().dropped, 100u);
}

TEST(OtlpExporter, NeedsAnEndpoint) {
  EXPECT_TRUE(
      absl::IsInvalidArgument(OtlpExporter::Start({}, "1", {}).status()));
}

}  // namespace
}  // namespace treeline::tracing
