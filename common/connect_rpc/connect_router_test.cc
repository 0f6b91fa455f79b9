#include "common/connect_rpc/connect_router.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <vector>

#include "common/connect_rpc/connect_message.h"
#include "treeline/v1/navigation.pb.h"

namespace treeline::connect_rpc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kUnary[] = "/treeline.v1.Test/Cancel";
constexpr char kStream[] = "/treeline.v1.Test/StreamState";

class TestClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now; }
  base::MonotonicTime now{std::chrono::seconds(100)};
};

// Keeps what is written, up to so many writes.
class TestWriter final : public http::HttpBodyWriter {
 public:
  bool Write(absl::string_view bytes) override {
    if (written.size() >= max_writes) return false;
    written.emplace_back(bytes);
    return true;
  }
  size_t max_writes = 100;
  std::vector<std::string> written;
};

class ConnectRouterTest : public ::testing::Test {
 protected:
  ConnectRouterTest() : router_(clock_, {.require_protocol_version = true}) {
    router_.AddUnary<v1::CancelRequest>(
        kUnary,
        [this](const ConnectCall& call, const v1::CancelRequest& request)
            -> absl::StatusOr<v1::AddObstacleResponse> {
          deadline_ = call.deadline;
          if (request.goal_id() == 0) return absl::NotFoundError("no goal");
          v1::AddObstacleResponse response;
          response.set_name("box");
          return response;
        });
    router_.AddStream<v1::StreamStateRequest, v1::StreamStateResponse>(
        kStream,
        [this](const v1::StreamStateRequest& request, ConnectStream& stream) {
          rate_hz_ = request.rate_hz();
          return run_(stream);
        });
  }
  http::HttpRequest Request(const char* path, const char* type,
                            std::string body) const {
    return {
        .method = "POST",
        .path = path,
        .headers = {{"content-type", type}, {"connect-protocol-version", "1"}},
        .body = std::move(body),
        .arrival = clock_.Now()};
  }
  // What the stream writes.
  std::vector<std::string> Stream(const http::HttpRequest& request) {
    const http::HttpResponse response = router_.Handle(request);
    EXPECT_EQ(response.status, 200);
    EXPECT_TRUE(response.stream);
    response.stream(writer_);
    return writer_.written;
  }

  TestClock clock_;
  ConnectRouter router_;
  TestWriter writer_;
  base::MonotonicTime deadline_;
  double rate_hz_ = 0;
  std::function<absl::Status(ConnectStream&)> run_ = [](ConnectStream&) {
    return absl::OkStatus();
  };
};

TEST_F(ConnectRouterTest, AnswersUnaryCallsInTheirOwnFormat) {
  const http::HttpResponse json =
      router_.Handle(Request(kUnary, "application/json", R"({"goalId":"3"})"));
  EXPECT_EQ(json.content_type, "application/json");
  EXPECT_EQ(json.body, R"({"name":"box"})");
  const http::HttpResponse proto =
      router_.Handle(Request(kUnary, "application/proto", "\x08\x03"));
  EXPECT_EQ(proto.content_type, "application/proto");
  EXPECT_EQ(proto.body,
            "\x0a\x03"
            "box");
}

TEST_F(ConnectRouterTest, UnaryErrorsAreJson) {
  const http::HttpResponse missing =
      router_.Handle(Request(kUnary, "application/proto", ""));
  EXPECT_EQ(missing.status, 404);
  EXPECT_EQ(missing.content_type, "application/json");
  EXPECT_EQ(missing.body, R"({"code":"not_found","message":"no goal"})");
  EXPECT_EQ(router_.Handle(Request(kUnary, "application/json", "{")).status,
            400);
}

TEST_F(ConnectRouterTest, BodiesAreBounded) {
  for (const char* path : {kUnary, kStream}) {
    const http::HttpResponse response = router_.Handle(
        Request(path, "application/proto", std::string((64 << 10) + 1, '\n')));
    EXPECT_EQ(response.status, 413);
    EXPECT_THAT(response.body, HasSubstr("resource_exhausted"));
  }
}

