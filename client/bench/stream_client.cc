#include "client/bench/stream_client.h"

#include <grpcpp/impl/codegen/proto_utils.h>

#include <string>
#include <utility>

#include "common/wire/status.h"

namespace treeline::bench {
namespace {

constexpr char kMethod[] = "/treeline.v1.RelocalizationService/LocalizeStream";

// Tags of LocalizeStreamRequest: field << 3 | wire type.
constexpr char kIdTag = 1 << 3 | 0;
constexpr char kLocalizeTag = 2 << 3 | 2;

void AppendVarint(uint64_t value, std::string& bytes) {
  for (; value >= 0x80; value >>= 7) {
    bytes.push_back(static_cast<char>(value | 0x80));
  }
  bytes.push_back(static_cast<char>(value));
}

}  // namespace

grpc::ByteBuffer StreamMessage(uint64_t id, const grpc::ByteBuffer& localize) {
  std::string head(1, kIdTag);
  AppendVarint(id, head);
  head.push_back(kLocalizeTag);
  AppendVarint(localize.Length(), head);
  std::vector<grpc::Slice> body;
  localize.Dump(&body).ok();
  std::vector<grpc::Slice> slices = {grpc::Slice(head)};
  slices.insert(slices.end(), body.begin(), body.end());
  return grpc::ByteBuffer(slices.data(), slices.size());
}

StreamClient::StreamClient(const relocalizer::Connection& connection,
                           grpc::GenericStub& stub,
                           const std::vector<WorkItem>& items, int window,
                           Host host)
    : items_(items),
      window_(static_cast<size_t>(window)),
      host_(std::move(host)) {
  connection.Prepare(*context_);
  stub.PrepareBidiStreamingCall(context_.get(), kMethod, {}, this);
}

void StreamClient::Start() {
  StartRead(&in_);
  SendIfThereIsRoom();
  StartCall();
}

void StreamClient::SendIfThereIsRoom() {
  {
    absl::MutexLock lock(&mutex_);
    if (writing_ || no_more_ || in_flight_.size() >= window_) return;
    writing_ = true;
  }
  const std::optional<size_t> item = host_.next();
  if (!item) {
    {
      absl::MutexLock lock(&mutex_);
      no_more_ = true;
    }
    StartWritesDone();
    return;
  }
  {
    absl::MutexLock lock(&mutex_);
    const Frame frame{
        .id = next_id_++, .item = *item, .sent = base::SteadyClock().Now()};
    in_flight_.push_back(frame);
    out_ = StreamMessage(frame.id, items_[*item].request);
  }
  StartWrite(&out_);
}

void StreamClient::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    writing_ = false;
  }
  if (ok) SendIfThereIsRoom();
}

void StreamClient::OnReadDone(bool ok) {
  if (!ok) return;
  v1::LocalizeStreamResponse response;
  const grpc::Status parsed =
      grpc::SerializationTraits<v1::LocalizeStreamResponse>::Deserialize(
          &in_, &response);
  if (!parsed.ok()) {
    Cancel();
    return;
  }
  Deliver(response);
  StartRead(&in_);
  SendIfThereIsRoom();
}

void StreamClient::Deliver(const v1::LocalizeStreamResponse& response) {
  std::optional<Frame> frame;
  {
    absl::MutexLock lock(&mutex_);
    if (!in_flight_.empty() && in_flight_.front().id == response.id()) {
      frame = in_flight_.front();
      in_flight_.pop_front();
    }
  }
  if (!frame) {
    // Not the answer that is due: what is in flight will count as failed.
    Cancel();
  } else if (response.has_response()) {
    host_.answer(*frame, absl::OkStatus(), &response.response());
  } else {
    const absl::Status error = wire::FromProto(response.error());
    host_.answer(
        *frame, error.ok() ? absl::InternalError("an error that is OK") : error,
        nullptr);
  }
}

void StreamClient::OnDone(const grpc::Status& status) {
  const absl::Status ended = wire::FromGrpc(status);
  std::deque<Frame> unanswered;
  {
    absl::MutexLock lock(&mutex_);
    unanswered.swap(in_flight_);
  }
  for (const Frame& frame : unanswered) {
    host_.answer(
        frame,
        ended.ok() ? absl::InternalError("the stream ended without it") : ended,
        nullptr);
  }
  context_.Release();
  host_.end(this, ended);
  delete this;
}

}  // namespace treeline::bench
