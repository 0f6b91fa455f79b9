// Streams against a server that the test writes itself.
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "absl/synchronization/notification.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "client/relocalizer/relocalizer.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "treeline/v1/relocalization.grpc.pb.h"

namespace treeline::relocalizer {
namespace {

using Stream = grpc::ServerReaderWriter<v1::LocalizeStreamResponse,
                                        v1::LocalizeStreamRequest>;

class StreamService final : public v1::RelocalizationService::Service {
 public:
  grpc::Status LocalizeStream(grpc::ServerContext* context,
                              Stream* stream) override {
    return serve(*context, *stream);
  }
  std::function<grpc::Status(grpc::ServerContext&, Stream&)> serve;
};

v1::LocalizeStreamResponse AnswerTo(const v1::LocalizeStreamRequest& request) {
  v1::LocalizeStreamResponse response;
  response.set_id(request.id());
  response.mutable_response()->set_outcome(v1::OUTCOME_NOT_LOCALIZED);
  response.mutable_response()->set_scene(request.localize().scene());
  return response;
}

class LocalizeStreamTest : public testing::Test {
 protected:
  void SetUp() override {
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(),
                             &port);
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    ASSERT_NE(server_, nullptr);
    client_ =
        ConnectRelocalizer({.server = "127.0.0.1:" + std::to_string(port)})
            .value();
  }

  static LocalizeQuery Query() {
    LocalizeQuery query;
    query.scene = "kitchen";
    query.frame.color = wire::EncodedImage{"x"};
    return query;
  }

  StreamService service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<Relocalizer> client_;
};

TEST_F(LocalizeStreamTest, AnswersCarryTheirNumbersAndTimes) {
  v1::StreamSettings settings;
  bool later_settings = false;
  service_.serve = [&](grpc::ServerContext&, Stream& stream) {
    v1::LocalizeStreamRequest request;
    while (stream.Read(&request)) {
      if (request.id() == 7) {
        settings = request.settings();
      } else {
        later_settings |= request.has_settings();
      }
      stream.Write(AnswerTo(request));
    }
    return grpc::Status::OK;
  };
  const auto stream =
      client_->OpenStream({.drop_oldest = true, .max_pending = 3});
  EXPECT_TRUE(stream->Send(7, Query()));
  EXPECT_TRUE(stream->Send(9, Query()));
  stream->FinishSending();
  for (const uint64_t id : {7u, 9u}) {
    const auto answer = stream->Receive();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->id, id);
    ASSERT_TRUE(answer->answer.ok()) << answer->answer.status();
    EXPECT_EQ(answer->answer->scene, "kitchen");
    EXPECT_GT(answer->answer->round_trip_ms, 0);
  }
  EXPECT_FALSE(stream->Receive().has_value());
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_TRUE(settings.drop_oldest());
  EXPECT_EQ(settings.max_pending(), 3);
  EXPECT_FALSE(later_settings);
}

TEST_F(LocalizeStreamTest, AFrameThatFailsEndsNothingButItself) {
  service_.serve = [](grpc::ServerContext&, Stream& stream) {
    v1::LocalizeStreamRequest request;
    while (stream.Read(&request)) {
      v1::LocalizeStreamResponse response = AnswerTo(request);
      if (request.id() == 0) {
        response.mutable_error()->set_code(grpc::ABORTED);
        response.mutable_error()->set_message("dropped");
      }
      stream.Write(response);
    }
    return grpc::Status::OK;
  };
  const auto stream = client_->OpenStream({});
  EXPECT_TRUE(stream->Send(0, Query()));
  EXPECT_TRUE(stream->Send(1, Query()));
  stream->FinishSending();
  EXPECT_EQ(stream->Receive()->answer.status(), absl::AbortedError("dropped"));
  EXPECT_TRUE(stream->Receive()->answer.ok());
  EXPECT_FALSE(stream->Receive().has_value());
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(LocalizeStreamTest, AnAnswerToAnotherFrameIsAnError) {
  service_.serve = [](grpc::ServerContext&, Stream& stream) {
    v1::LocalizeStreamRequest request;
    while (stream.Read(&request)) {
      v1::LocalizeStreamResponse response = AnswerTo(request);
      response.set_id(request.id() + 1);
      stream.Write(response);
    }
    return grpc::Status::OK;
  };
  const auto stream = client_->OpenStream({});
  EXPECT_TRUE(stream->Send(0, Query()));
  stream->FinishSending();
  EXPECT_EQ(stream->Receive()->answer.status().code(),
            absl::StatusCode::kInternal);
}

TEST_F(LocalizeStreamTest, TheEndOfTheStreamSaysWhy) {
  service_.serve = [](grpc::ServerContext&, Stream&) {
    return grpc::Status(grpc::UNAUTHENTICATED, "no token");
  };
  const auto stream = client_->OpenStream({});
  EXPECT_FALSE(stream->Receive().has_value());
  EXPECT_EQ(stream->Finish(), absl::UnauthenticatedError("no token"));
}

TEST_F(LocalizeStreamTest, TheStopTokenCancelsHereAndThere) {
  absl::Notification cancelled_there;
  service_.serve = [&](grpc::ServerContext& context, Stream& stream) {
    v1::LocalizeStreamRequest request;
    while (stream.Read(&request)) {
    }
    if (context.IsCancelled()) cancelled_there.Notify();
    return grpc::Status::OK;
  };
  std::stop_source stop;
  const auto stream = client_->OpenStream({.stop = stop.get_token()});
  EXPECT_TRUE(stream->Send(0, Query()));
  stop.request_stop();
  EXPECT_FALSE(stream->Receive().has_value());
  EXPECT_EQ(stream->Finish().code(), absl::StatusCode::kCancelled);
  cancelled_there.WaitForNotification();
}

TEST_F(LocalizeStreamTest, AStreamThatIsGivenUpEnds) {
  absl::Notification over;
  service_.serve = [&](grpc::ServerContext&, Stream& stream) {
    v1::LocalizeStreamRequest request;
    while (stream.Read(&request)) {
    }
    over.Notify();
    return grpc::Status::OK;
  };
  {
    const auto stream = client_->OpenStream({});
    EXPECT_TRUE(stream->Send(0, Query()));
  }
  over.WaitForNotification();
}

}  // namespace
}  // namespace treeline::relocalizer
