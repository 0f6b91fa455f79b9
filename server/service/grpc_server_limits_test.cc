// What strangers and large requests get from the service, over a real loopback
// connection.
#include <grpcpp/generic/generic_stub.h>
#include <sys/socket.h>

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "common/base/byte_budget.h"
#include "common/base/descriptor.h"
#include "common/base/error_info.h"
#include "common/flood_guard/testing_connection.h"
#include "common/flood_guard/testing_frames.h"
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

// What a client sends that asks to be told nothing, and then localizes: RFC
// 9113, and RFC 7541 for the fields.
std::string CallThatTakesNoAnswer(const v1::LocalizeRequest& request) {
  using flood_guard::TestFrame;
  constexpr int kEndStream = 1;
  const std::string no_window("\0\4\0\0\0\0", 6);
  const auto field = [](char index, const std::string& value) {
    return std::string({index, static_cast<char>(value.size())}) + value;
  };
  const std::string headers =
      "\x83\x86" +  // POST, http
      field('\x44', "/treeline.v1.RelocalizationService/Localize") +
      field('\x41', "treeline") + field('\x5f', "application/grpc") +
      std::string("\x40\x02te\x08trailers");
  const std::string message = request.SerializeAsString();
  const auto size = static_cast<unsigned>(message.size());
  std::string data(1, '\0');
  for (const int shift : {24, 16, 8, 0}) {
    data.push_back(static_cast<char>(size >> shift & 0xff));
  }
  return flood_guard::kTestPreface +
         TestFrame(flood_guard::kTestSettings, 0, 0, no_window) +
         TestFrame(flood_guard::kTestHeaders, flood_guard::kTestEndHeaders, 1,
                   headers) +
         TestFrame(flood_guard::kTestData, kEndStream, 1, data + message);
}

// Whether it becomes true, within ten seconds.
template <typename Condition>
bool Becomes(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

TEST_F(GrpcServerLimits, AClientThatTakesNoAnswerHoldsNoMemoryOfRequests) {
  base::ByteBudget budget(1 << 20);
  StartServer({.workers = 1, .queue = 1}, {.budget = &budget});
  const base::Descriptor client(
      flood_guard::ConnectForTest(server_->address()));
  ASSERT_GE(client.get(), 0);
  const std::string call = CallThatTakesNoAnswer(TestRequest("gate"));
  ASSERT_EQ(send(client.get(), call.data(), call.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(call.size()));
  at_gate_.WaitForNotification();
  EXPECT_GT(budget.used_bytes(), 0u);
  gate_.Notify();
  EXPECT_TRUE(Becomes([&] { return budget.used_bytes() == 0; }));
  ASSERT_EQ(observer_.records().size(), 1u);
  EXPECT_TRUE(observer_.records()[0].status.ok());
}

TEST_F(GrpcServerLimits, LargeAnswersForWhichThereIsNoMemoryAreTurnedAway) {
  std::map<std::string, LocalizeFunction> rooms;
  for (int i = 0; i < 400; ++i) {
    rooms["room-with-a-long-name-" + std::to_string(i)] = [](auto&, auto&) {
      return LocalizedEstimate();
    };
  }
  const FakeScenes scenes(rooms, /*keep_files=*/true);
  ServiceDispatcher dispatcher(scenes.repository(), access_, observer_, clock_,
                               {});
  base::ByteBudget answers(100000);
  base::ByteLease others(&answers);
  ASSERT_TRUE(others.Resize(99000));
  const auto server =
      GrpcServer::Start(dispatcher, scenes.repository(),
                        {.listen = "127.0.0.1:0", .answers = &answers}, clock_);
  ASSERT_TRUE(server.ok()) << server.status();
  channel_ = grpc::CreateChannel((*server)->address(),
                                 grpc::InsecureChannelCredentials());
  const std::string method = "/treeline.v1.SceneService/ListScenes";
  std::string answer;
  const grpc::Status status = CallRaw(method, "", &answer);
  EXPECT_EQ(status.error_code(), grpc::UNAVAILABLE);
  EXPECT_EQ(base::ErrorInfoOf(wire::FromGrpc(status)).reason, "OVERLOADED");
  others.Release();
  EXPECT_TRUE(CallRaw(method, "", &answer).ok());
  EXPECT_GT(answer.size(), 16384u);
  EXPECT_TRUE(Becomes([&] { return answers.used_bytes() == 0; }));
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
