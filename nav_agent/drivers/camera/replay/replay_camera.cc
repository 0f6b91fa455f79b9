#include "nav_agent/drivers/camera/replay/replay_camera.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/dataset/frame_times.h"

namespace treeline::replay_camera {
namespace {

// Of the frames, after the first (s).
std::vector<double> TimesAfterFirst_s(const dataset::Dataset& dataset) {
  const std::vector<dataset::Time_ns> times = dataset::FrameTimes(dataset);
  std::vector<double> times_s;
  for (const dataset::Time_ns time : times) {
    times_s.push_back(static_cast<double>(time - times.front()) * 1e-9);
  }
  return times_s;
}

double MeanInterval_s(const std::vector<double>& times_s) {
  return times_s.size() < 2
             ? 1.0 / dataset::kFrameRate_hz
             : times_s.back() / static_cast<double>(times_s.size() - 1);
}

}  // namespace

absl::Status ReplayCameraOptions::Validate() const {
  if (!(rate > 0) || !(rate <= 1000)) {
    return absl::InvalidArgumentError(
        absl::StrCat("a replay's rate of ", rate, " is outside (0, 1000]"));
  }
  if (!std::isfinite(begin_s) || begin_s < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("a replay cannot begin at ", begin_s, " s"));
  }
  if (decode_ahead < 1 || decode_ahead > core::kMaxWaiting) {
    return absl::InvalidArgumentError(
        absl::StrCat("a replay's decode_ahead of ", decode_ahead,
                     " is outside [1, ", core::kMaxWaiting, "]"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<ReplayCamera>> ReplayCamera::Create(
    const ReplayCameraOptions& options, dataset::Dataset dataset,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (dataset.size() == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat(dataset.uri(), " has no frames to replay"));
  }
  std::vector<double> times_s = TimesAfterFirst_s(dataset);
  if (!std::ranges::is_sorted(times_s)) {
    return absl::InvalidArgumentError(
        absl::StrCat(dataset.uri(), ": its frames are not in order of time"));
  }
  if (options.begin_s > times_s.back()) {
    return absl::InvalidArgumentError(
        absl::StrCat("a replay cannot begin at ", options.begin_s,
                     " s: ", dataset.uri(), " ends at ", times_s.back(), " s"));
  }
  return std::unique_ptr<ReplayCamera>(
      new ReplayCamera(options, std::move(dataset), std::move(times_s), clock));
}

ReplayCamera::ReplayCamera(const ReplayCameraOptions& options,
                           dataset::Dataset dataset,
                           std::vector<double> times_s,
                           const base::Clock& clock)
    : options_(options),
      dataset_(std::move(dataset)),
      times_s_(std::move(times_s)),
      round_gap_s_(MeanInterval_s(times_s_)),
      clock_(clock) {
  {
    absl::MutexLock lock(&mutex_);
    Begin(options.begin_s, 0);
  }
  thread_ =
      std::jthread([this](const std::stop_token& stop) { DecodeAhead(stop); });
}

ReplayCamera::~ReplayCamera() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
}

void ReplayCamera::Begin(double position_s, int64_t sequence) {
  const auto frame = std::ranges::lower_bound(times_s_, position_s);
  runs_.push_back({.first_sequence = sequence,
                   .first_frame = static_cast<int>(frame - times_s_.begin()),
                   .begin_s = position_s,
                   .start = clock_.Now()});
  next_ = next_to_decode_ = sequence;
  ahead_.clear();
  ++jumps_;
}

int ReplayCamera::FrameOf(const Run& run, int64_t sequence) const {
  return static_cast<int>((run.first_frame + sequence - run.first_sequence) %
                          dataset_.size());
}

bool ReplayCamera::Exists(const Run& run, int64_t sequence) const {
  return options_.loop ||
         run.first_frame + sequence - run.first_sequence < dataset_.size();
}

base::MonotonicTime ReplayCamera::StampOf(const Run& run,
                                          int64_t sequence) const {
  const int64_t rounds =
      (run.first_frame + sequence - run.first_sequence) / dataset_.size();
  const double time_s =
      times_s_[static_cast<size_t>(FrameOf(run, sequence))] +
      static_cast<double>(rounds) * (times_s_.back() + round_gap_s_);
  return run.start + std::chrono::duration_cast<base::MonotonicTime::duration>(
                         std::chrono::duration<double>((time_s - run.begin_s) /
                                                       options_.rate));
}

bool ReplayCamera::MayDecode() const {
  return stopping_ ||
         (ahead_.size() < static_cast<size_t>(options_.decode_ahead) &&
          Exists(runs_.back(), next_to_decode_));
}

void ReplayCamera::DecodeAhead(const std::stop_token& stop) {
  absl::MutexLock lock(&mutex_);
  while (!stop.stop_requested()) {
    mutex_.Await(absl::Condition(this, &ReplayCamera::MayDecode));
    if (stopping_) return;
    const int64_t sequence = next_to_decode_;
    const int64_t jumps = jumps_;
    const int index = FrameOf(runs_.back(), sequence);
    mutex_.Unlock();
    absl::StatusOr<image::Frame> frame = dataset_.Load(index);
    mutex_.Lock();
    if (jumps != jumps_) continue;
    ahead_.push_back({.sequence = sequence, .frame = std::move(frame)});
    ++next_to_decode_;
  }
}

void ReplayCamera::SkipTo(int64_t sequence) {
  health_.dropped += sequence - next_;
  next_ = sequence;
  while (!ahead_.empty() && ahead_.front().sequence < sequence) {
    ahead_.pop_front();
  }
  if (next_to_decode_ < sequence) {
    next_to_decode_ = sequence;
    ++jumps_;
  }
}

void ReplayCamera::HandOver(Decoded decoded,
                            std::vector<core::RgbdFrame>& frames) {
  if (!decoded.frame.ok()) {
    ++health_.corrupt;
    health_.cause = decoded.frame.status();
    return;
  }
  health_.state = core::DeviceState::kRunning;
  health_.cause = absl::OkStatus();
  ++health_.received;
  core::RgbdFrame frame = {.stamp = StampOf(runs_.back(), decoded.sequence),
                           .sequence = decoded.sequence,
                           .frame = *std::move(decoded.frame)};
  if (!frame.frame.calibration) {
    frame.frame.calibration = dataset_.calibration();
  }
  frames.push_back(std::move(frame));
}

std::vector<core::RgbdFrame> ReplayCamera::TakeFrames() {
  absl::MutexLock take_lock(&take_mutex_);
  absl::MutexLock lock(&mutex_);
  const base::MonotonicTime now = clock_.Now();
  int64_t end = next_;
  while (Exists(runs_.back(), end) && StampOf(runs_.back(), end) <= now) ++end;
  if (end - next_ > core::kMaxWaiting) SkipTo(end - core::kMaxWaiting);
  std::vector<core::RgbdFrame> frames;
  while (next_ < end) {
    mutex_.Await(absl::Condition(
        +[](std::deque<Decoded>* ahead) { return !ahead->empty(); }, &ahead_));
    Decoded decoded = std::move(ahead_.front());
    ahead_.pop_front();
    next_ = decoded.sequence + 1;
    HandOver(std::move(decoded), frames);
  }
  if (!Exists(runs_.back(), next_) &&
      health_.state == core::DeviceState::kRunning && end == next_ &&
      frames.empty()) {
    health_.state = core::DeviceState::kLost;
    ++health_.losses;
    health_.cause = absl::OutOfRangeError(
        absl::StrCat(dataset_.uri(), ": the recording has ended"));
  }
  return frames;
}

absl::Status ReplayCamera::Seek(double position_s) {
  if (!(position_s >= 0) || !(position_s <= duration_s())) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a position of ", position_s, " s is outside [0, ", duration_s(), "]"));
  }
  absl::MutexLock take_lock(&take_mutex_);
  absl::MutexLock lock(&mutex_);
  Begin(position_s, next_);
  return absl::OkStatus();
}

camera::RgbdCalibration ReplayCamera::Calibration() const {
  return dataset_.calibration();
}

core::DeviceHealth ReplayCamera::Health() const {
  absl::MutexLock lock(&mutex_);
  return health_;
}

int ReplayCamera::DatasetFrameOf(int64_t sequence) const {
  absl::MutexLock lock(&mutex_);
  if (sequence < 0 || sequence >= next_) return -1;
  for (auto run = runs_.rbegin(); run != runs_.rend(); ++run) {
    if (sequence >= run->first_sequence) return FrameOf(*run, sequence);
  }
  return -1;
}

}  // namespace treeline::replay_camera