TEST_F(ConnectRouterTest, MessagesTakeOfTheBudgetUntilTheyAreAnswered) {
  base::ByteBudget budget(1000);
  ConnectRouter router(clock_, {.budget = &budget});
  uint64_t held = 0;
  router.AddUnary<v1::CancelRequest>(
      kUnary, [&](const ConnectCall&, const v1::CancelRequest&) {
        held = budget.used_bytes();
        return absl::StatusOr<v1::CancelResponse>(v1::CancelResponse());
      });
  router.AddStream<v1::StreamStateRequest, v1::StreamStateResponse>(
      kStream, [&](const v1::StreamStateRequest&, ConnectStream&) {
        held = budget.used_bytes();
        return absl::OkStatus();
      });
  const http::HttpRequest unary =
      Request(kUnary, "application/json", R"({"goalId":"3"})");
  EXPECT_EQ(router.Handle(unary).status, 200);
  EXPECT_EQ(held, unary.body.size());
  router
      .Handle(Request(kStream, "application/connect+json",
                      InEnvelope(R"({"rateHz":2})")))
      .stream(writer_);
  EXPECT_EQ(held, 12u);
  EXPECT_EQ(budget.used_bytes(), 0u);
}

TEST_F(ConnectRouterTest, NothingIsParsedWhereThereIsNoMemory) {
  base::ByteBudget budget(1000);
  base::ByteLease others(&budget);
  ASSERT_TRUE(others.Resize(999));
  ConnectRouter router(clock_, {.budget = &budget});
  router.AddUnary<v1::CancelRequest>(
      kUnary,
      [](const ConnectCall&,
         const v1::CancelRequest&) -> absl::StatusOr<v1::CancelResponse> {
        ADD_FAILURE() << "called";
        return v1::CancelResponse();
      });
  const http::HttpResponse response =
      router.Handle(Request(kUnary, "application/json", R"({"goalId":"3"})"));
  EXPECT_EQ(response.status, 503);
  EXPECT_THAT(response.body, HasSubstr("OVERLOADED"));
}

TEST_F(ConnectRouterTest, AsksWhoIsLetInByTheHead) {
  ConnectRouter router(clock_);
  absl::Status admission;
  router.AddUnary<v1::CancelRequest>(
      kUnary,
      [](const ConnectCall& call, const v1::CancelRequest&) {
        EXPECT_EQ(call.request.client, "tester");
        return absl::StatusOr<v1::CancelResponse>(v1::CancelResponse());
      },
      [&](http::HttpRequest& request) {
        request.client = "tester";
        return admission;
      });
  http::HttpRequest request = Request(kUnary, "application/json", "{}");
  EXPECT_FALSE(router.Admit(request).has_value());
  EXPECT_EQ(router.Handle(request).status, 200);
  admission = absl::UnauthenticatedError("who are you?");
  EXPECT_EQ(router.Admit(request).value().status, 401);
  // Of one that says nothing about it.
  request.path = kUnary;
  EXPECT_FALSE(router_.Admit(request).has_value());
}

TEST_F(ConnectRouterTest, SaysWhatIsServedElsewhere) {
  router_.AddUnimplemented("/treeline.v1.Test/Other", "over gRPC only");
  for (const char* type : {"application/json", "application/connect+json"}) {
    const auto answer =
        router_.CheckHead(Request("/treeline.v1.Test/Other", type, ""));
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->status, 501);
    EXPECT_THAT(answer->body, HasSubstr("over gRPC only"));
  }
}

TEST_F(ConnectRouterTest, DeadlinesCountFromTheArrival) {
  http::HttpRequest request = Request(kUnary, "application/proto", "\x08\x03");
  router_.Handle(request);
  EXPECT_EQ(deadline_, base::MonotonicTime::max());
  request.headers["connect-timeout-ms"] = "250";
  router_.Handle(request);
  EXPECT_EQ(deadline_, clock_.now + std::chrono::milliseconds(250));
  for (const char* wrong : {"-1", "1s", "12345678901", " 1"}) {
    request.headers["connect-timeout-ms"] = wrong;
    EXPECT_EQ(router_.Handle(request).status, 400) << wrong;
  }
}

TEST_F(ConnectRouterTest, StreamsMessagesAndHowItEnded) {
  run_ = [](ConnectStream& stream) {
    v1::StreamStateResponse message;
    message.add_events()->set_number(5);
    EXPECT_TRUE(stream.Write(message));
    return absl::UnavailableError("the agent is stopping");
  };
  const auto written = Stream(Request(kStream, "application/connect+json",
                                      InEnvelope(R"({"rateHz":2})")));
  EXPECT_EQ(rate_hz_, 2);
  EXPECT_THAT(written, ElementsAre(InEnvelope(R"({"events":[{"number":"5"}]})"),
                                   EndOfConnectStream(absl::UnavailableError(
                                       "the agent is stopping"))));
}

