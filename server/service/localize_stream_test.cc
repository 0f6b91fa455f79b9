// LocalizeStream over a real loopback connection.
#include "server/service/localize_stream.h"

#include <grpcpp/create_channel.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "common/base/error_info.h"
#include "common/wire/status.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/access_policy.h"
#include "server/service/grpc_server.h"
#include "server/service/service_dispatcher.h"
#include "server/service/service_test_util.h"
#include "treeline/v1/relocalization.grpc.pb.h"

namespace treeline::service {
namespace {

using ::testing::ElementsAre;

class LocalizeStreamTest : public testing::Test {
 protected:
  LocalizeStreamTest()
      : scenes_({{"kitchen", [](auto&, auto&) { return LocalizedEstimate(); }},
                 {"gate",
                  [this](auto&, const localizer::LocalizeOptions& options)
                      -> absl::StatusOr<localizer::PoseEstimate> {
                    const std::stop_callback on_stop(options.stop,
                                                     [this] { Open(); });
                    ++at_gate_;
                    absl::MutexLock lock(&mutex_);
                    mutex_.Await(absl::Condition(&open_));
                    return LocalizedEstimate();
                  }}}),
        dispatcher_(scenes_.repository(), access_, observer_, clock_,
                    {.workers = 2, .queue = 64}) {
    server_ = GrpcServer::Start(dispatcher_, scenes_.repository(),
                                {.listen = "127.0.0.1:0"}, clock_)
                  .value();
    stub_ = v1::RelocalizationService::NewStub(grpc::CreateChannel(
        server_->address(), grpc::InsecureChannelCredentials()));
    stream_ = stub_->LocalizeStream(&context_);
  }
  ~LocalizeStreamTest() override { Open(); }

  void Open() {
    absl::MutexLock lock(&mutex_);
    open_ = true;
  }
  void WaitAtGate(int calls) const {
    while (at_gate_ < calls) std::this_thread::yield();
  }

  static v1::LocalizeStreamRequest Request(uint64_t id,
                                           const std::string& scene) {
    v1::LocalizeStreamRequest request;
    request.set_id(id);
    *request.mutable_localize() = TestRequest(scene);
    return request;
  }
  void Send(uint64_t id, const std::string& scene) {
    ASSERT_TRUE(stream_->Write(Request(id, scene)));
  }
  // All answers until the stream ends.
  std::vector<v1::LocalizeStreamResponse> ReadAll() {
    std::vector<v1::LocalizeStreamResponse> answers;
    v1::LocalizeStreamResponse answer;
    while (stream_->Read(&answer)) answers.push_back(answer);
    return answers;
  }
  static std::vector<uint64_t> Ids(
      const std::vector<v1::LocalizeStreamResponse>& answers) {
    std::vector<uint64_t> ids;
    for (const auto& answer : answers) ids.push_back(answer.id());
    return ids;
  }

