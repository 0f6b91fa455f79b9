// The generator against a server that answers, stalls and refuses on demand.
#include "client/bench/load_generator.h"

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "treeline/v1/relocalization.grpc.pb.h"

namespace treeline::bench {
namespace {

class FakeService final : public v1::RelocalizationService::CallbackService {
 public:
  grpc::ServerUnaryReactor* Localize(grpc::CallbackServerContext* context,
                                     const v1::LocalizeRequest* request,
                                     v1::LocalizeResponse* response) override {
    class Reactor final : public grpc::ServerUnaryReactor {
      void OnCancel() override {
        // Only calls that are never answered live until here.
        if (!answered) Finish(grpc::Status::CANCELLED);
      }
      void OnDone() override { delete this; }

     public:
      bool answered = false;
    };
    auto* reactor = new Reactor;
    const int call = ++calls;
    if (!answers) return reactor;
    reactor->answered = true;
    response->set_scene(request->scene());
    response->set_outcome(v1::OUTCOME_NOT_LOCALIZED);
    if (refuse_every > 0 && call % refuse_every == 0) {
      context->AddTrailingMetadata("grpc-retry-pushback-ms", "10");
      reactor->Finish({grpc::UNAVAILABLE, "full"});
    } else {
      reactor->Finish(grpc::Status::OK);
    }
    return reactor;
  }

  // Answers each frame at once; ends the stream after `stream_frames`.
  grpc::ServerBidiReactor<v1::LocalizeStreamRequest,
                          v1::LocalizeStreamResponse>*
  LocalizeStream(grpc::CallbackServerContext*) override {
    class Reactor final
        : public grpc::ServerBidiReactor<v1::LocalizeStreamRequest,
                                         v1::LocalizeStreamResponse> {
     public:
      explicit Reactor(FakeService& service) : service_(service) {
        StartRead(&request_);
      }
      void OnReadDone(bool ok) override {
        if (!ok || frames_++ == service_.stream_frames) {
          Finish(ok ? grpc::Status(grpc::UNAVAILABLE, "draining")
                    : grpc::Status::OK);
          return;
        }
        ++service_.calls;
        response_.set_id(request_.id());
        response_.mutable_response()->set_outcome(v1::OUTCOME_NOT_LOCALIZED);
        response_.mutable_response()->set_scene(request_.localize().scene());
        StartWrite(&response_);
      }
      void OnWriteDone(bool ok) override {
        if (ok) StartRead(&request_);
      }
      void OnCancel() override {}
      void OnDone() override { delete this; }

     private:
      FakeService& service_;
      int frames_ = 0;
      v1::LocalizeStreamRequest request_;
      v1::LocalizeStreamResponse response_;
    };
    return new Reactor(*this);
  }

  int stream_frames = -1;  // no end
  std::atomic<int> calls = 0;
  int refuse_every = 0;
  bool answers = true;
};

class LoadGeneratorTest : public testing::Test {
 protected:
  LoadGeneratorTest() : checker_({std::nullopt, std::nullopt}, {}) {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(),
                             &port);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
    for (const char* scene : {"room", "lab"}) {
      v1::LocalizeRequest request;
      request.set_scene(scene);
      const grpc::Slice bytes(request.SerializeAsString());
      items_.push_back({.scene = scene,
                        .stem = "",
                        .encoding = "",
                        .request = grpc::ByteBuffer(&bytes, 1),
                        .world_from_camera = {}});
    }
    generator_ = MakeGenerator(1);
  }
  ~LoadGeneratorTest() override { generator_.reset(); }

  std::unique_ptr<LoadGenerator> MakeGenerator(int attempts) {
    return std::make_unique<LoadGenerator>(
        std::vector<relocalizer::Connection>{
            relocalizer::Connection::Open(
                {.server = address_, .max_attempts = attempts})
                .value()},
        items_, checker_);
  }

  LoadRun Run(const LoadOptions& options, const std::stop_token& stop = {}) {
    return generator_->Run(options, stop, [](const Glance&, double) {});
  }

