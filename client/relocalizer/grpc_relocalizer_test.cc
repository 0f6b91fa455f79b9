// The client against a server that misbehaves on demand.
#include "client/relocalizer/grpc_relocalizer.h"

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "client/relocalizer/relocalizer.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "treeline/v1/relocalization.grpc.pb.h"
#include "treeline/v1/scenes.grpc.pb.h"

namespace treeline::relocalizer {
namespace {

// Gives the statuses it was told, one a call, and then answers.
class ScriptedService final : public v1::RelocalizationService::Service,
                              public v1::SceneService::Service {
 public:
  grpc::Status Localize(grpc::ServerContext* context,
                        const v1::LocalizeRequest* request,
                        v1::LocalizeResponse* response) override {
    const grpc::Status status = Next();
    if (during_localize) during_localize(*context);
    response->set_outcome(v1::OUTCOME_NOT_LOCALIZED);
    response->set_scene(request->scene());
    response->set_samples(
        static_cast<int>(request->frame().color().encoded().size()));
    return status;
  }
  grpc::Status ListScenes(grpc::ServerContext*, const v1::ListScenesRequest*,
                          v1::ListScenesResponse* response) override {
    const grpc::Status status = Next();
    response->add_scenes()->set_scene("kitchen");
    response->add_scenes()->set_scene("office");
    return status;
  }
  grpc::Status GetScene(grpc::ServerContext*,
                        const v1::GetSceneRequest* request,
                        v1::GetSceneResponse* response) override {
    const grpc::Status status = Next();
    response->mutable_scene()->set_scene(request->scene());
    return status;
  }

  void FailNext(int times, grpc::StatusCode code, const std::string& message) {
    absl::MutexLock lock(&mutex_);
    failures_ = times;
    failure_ = grpc::Status(code, message);
  }
  int calls() const {
    absl::MutexLock lock(&mutex_);
    return calls_;
  }

  std::function<void(grpc::ServerContext&)> during_localize;

 private:
  grpc::Status Next() {
    absl::MutexLock lock(&mutex_);
    ++calls_;
    return failures_-- > 0 ? failure_ : grpc::Status::OK;
  }

  mutable absl::Mutex mutex_;
  int calls_ ABSL_GUARDED_BY(mutex_) = 0;
  int failures_ ABSL_GUARDED_BY(mutex_) = 0;
  grpc::Status failure_ ABSL_GUARDED_BY(mutex_);
};

class GrpcRelocalizerTest : public testing::Test {
 protected:
  void SetUp() override {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(),
                             &port);
    builder.SetMaxReceiveMessageSize(32 << 20);
    builder.RegisterService(
        static_cast<v1::RelocalizationService::Service*>(&service_));
    builder.RegisterService(static_cast<v1::SceneService::Service*>(&service_));
    server_ = builder.BuildAndStart();
    ASSERT_NE(server_, nullptr);
    address_ = "127.0.0.1:" + std::to_string(port);
    client_ = ConnectRelocalizer({.server = address_}).value();
  }

  static LocalizeQuery Query(size_t bytes = 10) {
    LocalizeQuery query;
    query.scene = "kitchen";
    query.frame.color = wire::EncodedImage{std::string(bytes, 'x')};
    return query;
  }

  ScriptedService service_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
  std::unique_ptr<Relocalizer> client_;
};

TEST_F(GrpcRelocalizerTest, AsksAndTimesTheAnswer) {
  const auto answer = client_->Localize(Query(), {});
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->scene, "kitchen");
  EXPECT_EQ(answer->samples, 10);
  EXPECT_GT(answer->round_trip_ms, 0);
}

// x-treeline-scene of a call; empty: none.
std::string NamedScene(const grpc::ServerContext& context) {
  const auto& metadata = context.client_metadata();
  const auto at = metadata.find("x-treeline-scene");
  return at == metadata.end()
             ? ""
             : std::string(at->second.data(), at->second.size());
}

TEST_F(GrpcRelocalizerTest, NamesTheSceneForBalancers) {
  std::string named;
  service_.during_localize = [&](const grpc::ServerContext& context) {
    named = NamedScene(context);
  };
  LocalizeQuery query = Query();
  query.scene = "kitchen-2.new_1";
  ASSERT_TRUE(client_->Localize(query, {}).ok());
  EXPECT_EQ(named, "kitchen-2.new_1");
}

TEST_F(GrpcRelocalizerTest, CallsBelongToTheTraceOfTheirCaller) {
  std::string told;
  service_.during_localize = [&](const grpc::ServerContext& context) {
    const auto at = context.client_metadata().find("traceparent");
    told = at == context.client_metadata().end()
               ? "none"
               : std::string(at->second.data(), at->second.size());
  };
  const std::string trace =
      "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
  ASSERT_TRUE(client_->Localize(Query(), {.traceparent = trace}).ok());
  EXPECT_EQ(told, trace);
  // gRPC itself would end a call for such metadata.
  for (const std::string& none : {std::string(), std::string("odd\n"),
                                  std::string(55, '\n'), trace + "\n"}) {
    ASSERT_TRUE(client_->Localize(Query(), {.traceparent = none}).ok());
    EXPECT_EQ(told, "none");
  }
}

