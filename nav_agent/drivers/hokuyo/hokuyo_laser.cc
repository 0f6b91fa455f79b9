#include "nav_agent/drivers/hokuyo/hokuyo_laser.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::hokuyo {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kWriteTimeout(500);
// How long a read waits at most, so that the injected clock is looked at now
// and then even if it does not run with the system's.
constexpr milliseconds kLongestRead(50);

}  // namespace

absl::StatusOr<std::unique_ptr<HokuyoLaser>> HokuyoLaser::Start(
    const HokuyoOptions& options,
    std::unique_ptr<stream::ByteStreamOpener> opener,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  return std::unique_ptr<HokuyoLaser>(
      new HokuyoLaser(options, std::move(opener), clock));
}

HokuyoLaser::HokuyoLaser(const HokuyoOptions& options,
                         std::unique_ptr<stream::ByteStreamOpener> opener,
                         const base::Clock& clock)
    : options_(options),
      opener_(std::move(opener)),
      clock_(clock),
      backoff_(options.backoff, options.seed),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

HokuyoLaser::~HokuyoLaser() = default;

core::RangeSensorInfo HokuyoLaser::Info() const {
  const absl::MutexLock lock(&mutex_);
  return info_.value_or(core::RangeSensorInfo());
}

std::optional<ScipVersion> HokuyoLaser::Version() const {
  const absl::MutexLock lock(&mutex_);
  return version_;
}

std::vector<core::LaserScan> HokuyoLaser::TakeScans() {
  const absl::MutexLock lock(&mutex_);
  std::vector<core::LaserScan> scans(std::make_move_iterator(waiting_.begin()),
                                     std::make_move_iterator(waiting_.end()));
  waiting_.clear();
  return scans;
}

core::DeviceHealth HokuyoLaser::Health() const {
  const absl::MutexLock lock(&mutex_);
  return health_;
}

void HokuyoLaser::SetLost(const absl::Status& cause) {
  const absl::MutexLock lock(&mutex_);
  if (health_.state == core::DeviceState::kRunning) ++health_.losses;
  health_.state = core::DeviceState::kLost;
  health_.cause =
      base::Annotate(cause, absl::StrCat("laser ", opener_->Name()));
}

void HokuyoLaser::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    auto stream = opener_->Open(stop);
    const absl::Status ended =
        stream.ok() ? Serve(**stream, stop) : stream.status();
    // Closed before the pause, so that others may open it meanwhile.
    if (stream.ok()) stream->reset();
    if (stop.stop_requested()) return;
    SetLost(ended);
    if (stream::StopRequestedWithin(backoff_.Next(), stop)) return;
  }
}

absl::Status HokuyoLaser::Serve(stream::ByteStream& stream,
                                const std::stop_token& stop) {
  HokuyoProtocol protocol(options_, clock_.Now());
  {
    const absl::MutexLock lock(&mutex_);
    corrupt_before_session_ = health_.corrupt;
  }
  absl::Status status;
  while (status.ok() && !stop.stop_requested()) {
    status = Exchange(stream, protocol, stop);
  }
  // The laser need not shine when nobody looks. If this does not arrive, the
  // next session begins with it.
  if (!absl::IsUnavailable(status)) {
    stream.Write(stream::AsBytes("QT\n"), milliseconds(100)).IgnoreError();
  }
  return status;
}

absl::Status HokuyoLaser::Exchange(stream::ByteStream& stream,
                                   HokuyoProtocol& protocol,
                                   const std::stop_token& stop) {
  const std::string output = protocol.TakeOutput();
  if (!output.empty()) {
    TL_RETURN_IF_ERROR(stream.Write(stream::AsBytes(output), kWriteTimeout));
  }
  if (protocol.failed()) return protocol.trouble();
  const auto left =
      std::chrono::ceil<milliseconds>(protocol.NextDeadline() - clock_.Now());
  std::array<uint8_t, 4096> buffer = {};
  TL_ASSIGN_OR_RETURN(
      const size_t count,
      stream.Read(buffer, std::clamp(left, milliseconds(0), kLongestRead),
                  stop));
  const base::MonotonicTime now = clock_.Now();
  if (count > 0) {
    protocol.Receive(std::span(buffer).first(count), now);
  } else {
    protocol.Tick(now);
  }
  return Publish(protocol);
}

absl::Status HokuyoLaser::Publish(HokuyoProtocol& protocol) {
  std::vector<core::LaserScan> scans = protocol.TakeScans();
  const absl::MutexLock lock(&mutex_);
  health_.corrupt = corrupt_before_session_ + protocol.corrupt();
  if (protocol.knows_sensor()) {
    if (!info_) info_ = protocol.Info();
    if (*info_ != protocol.Info()) {
      return absl::FailedPreconditionError(absl::StrCat(
          "another sensor than before: ", protocol.Version().product,
          "; restart the agent to use it"));
    }
    version_ = protocol.Version();
  }
  for (core::LaserScan& scan : scans) {
    if (waiting_.size() >= core::kMaxWaiting) {
      waiting_.pop_front();
      ++health_.dropped;
    }
    waiting_.push_back(std::move(scan));
    ++health_.received;
  }
  if (!protocol.trouble().ok()) {
    if (health_.state == core::DeviceState::kRunning) ++health_.losses;
    health_.state = core::DeviceState::kLost;
    health_.cause = base::Annotate(protocol.trouble(),
                                   absl::StrCat("laser ", opener_->Name()));
  } else if (!scans.empty()) {
    health_.state = core::DeviceState::kRunning;
    health_.cause = absl::OkStatus();
    backoff_.Reset();
  }
  return absl::OkStatus();
}

}  // namespace treeline::hokuyo
