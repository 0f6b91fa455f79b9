#include "nav_agent/drivers/hokuyo/hokuyo_protocol.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace treeline::hokuyo {
namespace {

using std::chrono::nanoseconds;

// For so long a sensor may check itself (status 21 to 49).
constexpr double kSelfCheck_s = 10;
constexpr int kQuietingAttempts = 4;
constexpr int kAttempts = 2;

nanoseconds Seconds(double seconds) {
  return std::chrono::duration_cast<nanoseconds>(
      std::chrono::duration<double>(seconds));
}

// The number of a status; -1 for those with letters.
int NumberOf(absl::string_view status) {
  int number = -1;
  return absl::SimpleAtoi(status, &number) ? number : -1;
}

}  // namespace

HokuyoProtocol::HokuyoProtocol(const HokuyoOptions& options,
                               base::MonotonicTime now)
    : options_(options), clock_(Seconds(options.assumed_delay_s)) {
  Ask(Phase::kQuieting, "QT", now);
}

void HokuyoProtocol::Await(double seconds, base::MonotonicTime now) {
  deadline_ = now + Seconds(seconds);
}

void HokuyoProtocol::Ask(Phase phase, absl::string_view command,
                         base::MonotonicTime now) {
  phase_ = phase;
  question_ = std::string(command);
  attempts_ = 0;
  Repeat(now);
}

void HokuyoProtocol::Repeat(base::MonotonicTime now) {
  ++attempts_;
  asked_at_ = now;
  absl::StrAppend(&output_, question_, "\n");
  Await(options_.reply_timeout_s, now);
}

std::string HokuyoProtocol::TakeOutput() { return std::exchange(output_, {}); }

std::vector<core::LaserScan> HokuyoProtocol::TakeScans() {
  return std::exchange(scans_, {});
}

void HokuyoProtocol::Receive(std::span<const uint8_t> bytes,
                             base::MonotonicTime now) {
  parser_.Parse(bytes, [&](const ScipReply& reply) { OnReply(reply, now); });
  Tick(now);
}

void HokuyoProtocol::Tick(base::MonotonicTime now) {
  if (!failed() && now >= deadline_) OnTimeout(now);
}

void HokuyoProtocol::Fail(absl::Status why) {
  phase_ = Phase::kFailed;
  trouble_ = std::move(why);
  deadline_ = base::MonotonicTime::max();
}

absl::Status HokuyoProtocol::SilenceTrouble(absl::string_view what) const {
  const int64_t corrupt_now = corrupt() - corrupt_at_last_scan_;
  if (corrupt_now > 0) {
    return absl::DataLossError(absl::StrCat(
        what, ", but ", corrupt_now,
        " broken replies: a bad cable, the wrong baud rate, or another "
        "device"));
  }
  return absl::UnavailableError(what);
}

void HokuyoProtocol::OnTimeout(base::MonotonicTime now) {
  switch (phase_) {
    case Phase::kFailed:
      return;
    case Phase::kPausing:
      return AskForScans(now);
    case Phase::kAskingWhy:
      return AfterFault(now);
    case Phase::kRebooting:
      output_ += "RB\n";
      return Fail(trouble_);
    case Phase::kScanning:
      return Fail(SilenceTrouble("the sensor has stopped sending scans"));
    case Phase::kTimeQuery:
    case Phase::kTimeOn:
      // It may be in time mode, and must not stay there.
      return Ask(Phase::kTimeOff, "TM2", now);
    default:
      break;
  }
  const bool quieting = phase_ == Phase::kQuieting;
  if (attempts_ < (quieting ? kQuietingAttempts : kAttempts)) {
    if (quieting) output_ += "TM2\n";
    return Repeat(now);
  }
  Fail(SilenceTrouble(absl::StrCat("no answer to ", question_)));
}

void HokuyoProtocol::OnReply(const ScipReply& reply, base::MonotonicTime now) {
  if (failed() || reply.echo != question_) {
    // What an earlier session asked for, or a damaged echo.
    if (phase_ == Phase::kScanning) ++corrupt_scans_;
    return;
  }
  switch (phase_) {
    case Phase::kTimeOn:
    case Phase::kTimeQuery:
    case Phase::kTimeOff:
      return OnTimeReply(reply, now);
    case Phase::kStarting:
    case Phase::kScanning:
      return OnScanReply(reply, now);
    default:
      return OnSetupReply(reply, now);
  }
}

