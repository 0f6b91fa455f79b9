#include "common/wire/status.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>

#include "common/base/error_info.h"

namespace treeline::wire {
namespace {

struct CodePair {
  absl::StatusCode absl_code;
  grpc::StatusCode grpc_code;
};

// Both libraries take their numbers from google.rpc.Code, but neither promises
// it of the other.
constexpr CodePair kCodes[] = {
    {absl::StatusCode::kOk, grpc::StatusCode::OK},
    {absl::StatusCode::kCancelled, grpc::StatusCode::CANCELLED},
    {absl::StatusCode::kUnknown, grpc::StatusCode::UNKNOWN},
    {absl::StatusCode::kInvalidArgument, grpc::StatusCode::INVALID_ARGUMENT},
    {absl::StatusCode::kDeadlineExceeded, grpc::StatusCode::DEADLINE_EXCEEDED},
    {absl::StatusCode::kNotFound, grpc::StatusCode::NOT_FOUND},
    {absl::StatusCode::kAlreadyExists, grpc::StatusCode::ALREADY_EXISTS},
    {absl::StatusCode::kPermissionDenied, grpc::StatusCode::PERMISSION_DENIED},
    {absl::StatusCode::kResourceExhausted,
     grpc::StatusCode::RESOURCE_EXHAUSTED},
    {absl::StatusCode::kFailedPrecondition,
     grpc::StatusCode::FAILED_PRECONDITION},
    {absl::StatusCode::kAborted, grpc::StatusCode::ABORTED},
    {absl::StatusCode::kOutOfRange, grpc::StatusCode::OUT_OF_RANGE},
    {absl::StatusCode::kUnimplemented, grpc::StatusCode::UNIMPLEMENTED},
    {absl::StatusCode::kInternal, grpc::StatusCode::INTERNAL},
    {absl::StatusCode::kUnavailable, grpc::StatusCode::UNAVAILABLE},
    {absl::StatusCode::kDataLoss, grpc::StatusCode::DATA_LOSS},
    {absl::StatusCode::kUnauthenticated, grpc::StatusCode::UNAUTHENTICATED},
};

constexpr char kDomain[] = "treeline";

grpc::StatusCode GrpcCode(absl::StatusCode code) {
  const auto* pair = std::find_if(
      std::begin(kCodes), std::end(kCodes),
      [&](const CodePair& candidate) { return candidate.absl_code == code; });
  return pair == std::end(kCodes) ? grpc::StatusCode::UNKNOWN : pair->grpc_code;
}

absl::StatusCode AbslCode(grpc::StatusCode code) {
  const auto* pair = std::find_if(
      std::begin(kCodes), std::end(kCodes),
      [&](const CodePair& candidate) { return candidate.grpc_code == code; });
  return pair == std::end(kCodes) ? absl::StatusCode::kUnknown
                                  : pair->absl_code;
}

void AddDetails(const absl::Status& status, google::rpc::Status& proto) {
  const base::ErrorInfo info = base::ErrorInfoOf(status);
  if (!info.reason.empty()) {
    google::rpc::ErrorInfo detail;
    detail.set_reason(info.reason);
    detail.set_domain(kDomain);
    detail.mutable_metadata()->insert(info.metadata.begin(),
                                      info.metadata.end());
    proto.add_details()->PackFrom(detail);
  }
  if (const auto retry_after = base::RetryAfterOf(status)) {
    google::rpc::RetryInfo detail;
    const int64_t milliseconds = retry_after->count();
    detail.mutable_retry_delay()->set_seconds(milliseconds / 1000);
    detail.mutable_retry_delay()->set_nanos(
        static_cast<int32_t>(milliseconds % 1000) * 1'000'000);
    proto.add_details()->PackFrom(detail);
  }
}

absl::Status WithDetails(absl::Status status,
                         const google::rpc::Status& proto) {
  for (const google::protobuf::Any& any : proto.details()) {
    google::rpc::ErrorInfo info;
    google::rpc::RetryInfo retry;
    if (any.UnpackTo(&info) && info.domain() == kDomain) {
      status =
          base::WithReason(std::move(status), info.reason(),
                           {info.metadata().begin(), info.metadata().end()});
    } else if (any.UnpackTo(&retry)) {
      status = base::WithRetryAfter(
          std::move(status),
          std::chrono::milliseconds(retry.retry_delay().seconds() * 1000 +
                                    retry.retry_delay().nanos() / 1'000'000));
    }
  }
  return status;
}

}  // namespace

google::rpc::Status ToProto(const absl::Status& status) {
  google::rpc::Status proto;
  if (status.ok()) return proto;
  const absl::string_view message =
      status.message().substr(0, kMaxStatusMessageBytes);
  proto.set_code(GrpcCode(status.code()));
  proto.set_message(message.data(), message.size());
  AddDetails(status, proto);
  return proto;
}

grpc::Status ToGrpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const google::rpc::Status proto = ToProto(status);
  return grpc::Status(GrpcCode(status.code()), proto.message(),
                      proto.details().empty() ? "" : proto.SerializeAsString());
}

absl::Status FromProto(const google::rpc::Status& status) {
  if (status.code() == 0) return absl::OkStatus();
  return WithDetails(
      absl::Status(AbslCode(static_cast<grpc::StatusCode>(status.code())),
                   status.message()),
      status);
}

absl::Status FromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  google::rpc::Status details;
  // Of a foreign peer they may be anything.
  if (!details.ParseFromString(status.error_details())) details.Clear();
  return WithDetails(
      absl::Status(AbslCode(status.error_code()), status.error_message()),
      details);
}

}  // namespace treeline::wire