  static int64_t Count(const LoadRun& run, CallKind kind) {
    return run.tally.counts[static_cast<size_t>(kind)];
  }

  FakeService service_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
  std::vector<WorkItem> items_;
  AnswerChecker checker_;
  std::unique_ptr<LoadGenerator> generator_;
};

TEST_F(LoadGeneratorTest, TheClosedLoopAsksAsFastAsItIsAnswered) {
  const LoadRun run =
      Run({.concurrency = 4, .duration_s = 0.3, .warm_up_s = 0.05});
  EXPECT_GT(Count(run, CallKind::kOk), 20);
  EXPECT_EQ(run.tally.total(), Count(run, CallKind::kOk));
  EXPECT_NEAR(run.measured_s, 0.3, 1e-6);
  EXPECT_FALSE(run.interrupted);
  // Every call is counted, those of the warm-up too.
  EXPECT_EQ(generator_->AllCalls().at({absl::StatusCode::kOk, ""}),
            service_.calls);
  EXPECT_GT(service_.calls, run.tally.total());
  // Both queries are asked in turn, and answered alike: the first answer to
  // each is new.
  EXPECT_EQ(run.tally.answered_by.size(), 2u);
  EXPECT_EQ(run.tally.checks.different, 0);
}

TEST_F(LoadGeneratorTest, TheOpenLoopKeepsItsOwnTimes) {
  const LoadOptions options = {
      .rate_per_s = 400, .duration_s = 0.5, .warm_up_s = 0, .seed = 5};
  const LoadRun run = Run(options);
  const LoadRun again = Run(options);
  // The seed fixes how many arrivals there are; 200 on the average.
  EXPECT_EQ(run.tally.total(), again.tally.total());
  EXPECT_NEAR(static_cast<double>(run.tally.total()), 200, 60);
  EXPECT_EQ(run.send_lag.count(), run.tally.total());
}

TEST_F(LoadGeneratorTest, AStalledServerDoesNotSlowTheArrivals) {
  service_.answers = false;
  const LoadRun run = Run({.rate_per_s = 200,
                           .duration_s = 0.5,
                           .warm_up_s = 0,
                           .deadline_ms = 200,
                           .seed = 5});
  EXPECT_NEAR(static_cast<double>(Count(run, CallKind::kDeadline)), 100, 40);
  EXPECT_EQ(run.tally.total(), Count(run, CallKind::kDeadline));
}

TEST_F(LoadGeneratorTest, WhatCannotBeSentIsSaturation) {
  service_.answers = false;
  const LoadRun run = Run({.rate_per_s = 200,
                           .duration_s = 0.3,
                           .warm_up_s = 0,
                           .deadline_ms = 2000,
                           .max_outstanding = 10});
  EXPECT_EQ(run.tally.total(), 10);
  EXPECT_GT(run.not_sent, 0);
  EXPECT_TRUE(run.saturated());
}

TEST_F(LoadGeneratorTest, ShedCallsAreCountedOncePerCall) {
  service_.refuse_every = 3;
  const LoadRun run =
      Run({.concurrency = 2, .duration_s = 0.2, .warm_up_s = 0});
  EXPECT_EQ(Count(run, CallKind::kShed), service_.calls / 3);
  EXPECT_EQ(run.tally.total(), service_.calls);
}

TEST_F(LoadGeneratorTest, RetriesHideWhatIsShed) {
  service_.refuse_every = 3;
  generator_ = MakeGenerator(4);
  const LoadRun run =
      Run({.concurrency = 1, .duration_s = 0.2, .warm_up_s = 0});
  EXPECT_EQ(run.tally.total(), Count(run, CallKind::kOk));
  EXPECT_GT(service_.calls, run.tally.total());
}

TEST_F(LoadGeneratorTest, AShareIsCancelled) {
  service_.answers = false;
  const LoadRun run = Run({.rate_per_s = 200,
                           .duration_s = 0.5,
                           .warm_up_s = 0,
                           .deadline_ms = 1000,
                           .cancel_share = 1,
                           .cancel_after_ms = 50});
  EXPECT_EQ(run.tally.total(), Count(run, CallKind::kCancelled));
  EXPECT_LT(run.tally.latencies[static_cast<size_t>(CallKind::kCancelled)]
                .from_send.Percentile_ms(50),
            900);
}

TEST_F(LoadGeneratorTest, AServerThatIsGoneIsNotAskedAMillionTimes) {
  server_->Shutdown();
  const LoadRun run =
      Run({.concurrency = 1, .duration_s = 0.2, .warm_up_s = 0});
  EXPECT_GT(Count(run, CallKind::kFailed), 0);
  // 10 ms between them.
  EXPECT_LE(run.tally.total(), 21);
}

TEST_F(LoadGeneratorTest, InterruptedItReportsWhatItHas) {
  service_.answers = false;
  std::stop_source stop;
  const LoadRun run = generator_->Run(
      {.concurrency = 3, .duration_s = 3600, .warm_up_s = 0}, stop.get_token(),
      [&](const Glance&, double) { stop.request_stop(); });
  EXPECT_TRUE(run.interrupted);
  EXPECT_EQ(run.abandoned, 3);
  EXPECT_EQ(run.tally.total(), 0);
  EXPECT_LT(run.measured_s, 3600);
}

TEST_F(LoadGeneratorTest, EveryQueryIsAskedOnceBeforeTheLoad) {
  ASSERT_TRUE(generator_->AskOnce(1, 1000, {}).ok());
  EXPECT_EQ(service_.calls, 2);
  checker_.LoadBegins();
  const LoadRun run =
      Run({.concurrency = 1, .duration_s = 0.1, .warm_up_s = 0});
  EXPECT_EQ(run.tally.checks.as_before_load, run.tally.total());
}

TEST_F(LoadGeneratorTest, AFirstErrorNamesTheQuery) {
  service_.refuse_every = 2;
  const absl::Status status = generator_->AskOnce(1, 1000, {});
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("lab"));
}