void HokuyoProtocol::OnSetupReply(const ScipReply& reply,
                                  base::MonotonicTime now) {
  if ((phase_ == Phase::kVersion || phase_ == Phase::kParameters) &&
      reply.status != "00") {
    return Refused(reply.status);
  }
  switch (phase_) {
    case Phase::kQuieting:
      if (reply.status == "00") return Ask(Phase::kVersion, "VV", now);
      // In time mode it obeys nothing else.
      return OnTimeout(now);
    case Phase::kVersion:
      // A broken answer is asked for again when its time is over.
      if (auto version = DecodeVersion(reply); version.ok()) {
        version_ = *std::move(version);
        Ask(Phase::kParameters, "PP", now);
      } else {
        ++corrupt_scans_;
      }
      return;
    case Phase::kParameters:
      return OnParameters(reply, now);
    case Phase::kCondition:
    case Phase::kAskingWhy: {
      // Only told to people: if it is broken, so be it.
      auto condition = DecodeCondition(reply);
      condition_ = condition.ok() ? *std::move(condition) : "";
      if (phase_ == Phase::kAskingWhy) return AfterFault(now);
      if (options_.time_sync) return Ask(Phase::kTimeOn, "TM0", now);
      return Ask(Phase::kLaserOn, "BM", now);
    }
    case Phase::kLaserOn:
      return OnLaserOn(reply.status, now);
    case Phase::kRebooting:
      output_ += "RB\n";
      return Fail(trouble_);
    default:
      return;
  }
}

void HokuyoProtocol::OnParameters(const ScipReply& reply,
                                  base::MonotonicTime now) {
  auto parameters = DecodeParameters(reply);
  if (absl::IsDataLoss(parameters.status())) {
    ++corrupt_scans_;
    return;
  }
  if (!parameters.ok()) return Fail(parameters.status());
  parameters_ = *std::move(parameters);
  absl::Status chosen = ChooseBeams();
  if (!chosen.ok()) return Fail(std::move(chosen));
  knows_sensor_ = true;
  Ask(Phase::kCondition, "II", now);
}

absl::Status HokuyoProtocol::ChooseBeams() {
  const double step_rad = 2 * std::numbers::pi / parameters_.steps_per_turn;
  // A hundredth of a step, so that angles that mean a beam include it.
  const double first = std::ceil(options_.angle_min_rad / step_rad - 0.01) +
                       parameters_.front_step;
  const double last = std::floor(options_.angle_max_rad / step_rad + 0.01) +
                      parameters_.front_step;
  command_ = {
      .continuous = !options_.single_shot,
      .content = options_.intensities ? ScanContent::kDistanceAndIntensity
                                      : ScanContent::kDistance,
      .first_step = std::max(parameters_.first_step, static_cast<int>(first)),
      .last_step = std::min(parameters_.last_step, static_cast<int>(last)),
      .cluster = options_.cluster,
      .skipped_scans = options_.single_shot ? 0 : options_.skipped_scans,
      .count = 0};
  if (command_.last_step <= command_.first_step) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the sensor has no two beams between ", options_.angle_min_rad, " and ",
        options_.angle_max_rad, " rad"));
  }
  info_ = InfoOf(parameters_, command_);
  if (options_.single_shot) info_.scan_interval_s *= 1 + options_.skipped_scans;
  info_.range_max_m = std::min(info_.range_max_m, options_.max_range_m);
  // The sensor's stamp is of step 0 (SCIP 2.0, page 12).
  const double beams_before =
      command_.first_step + (command_.cluster - 1) / 2.0;
  first_beam_delay_ =
      Seconds(beams_before * info_.beam_interval_s / command_.cluster +
              options_.stamp_offset_s);
  return absl::OkStatus();
}

void HokuyoProtocol::OnTimeReply(const ScipReply& reply,
                                 base::MonotonicTime now) {
  if (phase_ == Phase::kTimeOff) return Ask(Phase::kLaserOn, "BM", now);
  if (phase_ == Phase::kTimeOn) {
    // 02: it already was. Anything else: it cannot.
    if (reply.status == "00" || reply.status == "02") {
      return Ask(Phase::kTimeQuery, "TM1", now);
    }
    return Ask(Phase::kTimeOff, "TM2", now);
  }
  const auto time = DecodeTime(reply);
  if (reply.status == "00" && time.ok()) {
    clock_.AddTimeReply(*time, asked_at_, now);
  }
  if (++time_samples_ < kTimeSamples) {
    return Ask(Phase::kTimeQuery, "TM1", now);
  }
  Ask(Phase::kTimeOff, "TM2", now);
}

void HokuyoProtocol::OnLaserOn(absl::string_view status,
                               base::MonotonicTime now) {
  // 02: it already was.
  if (status == "00" || status == "02") return StartScans(now);
  if (status == "01") return OnFault(status, now);
  Refused(status);
}