TEST_F(ConnectRouterTest, AStreamThatCannotBeginSaysSoInItsEnd) {
  const http::HttpResponse response = router_.Handle(
      Request(kStream, "application/connect+proto", "no envelope"));
  EXPECT_EQ(response.status, 200);
  EXPECT_FALSE(response.stream);
  EXPECT_EQ(response.content_type, "application/connect+proto");
  EXPECT_EQ(response.body[0], '\2');
  EXPECT_THAT(response.body, HasSubstr("invalid_argument"));
}

TEST_F(ConnectRouterTest, AStreamIsNotSilentForLong) {
  run_ = [this](ConnectStream& stream) {
    EXPECT_FALSE(stream.IsGone());
    EXPECT_TRUE(writer_.written.empty());
    clock_.now += std::chrono::seconds(5);
    EXPECT_FALSE(stream.IsGone());
    EXPECT_THAT(writer_.written, ElementsAre(InEnvelope("")));
    writer_.max_writes = 1;
    clock_.now += std::chrono::seconds(5);
    EXPECT_TRUE(stream.IsGone());
    return absl::CancelledError("gone");
  };
  Stream(Request(kStream, "application/connect+proto", InEnvelope("")));
}

TEST_F(ConnectRouterTest, AStreamEndsAtItsDeadline) {
  run_ = [this](ConnectStream& stream) {
    EXPECT_FALSE(stream.IsGone());
    clock_.now += std::chrono::milliseconds(30);
    EXPECT_TRUE(stream.IsGone());
    EXPECT_FALSE(stream.Write(v1::StreamStateResponse()));
    return absl::CancelledError("the caller has gone");
  };
  http::HttpRequest request =
      Request(kStream, "application/connect+proto", InEnvelope(""));
  request.headers["connect-timeout-ms"] = "30";
  EXPECT_THAT(Stream(request), ElementsAre(HasSubstr("deadline_exceeded")));
}

TEST_F(ConnectRouterTest, AClientThatHangsUpIsNoticed) {
  std::array<int, 2> ends{};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
  run_ = [&](ConnectStream& stream) {
    EXPECT_FALSE(stream.IsGone());
    close(ends[1]);
    EXPECT_TRUE(stream.IsGone());
    return absl::CancelledError("the caller has gone");
  };
  http::HttpRequest request =
      Request(kStream, "application/connect+proto", InEnvelope(""));
  request.socket = ends[0];
  Stream(request);
  close(ends[0]);
}

TEST_F(ConnectRouterTest, RefusesByTheHeadWhatIsNoCall) {
  const auto status = [&](const http::HttpRequest& request) {
    const auto answer = router_.CheckHead(request);
    return answer.has_value() ? answer->status : 0;
  };
  const http::HttpRequest unary = Request(kUnary, "application/json", "");
  EXPECT_EQ(status(unary), 0);
  EXPECT_EQ(status(Request(kStream, "application/connect+json", "")), 0);
  EXPECT_EQ(status(Request("/treeline.v1.Test/No", "application/json", "")),
            404);
  EXPECT_EQ(status(Request(kUnary, "application/connect+json", "")), 415);
  EXPECT_EQ(status(Request(kStream, "application/json", "")), 415);
  EXPECT_EQ(status(Request(kUnary, "text/plain", "")), 415);
  http::HttpRequest other = unary;
  other.method = "GET";
  EXPECT_EQ(status(other), 405);
  other = unary;
  other.headers.erase("connect-protocol-version");
  EXPECT_EQ(status(other), 400);
  other.headers["connect-protocol-version"] = "2";
  EXPECT_EQ(status(other), 400);
}

TEST_F(ConnectRouterTest, TheVersionMayBeLeftAwayWhereItIsNotRequired) {
  ConnectRouter lenient(clock_);
  lenient.AddUnary<v1::PauseRequest>(
      kUnary, [](const ConnectCall&, const v1::PauseRequest&) {
        return absl::StatusOr<v1::PauseResponse>(v1::PauseResponse());
      });
  http::HttpRequest request = Request(kUnary, "application/json", "{}");
  request.headers.erase("connect-protocol-version");
  EXPECT_FALSE(lenient.CheckHead(request).has_value());
  EXPECT_EQ(lenient.Handle(request).body, "{}");
}

}  // namespace
}  // namespace treeline::connect_rpc
