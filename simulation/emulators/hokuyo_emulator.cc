#include "simulation/emulators/hokuyo_emulator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "simulation/simulator/scenario_player.h"

namespace treeline::emulators {
namespace {

using std::chrono::nanoseconds;

constexpr size_t kLongestLine = 64;
constexpr size_t kLongestString = 16;
constexpr int64_t kLatestTurns = 4;

nanoseconds Seconds(double seconds) {
  return std::chrono::duration_cast<nanoseconds>(
      std::chrono::duration<double>(seconds));
}

bool IsNumber(absl::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return absl::ascii_isdigit(static_cast<unsigned char>(c));
  });
}

bool IsAllowedInString(char c) {
  return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
         absl::StrContains(" ._+@", c);
}

bool IsHardwareError(int status) { return status >= 50 && status <= 97; }

// One number for `cluster` neighbours: the smallest that is a distance.
uint32_t Merged(std::span<const uint32_t> codes, int min_mm) {
  uint32_t best = codes.front();
  for (const uint32_t code : codes) {
    const auto lowest = static_cast<uint32_t>(min_mm);
    const bool better = code >= lowest && (code < best || best < lowest);
    if (better) best = code;
  }
  return best;
}

}  // namespace

absl::Status HokuyoEmulatorOptions::Validate() const {
  const hokuyo::ScipParameters& p = parameters;
  if (p.steps_per_turn < 1 || p.first_step < 0 || p.last_step > 9999 ||
      p.last_step <= p.first_step || p.last_step >= p.steps_per_turn ||
      p.min_mm < 0 || p.max_mm <= p.min_mm || p.max_mm >= (1 << 18) ||
      p.turns_per_minute < 1 || p.turns_per_minute > 60'000) {
    return absl::InvalidArgumentError(
        "the emulated laser's parameters make no sense");
  }
  if (first_time_ms < 0 || first_time_ms >= hokuyo::kScipTimeSpan_ms) {
    return absl::InvalidArgumentError(
        absl::StrCat("the laser's clock must begin at 0 to ",
                     hokuyo::kScipTimeSpan_ms - 1, " ms"));
  }
  if (!(reboot_s >= 0 && reboot_s <= 3600)) {
    return absl::InvalidArgumentError("a reboot takes 0 to 3600 s");
  }
  return absl::OkStatus();
}

HokuyoEmulator::HokuyoEmulator(const HokuyoEmulatorOptions& options,
                               LaserSource& source, base::MonotonicTime now)
    : options_(options),
      source_(source),
      switched_on_(now),
      clock_from_(now),
      clock_ms_(static_cast<double>(options.first_time_ms)),
      silent_until_(now) {}

int64_t HokuyoEmulator::Time_ms(base::MonotonicTime now) const {
  const double elapsed_ms =
      base::MillisecondsBetween(clock_from_, now) * (1 + skew_ppm_ * 1e-6);
  const auto ms = static_cast<int64_t>(std::floor(clock_ms_ + elapsed_ms));
  const int64_t wrapped = ms % hokuyo::kScipTimeSpan_ms;
  return wrapped < 0 ? wrapped + hokuyo::kScipTimeSpan_ms : wrapped;
}

base::MonotonicTime HokuyoEmulator::StartOf(int64_t turn) const {
  const double turn_s = 60.0 / options_.parameters.turns_per_minute;
  return switched_on_ + Seconds(turn_s * static_cast<double>(turn));
}

base::MonotonicTime HokuyoEmulator::EndOf(int64_t turn) const {
  const hokuyo::ScipParameters& p = options_.parameters;
  return StartOf(turn) +
         Seconds(60.0 / p.turns_per_minute * p.last_step / p.steps_per_turn);
}

int64_t HokuyoEmulator::LastComplete(base::MonotonicTime now) const {
  const double turn_s = 60.0 / options_.parameters.turns_per_minute;
  const auto guess = static_cast<int64_t>(
      base::MillisecondsBetween(switched_on_, now) * 1e-3 / turn_s);
  return EndOf(guess) <= now ? guess : guess - 1;
}

