// The service over a real loopback connection.
#include "server/service/grpc_server.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>

#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/synchronization/blocking_counter.h"
#include "absl/synchronization/notification.h"
#include "common/base/error_info.h"
#include "common/base/listen_address.h"
#include "common/wire/status.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/grpc_server_fixture.h"
#include "treeline/v1/relocalization.grpc.pb.h"
#include "treeline/v1/scenes.grpc.pb.h"

namespace treeline::service {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

TEST_F(GrpcServerTest, Localizes) {
  StartServer();
  v1::LocalizeResponse response;
  const grpc::Status status = Localize("kitchen", &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.outcome(), v1::OUTCOME_LOCALIZED);
  EXPECT_EQ(response.world_from_camera().translation_m().x(), 1.5);
}

TEST_F(GrpcServerTest, ErrorsKeepCodeAndMessage) {
  StartServer();
  const grpc::Status status = Localize("attic");
  EXPECT_EQ(status.error_code(), grpc::NOT_FOUND);
  EXPECT_THAT(status.error_message(), HasSubstr("attic"));
}

TEST_F(GrpcServerTest, ListsScenesWithTheirState) {
  StartServer();
  const auto stub = v1::SceneService::NewStub(channel_);
  grpc::ClientContext context;
  v1::ListScenesResponse list;
  ASSERT_TRUE(stub->ListScenes(&context, {}, &list).ok());
  ASSERT_EQ(list.scenes_size(), 5);
  EXPECT_EQ(list.scenes(0).scene(), "broken");
  EXPECT_EQ(list.scenes(0).state(), v1::SCENE_STATE_FAILED);
  EXPECT_EQ(list.scenes(0).failure().code(), "DATA_LOSS");
  EXPECT_EQ(list.scenes(2).scene(), "kitchen");
  EXPECT_EQ(list.scenes(2).state(), v1::SCENE_STATE_READY);
}

TEST_F(GrpcServerTest, GetsOneScene) {
  StartServer();
  const auto stub = v1::SceneService::NewStub(channel_);
  const auto get = [&](const std::string& name, v1::GetSceneResponse& out) {
    grpc::ClientContext context;
    v1::GetSceneRequest request;
    request.set_scene(name);
    return stub->GetScene(&context, request, &out).error_code();
  };
  v1::GetSceneResponse response;
  EXPECT_EQ(get("kitchen", response), grpc::OK);
  EXPECT_EQ(response.scene().model().method(), "kitchen");
  EXPECT_EQ(get("attic", response), grpc::NOT_FOUND);
  EXPECT_EQ(get("../kitchen", response), grpc::INVALID_ARGUMENT);
}

TEST_F(GrpcServerTest, ExceptionsBecomeInternalErrorsWithoutDetails) {
  StartServer();
  const grpc::Status status = Localize("throws");
  EXPECT_EQ(status.error_code(), grpc::INTERNAL);
  EXPECT_EQ(status.error_message().find("secret"), std::string::npos);
  ASSERT_EQ(observer_.records().size(), 1u);
  EXPECT_EQ(observer_.records()[0].internal_error, "secret of the house");
  EXPECT_TRUE(Localize("kitchen").ok());
}

// A call that does not block the test.
struct PendingCall {
  grpc::ClientContext context;
  v1::LocalizeRequest request;
  v1::LocalizeResponse response;
  grpc::Status status;
  absl::Notification done;
};

std::unique_ptr<PendingCall> Begin(
    v1::RelocalizationService::Stub& stub, const std::string& scene,
    const std::function<void()>& on_done = [] {}) {
  auto call = std::make_unique<PendingCall>();
  call->request = TestRequest(scene);
  stub.async()->Localize(&call->context, &call->request, &call->response,
                         [&call = *call, on_done](grpc::Status status) {
                           call.status = std::move(status);
                           on_done();
                           call.done.Notify();
                         });
  return call;
}

TEST_F(GrpcServerTest, AFullQueueTurnsCallsAwayWithAPushback) {
  StartServer({.workers = 1, .queue = 1});
  const auto working = Begin(*stub_, "gate");
  at_gate_.WaitForNotification();
  // The worker is busy: of three more calls one can wait.
  absl::BlockingCounter turned_away(2);
  std::vector<std::unique_ptr<PendingCall>> calls;
  for (int i = 0; i < 3; ++i) {
    calls.push_back(Begin(*stub_, "kitchen", [&] {
      if (!gate_.HasBeenNotified()) turned_away.DecrementCount();
    }));
  }
  turned_away.Wait();
  gate_.Notify();
  working->done.WaitForNotification();
  EXPECT_TRUE(working->status.ok());
  int answered = 0;
  for (const auto& call : calls) {
    call->done.WaitForNotification();
    if (call->status.ok()) {
      ++answered;
      continue;
    }
    EXPECT_EQ(call->status.error_code(), grpc::UNAVAILABLE);
    EXPECT_THAT(call->status.error_message(), HasSubstr("queue is full"));
    const auto& trailers = call->context.GetServerTrailingMetadata();
    const auto pushback = trailers.find("grpc-retry-pushback-ms");
    ASSERT_NE(pushback, trailers.end());
    int pushback_ms = 0;
    ASSERT_TRUE(absl::SimpleAtoi(
        std::string(pushback->second.data(), pushback->second.size()),
        &pushback_ms));
    EXPECT_GE(pushback_ms, 10);
    EXPECT_LE(pushback_ms, 2000);
  }
  EXPECT_EQ(answered, 1);
}

TEST_F(GrpcServerTest, ScenesAreListedWhileTheQueueIsFull) {
  StartServer({.workers = 1, .queue = 1});
  const auto working = Begin(*stub_, "gate");
  at_gate_.WaitForNotification();
  const auto waiting = Begin(*stub_, "kitchen");
  const auto stub = v1::SceneService::NewStub(channel_);
  grpc::ClientContext context;
  v1::ListScenesResponse list;
  EXPECT_TRUE(stub->ListScenes(&context, {}, &list).ok());
  gate_.Notify();
  working->done.WaitForNotification();
  waiting->done.WaitForNotification();
}

TEST_F(GrpcServerTest, CancellingFreesTheWorker) {
  StartServer();
  const auto call = Begin(*stub_, "patient");
  at_gate_.WaitForNotification();
  call->context.TryCancel();
  call->done.WaitForNotification();
  EXPECT_EQ(call->status.error_code(), grpc::CANCELLED);
  // The only worker is free again.
  EXPECT_TRUE(Localize("kitchen").ok());
  EXPECT_EQ(observer_.records()[0].status.code(), absl::StatusCode::kCancelled);
}

TEST_F(GrpcServerTest, TheDeadlineFreesTheWorker) {
  StartServer();
  ASSERT_TRUE(Localize("kitchen").ok());  // connects
  PendingCall call;
  call.context.set_deadline(std::chrono::system_clock::now() +
                            std::chrono::milliseconds(200));
  const grpc::Status status =
      stub_->Localize(&call.context, TestRequest("patient"), &call.response);
  EXPECT_EQ(status.error_code(), grpc::DEADLINE_EXCEEDED);
  EXPECT_TRUE(Localize("kitchen").ok());
  ASSERT_EQ(observer_.records().size(), 3u);
  // The client's clock may be the first to give up, and then it cancels.
  EXPECT_THAT(
      observer_.records()[1].status.code(),
      AnyOf(absl::StatusCode::kDeadlineExceeded, absl::StatusCode::kCancelled));
}

TEST_F(GrpcServerTest, OversizeRequestsAreRefusedAndTheServerLives) {
  StartServer({.workers = 1, .queue = 1}, {.max_message_mib = 1});
  v1::LocalizeRequest request = TestRequest("kitchen");
  request.mutable_frame()->mutable_color()->set_encoded(
      std::string(2 << 20, 'x'));
  grpc::ClientContext context;
  v1::LocalizeResponse response;
  EXPECT_EQ(stub_->Localize(&context, request, &response).error_code(),
            grpc::RESOURCE_EXHAUSTED);
  EXPECT_TRUE(Localize("kitchen").ok());
}

TEST_F(GrpcServerTest, EveryCallIsObservedOnce) {
  StartServer({.workers = 2, .queue = 100});
  std::vector<std::unique_ptr<PendingCall>> calls;
  for (int i = 0; i < 10; ++i) {
    calls.push_back(Begin(*stub_, "kitchen"));
    calls.push_back(Begin(*stub_, "attic"));
    calls.push_back(Begin(*stub_, "throws"));
  }
  for (const auto& call : calls) call->done.WaitForNotification();
  std::map<absl::StatusCode, int> count;
  for (const CallRecord& record : observer_.records()) {
    EXPECT_STREQ(record.rpc, "Localize");
    EXPECT_THAT(record.peer, HasSubstr("127.0.0.1"));
    ++count[record.status.code()];
  }
  EXPECT_EQ(count[absl::StatusCode::kOk], 10);
  EXPECT_EQ(count[absl::StatusCode::kNotFound], 10);
  EXPECT_EQ(count[absl::StatusCode::kInternal], 10);
  EXPECT_EQ(observer_.records().size(), 30u);
}

// grpc.health.v1: an empty request asks for the whole server; the answer is
// field 1, 1 for SERVING and 2 for NOT_SERVING.
TEST_F(GrpcServerTest, HealthTurnsWhenAStopIsAnnouncedAndCallsGoOn) {
  StartServer();
  const std::string check = "/grpc.health.v1.Health/Check";
  std::string answer;
  ASSERT_TRUE(CallRaw(check, "", &answer).ok());
  EXPECT_EQ(answer, "\x08\x01");
  server_->AnnounceStop();
  ASSERT_TRUE(CallRaw(check, "", &answer).ok());
  EXPECT_EQ(answer, "\x08\x02");
  EXPECT_TRUE(Localize("kitchen").ok());
}

TEST_F(GrpcServerTest, HealthKnowsTheScenes) {
  StartServer();
  const std::string check = "/grpc.health.v1.Health/Check";
  const auto ask = [&](const std::string& service) {
    return "\x0a" + std::string(1, static_cast<char>(service.size())) + service;
  };
  std::string answer;
  ASSERT_TRUE(CallRaw(check, ask("treeline.scene.kitchen"), &answer).ok());
  EXPECT_EQ(answer, "\x08\x01");
  ASSERT_TRUE(CallRaw(check, ask("treeline.scene.broken"), &answer).ok());
  EXPECT_EQ(answer, "\x08\x02");
  EXPECT_EQ(CallRaw(check, ask("treeline.scene.attic"), &answer).error_code(),
            grpc::NOT_FOUND);
}

TEST_F(GrpcServerTest, ErrorsCarryAReasonForPrograms) {
  StartServer();
  grpc::ClientContext context;
  v1::LocalizeResponse response;
  v1::LocalizeRequest request = TestRequest("kitchen");
  request.mutable_frame()->mutable_depth()->set_unit_m(0);
  const absl::Status status =
      wire::FromGrpc(stub_->Localize(&context, request, &response));
  EXPECT_EQ(base::ErrorInfoOf(status).reason, "INVALID_REQUEST");
  EXPECT_EQ(base::ErrorInfoOf(status).metadata.at("field"),
            "frame.depth.unit_m");
}

TEST_F(GrpcServerTest, OnlyTheAdminListenerAdministers) {
  StartServer();
  const auto admin = GrpcServer::Start(
      *dispatcher_, scenes_.repository(),
      {.kind = ListenerKind::kAdmin, .listen = "127.0.0.1:0"}, clock_);
  ASSERT_TRUE(admin.ok()) << admin.status();
  const auto load = [](const std::shared_ptr<grpc::Channel>& channel) {
    grpc::ClientContext context;
    v1::LoadSceneRequest request;
    request.set_scene("kitchen");
    v1::LoadSceneResponse response;
    return v1::SceneService::NewStub(channel)->LoadScene(&context, request,
                                                         &response);
  };
  EXPECT_EQ(load(channel_).error_code(), grpc::PERMISSION_DENIED);
  const auto channel = grpc::CreateChannel((*admin)->address(),
                                           grpc::InsecureChannelCredentials());
  EXPECT_TRUE(load(channel).ok());
  // And it does not localize.
  grpc::ClientContext context;
  v1::LocalizeResponse response;
  EXPECT_EQ(v1::RelocalizationService::NewStub(channel)
                ->Localize(&context, TestRequest("kitchen"), &response)
                .error_code(),
            grpc::UNIMPLEMENTED);
}

// The names of the services, by grpc.reflection of that version.
std::string ListedServices(const std::shared_ptr<grpc::Channel>& channel,
                           const std::string& version) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  // A ServerReflectionRequest: field 7 is list_services.
  const grpc::Slice list_services(std::string("\x3a\x01*"));
  const grpc::ByteBuffer request(&list_services, 1);
  grpc::ByteBuffer answer;
  absl::Notification done;
  stub.UnaryCall(
      &context,
      "/grpc.reflection." + version + ".ServerReflection/ServerReflectionInfo",
      {}, &request, &answer, [&](const grpc::Status& status) {
        EXPECT_TRUE(status.ok()) << status.error_message();
        done.Notify();
      });
  done.WaitForNotification();
  return StringOf(answer);
}

