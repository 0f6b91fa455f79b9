// What strangers and large requests get from the service, over a real loopback
// connection.
#include <grpcpp/generic/generic_stub.h>

#include <memory>
#include <string>

#include "common/base/byte_budget.h"
#include "common/base/error_info.h"
#include "common/wire/status.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/grpc_server_fixture.h"

namespace treeline::service {
namespace {

using ::testing::HasSubstr;

class GrpcServerLimits : public GrpcServerTest {};

// Nobody may do anything.
class NoAccess final : public AccessPolicy {
 public:
  absl::StatusOr<Client> Admit(const CallInfo&, Scope) override {
    return base::WithReason(absl::UnauthenticatedError("who are you?"),
                            "TOKEN_MISSING");
  }
};

// A call whose request never comes.
TEST_F(GrpcServerLimits, WhoIsNotLetInIsToldBeforeTheRequestIsRead) {
  NoAccess access;
  UseAccess(access);
  StartServer();
  grpc::GenericStub stub(channel_);
  for (const char* method :
       {"/treeline.v1.RelocalizationService/Localize",
        "/treeline.v1.RelocalizationService/LocalizeStream",
        "/treeline.v1.SceneService/ListScenes",
        "/treeline.v1.SceneService/LoadScene"}) {
    grpc::ClientContext context;
    grpc::CompletionQueue queue;
    const auto call = stub.PrepareCall(&context, method, &queue);
    const auto wait = [&queue] {
      void* tag = nullptr;
      bool ok = false;
      return queue.Next(&tag, &ok) && ok;
    };
    call->StartCall(nullptr);
    ASSERT_TRUE(wait());
    grpc::Status status;
    call->Finish(&status, nullptr);
    ASSERT_TRUE(wait());
    EXPECT_EQ(status.error_code(), grpc::UNAUTHENTICATED) << method;
    EXPECT_EQ(base::ErrorInfoOf(wire::FromGrpc(status)).reason,
              "TOKEN_MISSING");
  }
  EXPECT_EQ(observer_.records().size(), 4u);
}

TEST_F(GrpcServerLimits, HealthTellsStrangersNothingOfScenes) {
  NoAccess access;
  UseAccess(access);
  StartServer();
  const std::string check = "/grpc.health.v1.Health/Check";
  std::string answer;
  ASSERT_TRUE(CallRaw(check, "", &answer).ok());
  EXPECT_EQ(answer, "\x08\x01");
  for (const std::string name :
       {"treeline.scene.kitchen", "treeline.scene.x"}) {
    EXPECT_EQ(
        CallRaw(check,
                "\x0a" + std::string(1, static_cast<char>(name.size())) + name,
                &answer)
            .error_code(),
        grpc::UNAUTHENTICATED);
  }
}

TEST_F(GrpcServerLimits, MessagesThatWouldBecomeLargeAreRefused) {
  StartServer();
  v1::LocalizeRequest request;
  for (int i = 0; i < 20001; ++i) request.add_candidate_scenes();
  grpc::ClientContext context;
  v1::LocalizeResponse response;
  const grpc::Status status = stub_->Localize(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("fields"));
  EXPECT_TRUE(observer_.records().empty());
}

TEST_F(GrpcServerLimits, CompressedMessagesAreNotInflated) {
  StartServer();
  for (const auto algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    grpc::ClientContext context;
    context.set_compression_algorithm(algorithm);
    v1::LocalizeRequest request = TestRequest("kitchen");
    request.mutable_frame()->mutable_color()->set_encoded(
        std::string(1 << 20, 'x'));
    v1::LocalizeResponse response;
    EXPECT_EQ(stub_->Localize(&context, request, &response).error_code(),
              grpc::UNIMPLEMENTED);
  }
  EXPECT_TRUE(Localize("kitchen").ok());
}

TEST_F(GrpcServerLimits, RequestsForWhichThereIsNoMemoryAreTurnedAway) {
  base::ByteBudget budget(100000);
  base::ByteLease others(&budget);
  ASSERT_TRUE(others.Resize(99000));
  StartServer({.workers = 1, .queue = 1}, {.budget = &budget});
  const grpc::Status status = Localize("kitchen");
  EXPECT_EQ(status.error_code(), grpc::UNAVAILABLE);
  EXPECT_EQ(base::ErrorInfoOf(wire::FromGrpc(status)).reason, "OVERLOADED");
  ASSERT_EQ(observer_.records().size(), 1u);
  EXPECT_TRUE(observer_.records()[0].shed);
  others.Release();
  EXPECT_TRUE(Localize("kitchen").ok());
  server_.reset();
  EXPECT_EQ(budget.used_bytes(), 0u);
}

// grpc.health.v1.Watch tells the state, and each change.
TEST_F(GrpcServerLimits, HealthCanBeWatched) {
  StartServer();
  grpc::GenericStub stub(channel_);
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const auto call =
      stub.PrepareCall(&context, "/grpc.health.v1.Health/Watch", &queue);
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  call->StartCall(nullptr);
  ASSERT_TRUE(wait());
  const grpc::Slice everything(std::string{});
  call->WriteLast(grpc::ByteBuffer(&everything, 1), {}, nullptr);
  ASSERT_TRUE(wait());
  grpc::ByteBuffer answer;
  call->Read(&answer, nullptr);
  ASSERT_TRUE(wait());
  EXPECT_EQ(StringOf(answer), "\x08\x01");
  server_->AnnounceStop();
  call->Read(&answer, nullptr);
  ASSERT_TRUE(wait());
  EXPECT_EQ(StringOf(answer), "\x08\x02");
  context.TryCancel();
  grpc::Status status;
  call->Finish(&status, nullptr);
  EXPECT_TRUE(wait());
}

// Field 2 of GetServersResponse, `end`, or field 1, servers.
TEST_F(GrpcServerLimits, ChannelzAnswersOperatorsAlone) {
  StartServer();
  const auto admin = GrpcServer::Start(
      *dispatcher_, scenes_.repository(),
      {.kind = ListenerKind::kAdmin, .listen = "127.0.0.1:0"}, clock_);
  ASSERT_TRUE(admin.ok()) << admin.status();
  const std::string method = "/grpc.channelz.v1.Channelz/GetServers";
  std::string answer;
  EXPECT_EQ(CallRaw(method, "", &answer).error_code(), grpc::UNIMPLEMENTED);
  channel_ = grpc::CreateChannel((*admin)->address(),
                                 grpc::InsecureChannelCredentials());
  const grpc::Status status = CallRaw(method, "", &answer);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_FALSE(answer.empty());
}

}  // namespace
}  // namespace treeline::service