  absl::Mutex mutex_;
  bool open_ ABSL_GUARDED_BY(mutex_) = false;
  std::atomic<int> at_gate_{0};
  FakeScenes scenes_;
  RecordingObserver observer_;
  OpenAccess access_;
  base::SteadyClock clock_;
  ServiceDispatcher dispatcher_;
  std::unique_ptr<GrpcServer> server_;
  std::unique_ptr<v1::RelocalizationService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::LocalizeStreamRequest,
                                           v1::LocalizeStreamResponse>>
      stream_;
};

TEST_F(LocalizeStreamTest, AnswersComeInTheOrderOfTheFrames) {
  Send(7, "gate");
  Send(5, "kitchen");
  Send(9, "kitchen");
  // The second and the third are answered, and wait for the first.
  while (observer_.records().size() < 2) std::this_thread::yield();
  Open();
  stream_->WritesDone();
  const auto answers = ReadAll();
  EXPECT_THAT(Ids(answers), ElementsAre(7, 5, 9));
  EXPECT_TRUE(stream_->Finish().ok());
  EXPECT_EQ(answers[0].response().inliers(), 432);
  ASSERT_EQ(observer_.records().size(), 3u);
  EXPECT_STREQ(observer_.records()[0].rpc, "LocalizeStream");
}

TEST_F(LocalizeStreamTest, AFrameThatFailsEndsNothingButItself) {
  Send(1, "attic");
  Send(2, "kitchen");
  stream_->WritesDone();
  const auto answers = ReadAll();
  ASSERT_THAT(Ids(answers), ElementsAre(1, 2));
  const absl::Status error = wire::FromProto(answers[0].error());
  EXPECT_EQ(error.code(), absl::StatusCode::kNotFound);
  EXPECT_NE(base::ErrorInfoOf(error).reason, "");
  EXPECT_TRUE(answers[1].has_response());
  EXPECT_TRUE(stream_->Finish().ok());
}

TEST_F(LocalizeStreamTest, ACamerasOldFramesAreDropped) {
  v1::LocalizeStreamRequest first = Request(0, "gate");
  first.mutable_settings()->set_drop_oldest(true);
  first.mutable_settings()->set_max_pending(1);
  ASSERT_TRUE(stream_->Write(first));
  Send(1, "gate");
  WaitAtGate(2);
  for (uint64_t id = 2; id < 6; ++id) Send(id, "kitchen");
  // Of 2 to 5, one may wait.
  while (observer_.records().size() < 3) std::this_thread::yield();
  Open();
  stream_->WritesDone();
  const auto answers = ReadAll();
  ASSERT_THAT(Ids(answers), ElementsAre(0, 1, 2, 3, 4, 5));
  for (size_t id = 2; id < 5; ++id) {
    const absl::Status error = wire::FromProto(answers[id].error());
    EXPECT_EQ(error.code(), absl::StatusCode::kAborted) << id;
    EXPECT_EQ(base::ErrorInfoOf(error).reason, "FRAME_DROPPED") << id;
  }
  for (const size_t id : {0u, 1u, 5u}) EXPECT_TRUE(answers[id].has_response());
  EXPECT_TRUE(stream_->Finish().ok());
  EXPECT_EQ(observer_.records().size(), 6u);
}

TEST_F(LocalizeStreamTest, OtherwiseNoMoreIsReadThanMayBePending) {
  v1::LocalizeStreamRequest first = Request(0, "gate");
  first.mutable_settings()->set_max_pending(2);
  ASSERT_TRUE(stream_->Write(first));
  for (uint64_t id = 1; id < 6; ++id) Send(id, "kitchen");
  WaitAtGate(1);
  while (observer_.records().empty()) std::this_thread::yield();
  // The first holds one place, the second, answered, the other.
  EXPECT_EQ(observer_.records().size(), 1u);
  EXPECT_EQ(dispatcher_.load().queued, 0);
  Open();
  stream_->WritesDone();
  EXPECT_THAT(Ids(ReadAll()), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_TRUE(stream_->Finish().ok());
}

TEST_F(LocalizeStreamTest, AbsurdSettingsEndTheStream) {
  v1::LocalizeStreamRequest first = Request(0, "kitchen");
  first.mutable_settings()->set_max_pending(65);
  ASSERT_TRUE(stream_->Write(first));
  EXPECT_TRUE(ReadAll().empty());
  EXPECT_EQ(stream_->Finish().error_code(), grpc::INVALID_ARGUMENT);
}

TEST_F(LocalizeStreamTest, CancellingStopsTheWork) {
  Send(0, "gate");
  WaitAtGate(1);
  context_.TryCancel();
  EXPECT_EQ(stream_->Finish().error_code(), grpc::CANCELLED);
  while (observer_.records().empty()) std::this_thread::yield();
}

TEST_F(LocalizeStreamTest, AServerThatStopsAnswersWhatItHasRead) {
  Send(0, "kitchen");
  v1::LocalizeStreamResponse answer;
  ASSERT_TRUE(stream_->Read(&answer));
  Send(1, "gate");
  WaitAtGate(1);
  server_->AnnounceStop();
  Open();
  EXPECT_THAT(Ids(ReadAll()), ElementsAre(1));
  const absl::Status status = wire::FromGrpc(stream_->Finish());
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(base::ErrorInfoOf(status).reason, "DRAINING");
}

}  // namespace
}  // namespace treeline::service
