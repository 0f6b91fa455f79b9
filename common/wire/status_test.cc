#include "common/wire/status.h"

#include <chrono>
#include <string>

#include "common/base/error_info.h"
#include "gtest/gtest.h"

namespace treeline::wire {
namespace {

struct Row {
  absl::StatusCode absl_code;
  grpc::StatusCode grpc_code;
};

class StatusTable : public testing::TestWithParam<Row> {};

TEST_P(StatusTable, CodeAndMessageCrossBothWays) {
  const auto [absl_code, grpc_code] = GetParam();
  const grpc::Status out = ToGrpc(absl::Status(absl_code, "why and where"));
  EXPECT_EQ(out.error_code(), grpc_code);
  EXPECT_EQ(out.error_message(), "why and where");
  const absl::Status back = FromGrpc(grpc::Status(grpc_code, "why and where"));
  EXPECT_EQ(back.code(), absl_code);
  EXPECT_EQ(back.message(), "why and where");
}

INSTANTIATE_TEST_SUITE_P(
    AllErrors, StatusTable,
    testing::Values(
        Row{absl::StatusCode::kCancelled, grpc::CANCELLED},
        Row{absl::StatusCode::kUnknown, grpc::UNKNOWN},
        Row{absl::StatusCode::kInvalidArgument, grpc::INVALID_ARGUMENT},
        Row{absl::StatusCode::kDeadlineExceeded, grpc::DEADLINE_EXCEEDED},
        Row{absl::StatusCode::kNotFound, grpc::NOT_FOUND},
        Row{absl::StatusCode::kAlreadyExists, grpc::ALREADY_EXISTS},
        Row{absl::StatusCode::kPermissionDenied, grpc::PERMISSION_DENIED},
        Row{absl::StatusCode::kResourceExhausted, grpc::RESOURCE_EXHAUSTED},
        Row{absl::StatusCode::kFailedPrecondition, grpc::FAILED_PRECONDITION},
        Row{absl::StatusCode::kAborted, grpc::ABORTED},
        Row{absl::StatusCode::kOutOfRange, grpc::OUT_OF_RANGE},
        Row{absl::StatusCode::kUnimplemented, grpc::UNIMPLEMENTED},
        Row{absl::StatusCode::kInternal, grpc::INTERNAL},
        Row{absl::StatusCode::kUnavailable, grpc::UNAVAILABLE},
        Row{absl::StatusCode::kDataLoss, grpc::DATA_LOSS},
        Row{absl::StatusCode::kUnauthenticated, grpc::UNAUTHENTICATED}));

TEST(Status, OkStaysOk) {
  EXPECT_TRUE(ToGrpc(absl::OkStatus()).ok());
  EXPECT_TRUE(FromGrpc(grpc::Status::OK).ok());
}

TEST(Status, CodesThatDoNotExistBecomeUnknown) {
  EXPECT_EQ(
      ToGrpc(absl::Status(static_cast<absl::StatusCode>(77), "x")).error_code(),
      grpc::UNKNOWN);
  EXPECT_EQ(
      FromGrpc(grpc::Status(static_cast<grpc::StatusCode>(20), "x")).code(),
      absl::StatusCode::kUnknown);
}

TEST(Status, LongMessagesAreCutToWhatTrailersCarry) {
  const std::string long_message(100'000, 'x');
  EXPECT_EQ(
      ToGrpc(absl::InvalidArgumentError(long_message)).error_message().size(),
      kMaxStatusMessageBytes);
}

TEST(Status, ReasonAndRetryTimeTravelAsDetails) {
  const absl::Status status = base::WithRetryAfter(
      base::WithReason(absl::UnavailableError("the queue is full"),
                       "QUEUE_FULL", {{"queue", "64"}}),
      std::chrono::milliseconds(1250));
  for (const absl::Status& back :
       {FromGrpc(ToGrpc(status)), FromProto(ToProto(status))}) {
    EXPECT_EQ(back.code(), absl::StatusCode::kUnavailable);
    EXPECT_EQ(back.message(), "the queue is full");
    EXPECT_EQ(base::ErrorInfoOf(back).reason, "QUEUE_FULL");
    EXPECT_EQ(base::ErrorInfoOf(back).metadata.at("queue"), "64");
    EXPECT_EQ(base::RetryAfterOf(back), std::chrono::milliseconds(1250));
  }
}

TEST(Status, ForeignDetailsArePassedOver) {
  const grpc::Status status(grpc::UNAVAILABLE, "x", "not a message");
  EXPECT_EQ(FromGrpc(status).code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(base::ErrorInfoOf(FromGrpc(status)).reason, "");
}

}  // namespace
}  // namespace treeline::wire
