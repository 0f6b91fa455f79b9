#include "nav_agent/drivers/segway/segway_base.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <utility>

#include "common/base/status_macros.h"

namespace treeline::segway {
namespace {

using std::chrono::milliseconds;

// A frame fits into the port's buffer at once, unless the port hangs.
constexpr milliseconds kWriteTimeout(50);
constexpr milliseconds kLongestRead(20);
constexpr size_t kReadBytes = 4096;

}  // namespace

absl::Status SegwayBaseOptions::Validate() const {
  TL_RETURN_IF_ERROR(protocol.Validate());
  return backoff.Validate();
}

absl::StatusOr<std::unique_ptr<SegwayBase>> SegwayBase::Create(
    const SegwayBaseOptions& options,
    std::unique_ptr<stream::ByteStreamOpener> opener,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (opener == nullptr) {
    return absl::InvalidArgumentError("the base has no port");
  }
  return std::unique_ptr<SegwayBase>(
      new SegwayBase(options, std::move(opener), clock));
}

SegwayBase::SegwayBase(const SegwayBaseOptions& options,
                       std::unique_ptr<stream::ByteStreamOpener> opener,
                       const base::Clock& clock)
    : options_(options),
      opener_(std::move(opener)),
      clock_(clock),
      protocol_(options.protocol),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

SegwayBase::~SegwayBase() {
  thread_.request_stop();
  thread_.join();
}

void SegwayBase::Run(const std::stop_token& stop) {
  stream::Backoff backoff(options_.backoff, options_.seed);
  while (!stop.stop_requested()) {
    absl::Status cause;
    auto stream = opener_->Open(stop);
    if (stream.ok()) {
      {
        absl::MutexLock lock(&mutex_);
        protocol_.Connected(clock_.Now());
      }
      cause = Converse(**stream, stop);
    } else {
      cause = stream.status();
    }
    {
      absl::MutexLock lock(&mutex_);
      // A port that opens but has no base behind it is no success.
      if (was_running_) backoff.Reset();
      was_running_ = false;
      protocol_.Disconnected(cause, clock_.Now());
    }
    stream::StopRequestedWithin(backoff.Next(), stop);
  }
}

absl::Status SegwayBase::Converse(stream::ByteStream& stream,
                                  const std::stop_token& stop) {
  std::array<uint8_t, kReadBytes> buffer;
  while (!stop.stop_requested()) {
    std::vector<uint8_t> bytes;
    milliseconds wait(0);
    {
      absl::MutexLock lock(&mutex_);
      const base::MonotonicTime now = clock_.Now();
      bytes = protocol_.Send(now);
      if (protocol_.ShouldReopen(now)) return protocol_.Health().cause;
      wait = std::clamp(
          std::chrono::ceil<milliseconds>(protocol_.NextSend() - now),
          milliseconds(1), kLongestRead);
    }
    if (!bytes.empty()) {
      TL_RETURN_IF_ERROR(stream.Write(bytes, kWriteTimeout));
    }
    TL_ASSIGN_OR_RETURN(const size_t count, stream.Read(buffer, wait, stop));
    absl::MutexLock lock(&mutex_);
    protocol_.Receive(std::span<const uint8_t>(buffer).first(count),
                      clock_.Now());
    if (!was_running_) {
      was_running_ = protocol_.Health().state == core::DeviceState::kRunning;
    }
  }
  const SegwayFrame last =
      EncodeToBase(ToMessage(SegwayMotion{}, options_.protocol.wire));
  return stream.Write(last, kWriteTimeout);
}

absl::Status SegwayBase::SetVelocity(const core::VelocityCommand& command) {
  absl::MutexLock lock(&mutex_);
  return protocol_.SetVelocity(command, clock_.Now());
}

void SegwayBase::Stop() {
  absl::MutexLock lock(&mutex_);
  protocol_.Stop();
}

void SegwayBase::SetEmergencyStop(bool engaged) {
  absl::MutexLock lock(&mutex_);
  protocol_.SetEmergencyStop(engaged);
}

std::vector<core::BaseReading> SegwayBase::TakeReadings() {
  absl::MutexLock lock(&mutex_);
  return protocol_.TakeReadings();
}

core::DeviceHealth SegwayBase::Health() const {
  absl::MutexLock lock(&mutex_);
  return protocol_.Health();
}

SegwayStatistics SegwayBase::Statistics() const {
  absl::MutexLock lock(&mutex_);
  return protocol_.Statistics();
}

}  // namespace treeline::segway