void HokuyoEmulator::SwitchOff() {
  laser_on_ = false;
  measurement_.reset();
}

void HokuyoEmulator::Connect(base::MonotonicTime /*now*/) {
  // Half a command, or half a reply, of the one before.
  line_.clear();
  output_.clear();
  if (options_.ethernet) SwitchOff();
}

void HokuyoEmulator::SetFaults(const ActiveFaults& faults,
                               base::MonotonicTime now) {
  if (faults.skew_ppm != skew_ppm_) {
    clock_ms_ +=
        base::MillisecondsBetween(clock_from_, now) * (1 + skew_ppm_ * 1e-6);
    clock_from_ = now;
    skew_ppm_ = faults.skew_ppm;
  }
  if (faults.error_status == error_status_) return;
  const bool was_checking =
      error_status_ != 0 && !IsHardwareError(error_status_);
  error_status_ = faults.error_status;
  error_told_ = false;
  if (error_status_ == 0 && was_checking && measurement_) {
    // All is well again, and the scans go on.
    Reply(absl::StrCat(measurement_->text,
                       absl::StrFormat("%02d", measurement_->remaining),
                       measurement_->string),
          "98");
    measurement_->next_turn = LastComplete(now) + 1;
  }
}

void HokuyoEmulator::Receive(std::span<const uint8_t> bytes,
                             base::MonotonicTime now) {
  for (const uint8_t byte : bytes) {
    if (byte == '\n' || byte == '\r') {
      const std::string line = std::exchange(line_, {});
      if (!line.empty() && now >= silent_until_) Answer(line, now);
    } else if (line_.size() < kLongestLine) {
      line_ += static_cast<char>(byte);
    }
  }
}

void HokuyoEmulator::Reply(absl::string_view echo, absl::string_view status,
                           absl::string_view rest) {
  absl::StrAppend(&output_, echo, "\n", hokuyo::ScipLine(status), rest);
}

void HokuyoEmulator::Answer(absl::string_view line, base::MonotonicTime now) {
  const size_t semicolon = std::min(line.find(';'), line.size());
  const absl::string_view command = line.substr(0, semicolon);
  const absl::string_view string =
      semicolon < line.size() ? line.substr(semicolon + 1) : "";
  const absl::string_view code = command.substr(0, 2);
  if (command != "RB") reboot_asked_.reset();
  if (code == "TM") return AnswerTime(line, command, now);
  if (command == "RB") return AnswerReboot(line, now);
  if (command == "RS") {
    SwitchOff();
    clock_from_ = now;
    clock_ms_ = 0;
    return Reply(line, "00");
  }
  if (time_mode_) return Reply(line, "0E");
  if (string.size() > kLongestString) return Reply(line, "0G");
  if (!std::all_of(string.begin(), string.end(), IsAllowedInString)) {
    return Reply(line, "0H");
  }
  if (command == "VV") {
    return Reply(line, "00", hokuyo::EncodeVersion(options_.version));
  }
  if (command == "PP") {
    return Reply(line, "00", hokuyo::EncodeParameters(options_.parameters));
  }
  if (command == "II") return Reply(line, "00", InfoLines(now));
  if (command == "BM") {
    if (IsHardwareError(error_status_)) return Reply(line, "01");
    return Reply(line, std::exchange(laser_on_, true) ? "02" : "00");
  }
  if (command == "QT") {
    SwitchOff();
    return Reply(line, "00");
  }
  if (code == "SS") return Reply(line, options_.ethernet ? "0F" : "00");
  if (code == "MD" || code == "ME" || code == "MS" || code == "GD" ||
      code == "GE" || code == "GS") {
    return AnswerScan(line, command, now);
  }
  Reply(line, "0E");
}