TEST_F(GrpcRelocalizerTest, WhatIsNoSceneNameIsInTheRequestAlone) {
  std::string named;
  service_.during_localize = [&](const grpc::ServerContext& context) {
    named = NamedScene(context);
  };
  for (const std::string& scene :
       {std::string(), std::string("a b"),
        std::string("k\xc3\xbc"
                    "che"),
        std::string("a\nb"), std::string(129, 'x')}) {
    named = "not asked";
    LocalizeQuery query = Query();
    query.scene = scene;
    const auto answer = client_->Localize(query, {});
    ASSERT_TRUE(answer.ok()) << answer.status();
    EXPECT_EQ(answer->scene, scene);
    EXPECT_EQ(named, "");
  }
}

TEST_F(GrpcRelocalizerTest, ListsAndGetsScenes) {
  const auto scenes = client_->ListScenes({});
  ASSERT_TRUE(scenes.ok()) << scenes.status();
  ASSERT_EQ(scenes->size(), 2u);
  EXPECT_EQ((*scenes)[1].name, "office");
  const auto scene = client_->GetScene("attic", {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->name, "attic");
}

TEST_F(GrpcRelocalizerTest, TriesAgainWhenTheServerIsUnavailable) {
  service_.FailNext(2, grpc::UNAVAILABLE, "overloaded");
  const auto answer = client_->Localize(Query(), {});
  EXPECT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(service_.calls(), 3);
}

// As a server that goes down ends calls that arrive meanwhile.
TEST_F(GrpcRelocalizerTest, TriesAgainWhenTheServerCancels) {
  service_.FailNext(1, grpc::CANCELLED, "CANCELLED");
  const auto answer = client_->Localize(Query(), {});
  EXPECT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(service_.calls(), 2);
}

// gRPC's own retry buffer would give up on this size in silence.
TEST_F(GrpcRelocalizerTest, TriesAgainWithLargeRequestsToo) {
  service_.FailNext(1, grpc::UNAVAILABLE, "overloaded");
  const auto answer = client_->Localize(Query(8 << 20), {});
  EXPECT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(service_.calls(), 2);
}

TEST_F(GrpcRelocalizerTest, GivesUpAfterAllAttempts) {
  service_.FailNext(100, grpc::UNAVAILABLE, "overloaded");
  const auto answer = client_->Localize(Query(), {});
  EXPECT_EQ(answer.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(answer.status().message(), "overloaded");
  EXPECT_EQ(service_.calls(), 4);
}

TEST_F(GrpcRelocalizerTest, OneAttemptIsOne) {
  client_ = ConnectRelocalizer({.server = address_, .max_attempts = 1}).value();
  service_.FailNext(1, grpc::UNAVAILABLE, "overloaded");
  EXPECT_FALSE(client_->Localize(Query(), {}).ok());
  EXPECT_EQ(service_.calls(), 1);
}

TEST_F(GrpcRelocalizerTest, OtherErrorsAreNotTriedAgain) {
  service_.FailNext(1, grpc::INVALID_ARGUMENT, "frame.color: missing");
  const auto answer = client_->Localize(Query(), {});
  EXPECT_EQ(answer.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(answer.status().message(), "frame.color: missing");
  EXPECT_EQ(service_.calls(), 1);
}

TEST_F(GrpcRelocalizerTest, TheTimeoutEndsTheCall) {
  absl::Notification gave_up;
  service_.during_localize = [&](grpc::ServerContext&) {
    gave_up.WaitForNotification();
  };
  const auto answer =
      client_->Localize(Query(), {.timeout = std::chrono::milliseconds(100)});
  gave_up.Notify();
  server_->Shutdown();  // until then its threads use gave_up
  EXPECT_EQ(answer.status().code(), absl::StatusCode::kDeadlineExceeded);
}

TEST_F(GrpcRelocalizerTest, TheStopTokenCancelsHereAndThere) {
  std::stop_source stop;
  absl::Notification answered;
  service_.during_localize = [&](grpc::ServerContext& context) {
    stop.request_stop();
    answered.WaitForNotification();
    // The cancellation travels; it is there before the server goes down.
    while (!context.IsCancelled()) std::this_thread::yield();
  };
  const auto answer = client_->Localize(Query(), {.stop = stop.get_token()});
  EXPECT_EQ(answer.status().code(), absl::StatusCode::kCancelled);
  answered.Notify();
  server_->Shutdown();  // until then its threads use `answered`
  EXPECT_EQ(service_.calls(), 1);
}

TEST_F(GrpcRelocalizerTest, ANoLongerRunningServerIsUnavailable) {
  ASSERT_TRUE(client_->Localize(Query(), {}).ok());
  server_->Shutdown();
  server_.reset();
  const auto answer = client_->Localize(Query(), {});
  EXPECT_EQ(answer.status().code(), absl::StatusCode::kUnavailable);
}

TEST_F(GrpcRelocalizerTest, RequestsOverTheLimitAreNotSent) {
  client_ =
      ConnectRelocalizer({.server = address_, .max_message_mib = 1}).value();
  const auto answer = client_->Localize(Query(2 << 20), {});
  EXPECT_EQ(answer.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(service_.calls(), 0);
}

}  // namespace
}  // namespace treeline::relocalizer