TEST_F(LoadGeneratorTest, StreamsAskWithoutWaitingForTheAnswers) {
  const LoadRun run = Run({.concurrency = 2,
                           .stream_window = 4,
                           .duration_s = 0.3,
                           .warm_up_s = 0});
  EXPECT_GT(Count(run, CallKind::kOk), 20);
  EXPECT_EQ(run.tally.total(), Count(run, CallKind::kOk));
  EXPECT_EQ(run.tally.total(), service_.calls);
  EXPECT_EQ(run.tally.answered_by.size(), 2u);
  EXPECT_EQ(run.tally.checks.different, 0);
}

TEST_F(LoadGeneratorTest, StreamsThatTheServerEndsBeginAgain) {
  service_.stream_frames = 5;
  const LoadRun run = Run({.concurrency = 1,
                           .stream_window = 1,
                           .duration_s = 0.3,
                           .warm_up_s = 0});
  // Of each stream the sixth frame has no answer.
  EXPECT_GT(Count(run, CallKind::kFailed), 1);
  EXPECT_EQ(Count(run, CallKind::kOk), service_.calls);
  EXPECT_GE(Count(run, CallKind::kOk), 5 * Count(run, CallKind::kFailed));
}

TEST(LoadOptions, NonsenseIsRefused) {
  EXPECT_TRUE(LoadOptions{}.Validate().ok());
  EXPECT_FALSE(LoadOptions{.concurrency = 0}.Validate().ok());
  EXPECT_FALSE(LoadOptions{.rate_per_s = -1}.Validate().ok());
  LoadOptions streams{.stream_window = 1};
  EXPECT_TRUE(streams.Validate().ok());
  streams.rate_per_s = 5;
  EXPECT_FALSE(streams.Validate().ok());
  EXPECT_FALSE(LoadOptions{.duration_s = 0}.Validate().ok());
  EXPECT_FALSE(LoadOptions{.warm_up_s = -1}.Validate().ok());
  EXPECT_FALSE(LoadOptions{.deadline_ms = 0}.Validate().ok());
  EXPECT_FALSE(LoadOptions{.cancel_share = 1.5}.Validate().ok());
}

}  // namespace
}  // namespace treeline::bench