void HokuyoProtocol::AskForScans(base::MonotonicTime now) {
  if (command_.continuous) {
    return Ask(Phase::kStarting, command_.Text(), now);
  }
  Ask(Phase::kScanning, command_.Text(), now);
  deadline_ = silent_at_;
}

void HokuyoProtocol::StartScans(base::MonotonicTime now) {
  silent_at_ = now + Seconds(options_.first_scan_timeout_s);
  AskForScans(now);
}

void HokuyoProtocol::OnScanReply(const ScipReply& reply,
                                 base::MonotonicTime now) {
  if (reply.status == "99") {
    // It may be sent before what confirms it has come through undamaged.
    phase_ = Phase::kScanning;
    return OnScan(reply, now);
  }
  if (reply.status == "00") {
    return command_.continuous ? OnConfirmed(now) : OnScan(reply, now);
  }
  OnScanStatus(reply.status, now);
}

void HokuyoProtocol::OnConfirmed(base::MonotonicTime now) {
  if (phase_ != Phase::kStarting) return;
  phase_ = Phase::kScanning;
  Await(options_.first_scan_timeout_s, now);
}

void HokuyoProtocol::OnScan(const ScipReply& reply, base::MonotonicTime now) {
  if (!DecodeScan(reply, command_, scan_).ok()) {
    ++corrupt_scans_;
    if (!command_.continuous) PauseUntil(now);
    return;
  }
  if (scan_.time_ms == last_time_ms_) {
    // A scan that was asked for before there was another one.
    if (!command_.continuous) {
      PauseUntil(now + Seconds(info_.scan_interval_s / 4));
    }
    return;
  }
  last_time_ms_ = scan_.time_ms;
  const auto stamp = clock_.HostTimeOfScan(scan_.time_ms, now);
  if (!stamp) {
    return Fail(absl::UnavailableError(
        "the sensor's clock has jumped: it has restarted"));
  }
  core::LaserScan& scan = scans_.emplace_back();
  scan.stamp = *stamp + first_beam_delay_;
  scan.ranges_m.resize(scan_.codes.size());
  std::transform(
      scan_.codes.begin(), scan_.codes.end(), scan.ranges_m.begin(),
      [this](uint32_t code) { return RangeOfCode(code, parameters_); });
  scan.intensities = scan_.intensities;
  trouble_ = absl::OkStatus();
  corrupt_at_last_scan_ = corrupt();
  Await(options_.silence_timeout_s + info_.scan_interval_s, now);
  silent_at_ = deadline_;
  if (!command_.continuous) {
    PauseUntil(std::max(now, asked_at_ + Seconds(info_.scan_interval_s)));
  }
}

void HokuyoProtocol::PauseUntil(base::MonotonicTime time) {
  phase_ = Phase::kPausing;
  question_.clear();
  deadline_ = time;
}

void HokuyoProtocol::OnScanStatus(absl::string_view status,
                                  base::MonotonicTime now) {
  const int number = NumberOf(status);
  // It is sending already; a scan may have come before it said so.
  if (status == "0B" && command_.continuous) return OnConfirmed(now);
  if (number == 10) {
    // The laser is off. It may have been someone's QT.
    return Ask(Phase::kLaserOn, "BM", now);
  }
  if (number >= 21 && number <= 49) {
    trouble_ = absl::UnavailableError(absl::StrCat(
        "the sensor has stopped to check itself (status ", status, ")"));
    if (phase_ == Phase::kStarting) phase_ = Phase::kScanning;
    return Await(kSelfCheck_s, now);
  }
  if (number >= 50 && number <= 97) return OnFault(status, now);
  if (number == 98) {
    // All is well again. Whether scans then come by themselves is not
    // specified, so they are asked for.
    return StartScans(now);
  }
  Refused(status);
}

void HokuyoProtocol::Refused(absl::string_view status) {
  Fail(absl::InvalidArgumentError(
      absl::StrCat("the sensor refuses ", question_, " with status ", status)));
}

void HokuyoProtocol::OnFault(absl::string_view status,
                             base::MonotonicTime now) {
  trouble_ = absl::FailedPreconditionError(
      absl::StrCat("the sensor reports broken hardware (status ", status,
                   " to ", question_, ")"));
  condition_.clear();
  Ask(Phase::kAskingWhy, "II", now);
}

void HokuyoProtocol::AfterFault(base::MonotonicTime now) {
  if (!condition_.empty()) {
    trouble_ = absl::FailedPreconditionError(
        absl::StrCat(trouble_.message(), ": ", condition_));
  }
  if (!options_.reboot_on_fault) return Fail(trouble_);
  // It takes the command only when it comes twice in a row.
  Ask(Phase::kRebooting, "RB", now);
}

}  // namespace treeline::hokuyo