void HokuyoEmulator::AnswerTime(absl::string_view line,
                                absl::string_view command,
                                base::MonotonicTime now) {
  if (command == "TM0") {
    if (time_mode_) return Reply(line, "02");
    SwitchOff();
    time_mode_ = true;
    return Reply(line, "00");
  }
  if (command == "TM1") {
    if (!time_mode_) return Reply(line, "04");
    const auto time = static_cast<uint32_t>(Time_ms(now));
    return Reply(
        line, "00",
        absl::StrCat(hokuyo::ScipLine(hokuyo::EncodeScipNumber(time, 4)),
                     "\n"));
  }
  if (command == "TM2") {
    return Reply(line, std::exchange(time_mode_, false) ? "00" : "03");
  }
  Reply(line, "01");
}

void HokuyoEmulator::AnswerReboot(absl::string_view line,
                                  base::MonotonicTime now) {
  const bool second =
      reboot_asked_ && now - *reboot_asked_ <= std::chrono::seconds(1);
  Reply(line, second ? "00" : "01");
  if (!second) {
    reboot_asked_ = now;
    return;
  }
  SwitchOff();
  reboot_asked_.reset();
  time_mode_ = false;
  clock_from_ = now;
  clock_ms_ = 0;
  silent_until_ = now + Seconds(options_.reboot_s);
}

std::string HokuyoEmulator::StatusOf(absl::string_view command) const {
  const bool continuous = command[0] == 'M';
  if (command.size() != (continuous ? 15u : 12u)) return "0C";
  if (!IsNumber(command.substr(2, 4))) return "01";
  if (!IsNumber(command.substr(6, 4))) return "02";
  if (!IsNumber(command.substr(10, 2))) return "03";
  if (continuous && !IsNumber(command.substr(12, 1))) return "06";
  if (continuous && !IsNumber(command.substr(13, 2))) return "07";
  const auto scan = hokuyo::ParseScanCommand(command);
  if (!scan) return "0E";
  if (scan->last_step > options_.parameters.last_step) return "04";
  if (scan->last_step < scan->first_step) return "05";
  return "00";
}

void HokuyoEmulator::AnswerScan(absl::string_view line,
                                absl::string_view command,
                                base::MonotonicTime now) {
  const std::string status = StatusOf(command);
  if (status != "00") return Reply(line, status);
  if (error_status_ != 0)
    return Reply(line, absl::StrFormat("%02d", error_status_));
  const auto scan = hokuyo::ParseScanCommand(command);
  if (!scan) return Reply(line, "0E");
  if (scan->continuous) return StartMeasurement(line, command, *scan, now);
  if (!laser_on_) return Reply(line, "10");
  Reply(line, "00", EncodeTurn(std::max<int64_t>(LastComplete(now), 0), *scan));
}

void HokuyoEmulator::StartMeasurement(absl::string_view line,
                                      absl::string_view command,
                                      const hokuyo::ScanCommand& scan,
                                      base::MonotonicTime now) {
  if (measurement_ && measurement_->command == scan) return Reply(line, "0B");
  laser_on_ = true;
  Reply(line, "00");
  measurement_ = {
      .command = scan,
      .text = std::string(command.substr(0, 13)),
      .string = std::string(line.substr(command.size())),
      .remaining = scan.count,
      // "Measurement data that was taken after the command was received".
      .next_turn = LastComplete(now) + 2};
}

std::string HokuyoEmulator::InfoLines(base::MonotonicTime now) const {
  const bool broken = error_status_ != 0;
  return absl::StrCat(
      hokuyo::ScipInfoLine(absl::StrCat("MODL:", options_.parameters.model)),
      hokuyo::ScipInfoLine(laser_on_ ? "LASR:ON" : "LASR:OFF"),
      hokuyo::ScipInfoLine(
          absl::StrCat("SCSP:", options_.parameters.turns_per_minute)),
      hokuyo::ScipInfoLine(measurement_ ? "MESM:Measuring" : "MESM:Idle"),
      hokuyo::ScipInfoLine(options_.ethernet ? "SBPS:Ethernet 100 [Mbps]"
                                             : "SBPS:USB 2.0"),
      hokuyo::ScipInfoLine(absl::StrFormat("TIME:%06X", Time_ms(now))),
      hokuyo::ScipInfoLine(
          broken ? absl::StrFormat("STAT:Trouble!! Error No. =[%02d]",
                                   error_status_)
                 : "STAT:Sensor works well."),
      "\n");
}