TEST_F(GrpcServerTest, ReflectionNamesTheServices) {
  StartServer();
  for (const char* version : {"v1", "v1alpha"}) {
    EXPECT_THAT(ListedServices(channel_, version),
                AllOf(HasSubstr("treeline.v1.RelocalizationService"),
                      HasSubstr("treeline.v1.SceneService"),
                      HasSubstr("grpc.health.v1.Health")));
  }
}

TEST_F(GrpcServerTest, StopLetsCallsInFlightFinish) {
  StartServer();
  const auto call = Begin(*stub_, "gate");
  at_gate_.WaitForNotification();
  const base::ListenAddress address =
      *base::ParseListenAddress(server_->address());
  std::thread stopping([&] { server_->Stop(std::chrono::seconds(60)); });
  // The port is free as soon as the server has begun to stop.
  while (!base::TryBind(address).ok()) std::this_thread::yield();
  gate_.Notify();
  call->done.WaitForNotification();
  stopping.join();
  EXPECT_TRUE(call->status.ok()) << call->status.error_message();
}

TEST_F(GrpcServerTest, StopCancelsWhatOutlastsItsGrace) {
  StartServer();
  const auto call = Begin(*stub_, "patient");
  at_gate_.WaitForNotification();
  server_->Stop(std::chrono::milliseconds(50));
  call->done.WaitForNotification();
  EXPECT_FALSE(call->status.ok());
  EXPECT_EQ(observer_.records()[0].status.code(), absl::StatusCode::kCancelled);
}

TEST_F(GrpcServerTest, APortInUseIsAnErrorThatNamesIt) {
  StartServer();
  const auto second = GrpcServer::Start(*dispatcher_, scenes_.repository(),
                                        {.listen = server_->address()}, clock_);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr(server_->address()));
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("in use"));
  EXPECT_TRUE(Localize("kitchen").ok());
}

TEST_F(GrpcServerTest, ReportsThePortThatItWasGiven) {
  StartServer();
  EXPECT_THAT(server_->address(),
              ::testing::MatchesRegex("127\\.0\\.0\\.1:[1-9][0-9]*"));
}

}  // namespace
}  // namespace treeline::service