std::string HokuyoEmulator::EncodeTurn(int64_t turn,
                                       const hokuyo::ScanCommand& command) {
  const hokuyo::ScipParameters& p = options_.parameters;
  const hokuyo::ScanCommand all = {.first_step = p.first_step,
                                   .last_step = p.last_step};
  const core::RangeSensorInfo info = hokuyo::InfoOf(p, all);
  const base::MonotonicTime zero = StartOf(turn);
  const core::LaserScan seen =
      source_.ScanAt(zero + Seconds(info.beam_interval_s * p.first_step), info);
  std::vector<uint32_t> codes(static_cast<size_t>(p.last_step) + 1, 1);
  std::vector<uint16_t> strengths(codes.size(), 0);
  for (int step = p.first_step; step <= p.last_step; ++step) {
    const auto from = static_cast<size_t>(step - p.first_step);
    const auto at = static_cast<size_t>(step);
    if (from < seen.ranges_m.size()) {
      codes[at] = hokuyo::CodeOfRange(seen.ranges_m[from], p);
    }
    if (from < seen.intensities.size()) strengths[at] = seen.intensities[from];
  }
  hokuyo::ScipScan scan = {
      .time_ms = Time_ms(zero), .codes = {}, .intensities = {}};
  const int cluster = std::max(command.cluster, 1);
  for (int step = command.first_step; step <= command.last_step;
       step += cluster) {
    const int count = std::min(cluster, command.last_step - step + 1);
    const auto at = static_cast<size_t>(step);
    uint32_t code = Merged(
        std::span(codes).subspan(at, static_cast<size_t>(count)), p.min_mm);
    // Two characters hold no more.
    if (command.content == hokuyo::ScanContent::kShortDistance) {
      code = std::min<uint32_t>(code, 0xfff);
    }
    scan.codes.push_back(code);
    scan.intensities.push_back(strengths[at]);
  }
  return hokuyo::EncodeScan(scan, command.content);
}

void HokuyoEmulator::SendErrors() {
  if (error_told_ || !measurement_) return;
  error_told_ = true;
  Reply(absl::StrCat(measurement_->text,
                     absl::StrFormat("%02d", measurement_->remaining),
                     measurement_->string),
        absl::StrFormat("%02d", error_status_));
  if (IsHardwareError(error_status_)) SwitchOff();
}

void HokuyoEmulator::SendScans(base::MonotonicTime now) {
  const int64_t last = LastComplete(now);
  while (measurement_ && measurement_->next_turn <= last) {
    Measurement& running = *measurement_;
    running.next_turn = std::max(running.next_turn, last - kLatestTurns);
    const bool endless = running.command.count == 0;
    if (!endless) --running.remaining;
    const std::string echo =
        absl::StrCat(running.text, absl::StrFormat("%02d", running.remaining),
                     running.string);
    Reply(echo, "99", EncodeTurn(running.next_turn, running.command));
    running.next_turn += running.command.skipped_scans + 1;
    if (!endless && running.remaining == 0) SwitchOff();
  }
}

std::string HokuyoEmulator::TakeOutput(base::MonotonicTime now) {
  if (error_status_ != 0) {
    SendErrors();
  } else {
    SendScans(now);
  }
  return std::exchange(output_, {});
}

base::MonotonicTime HokuyoEmulator::NextEvent() const {
  if (!measurement_ || error_status_ != 0) return base::MonotonicTime::max();
  return EndOf(measurement_->next_turn);
}

}  // namespace treeline::emulators
