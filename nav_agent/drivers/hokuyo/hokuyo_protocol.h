// The conversation with a Hokuyo sensor, from the first command to the last
// scan. No threads, no clock and no connection: bytes and the time go in,
// bytes and scans come out.
#ifndef NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_PROTOCOL_H_
#define NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_PROTOCOL_H_

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/drivers/hokuyo/hokuyo_options.h"
#include "nav_agent/drivers/hokuyo/scip_codec.h"
#include "nav_agent/drivers/hokuyo/scip_parser.h"
#include "nav_agent/drivers/hokuyo/scip_replies.h"
#include "nav_agent/drivers/hokuyo/sensor_clock.h"

namespace treeline::hokuyo {

// One session over one connection:
//
//   QT   stops what an earlier session may have left running (its scans are
//        read and forgotten); from the second attempt on TM2 before it, since
//        a sensor that was left in time mode obeys nothing else
//   VV, PP, II    which sensor it is, what it measures, how it feels
//   TM0, TM1 (kTimeSamples times), TM2    its clock; left out if it refuses
//   BM, MD or ME  the laser, and scans from then on (or GD, GE for each)
//
// A reply is awaited for reply_timeout_s, the question then asked once more.
// After a failure the session is over: make another one, over a fresh
// connection. Not thread-safe.
class HokuyoProtocol {
 public:
  static constexpr int kTimeSamples = 12;

  // Begins at `now`. `options` must be valid.
  HokuyoProtocol(const HokuyoOptions& options, base::MonotonicTime now);

  // What arrived, and when.
  void Receive(std::span<const uint8_t> bytes, base::MonotonicTime now);
  // To be called at NextDeadline() at the latest, if nothing arrived.
  void Tick(base::MonotonicTime now);
  base::MonotonicTime NextDeadline() const { return deadline_; }

  // What is to be sent now; empty most of the time.
  std::string TakeOutput();
  // Good scans since the last call.
  std::vector<core::LaserScan> TakeScans();

  // Whether the sensor has said what it measures; Info(), Parameters() and
  // Version() mean something from then on.
  bool knows_sensor() const { return knows_sensor_; }
  const core::RangeSensorInfo& Info() const { return info_; }
  const ScipParameters& Parameters() const { return parameters_; }
  const ScipVersion& Version() const { return version_; }
  const ScanCommand& Command() const { return command_; }

  // OK while scans come or may still come. The session is over if failed():
  //   UNAVAILABLE          no answer, no scans, or the sensor has restarted
  //   DATA_LOSS            nothing but broken replies
  //   INVALID_ARGUMENT     the sensor refuses a command, or none of the beams
  //                        that the options ask for exists
  //   FAILED_PRECONDITION  it reports that its hardware is broken
  // Otherwise it is the sensor's word that it is checking itself (UNAVAILABLE).
  const absl::Status& trouble() const { return trouble_; }
  bool failed() const { return phase_ == Phase::kFailed; }

  // Replies and scans that came broken.
  int64_t corrupt() const { return parser_.corrupt() + corrupt_scans_; }
  // Of the time that TM told; see SensorClock.
  const SensorClock& clock() const { return clock_; }

 private:
  enum class Phase {
    kQuieting,
    kVersion,
    kParameters,
    kCondition,
    kTimeOn,
    kTimeQuery,
    kTimeOff,
    kLaserOn,
    kStarting,   // MD, ME: until it is confirmed
    kScanning,   // also: until a G... is answered
    kPausing,    // until it is time for the next G...
    kAskingWhy,  // II after a fault
    kRebooting,  // between the two RB
    kFailed
  };

  // Sends `command` and awaits its echo.
  void Ask(Phase phase, absl::string_view command, base::MonotonicTime now);
  void Repeat(base::MonotonicTime now);
  void OnReply(const ScipReply& reply, base::MonotonicTime now);
  void OnSetupReply(const ScipReply& reply, base::MonotonicTime now);
  void OnTimeReply(const ScipReply& reply, base::MonotonicTime now);
  void OnParameters(const ScipReply& reply, base::MonotonicTime now);
  void OnLaserOn(absl::string_view status, base::MonotonicTime now);
  void OnScanReply(const ScipReply& reply, base::MonotonicTime now);
  void OnConfirmed(base::MonotonicTime now);
  void OnScanStatus(absl::string_view status, base::MonotonicTime now);
  void OnScan(const ScipReply& reply, base::MonotonicTime now);
  void PauseUntil(base::MonotonicTime time);
  void OnTimeout(base::MonotonicTime now);
  void StartScans(base::MonotonicTime now);
  void AskForScans(base::MonotonicTime now);
  // The hardware is broken, as `status` says: asks why, and fails then.
  void OnFault(absl::string_view status, base::MonotonicTime now);
  void AfterFault(base::MonotonicTime now);
  void Fail(absl::Status why);
  void Refused(absl::string_view status);
  absl::Status SilenceTrouble(absl::string_view what) const;
  // Which beams the options mean, of those that there are.
  absl::Status ChooseBeams();
  void Await(double seconds, base::MonotonicTime now);

  HokuyoOptions options_;
  ScipParser parser_;
  SensorClock clock_;
  Phase phase_ = Phase::kQuieting;
  absl::Status trouble_;
  base::MonotonicTime deadline_;
  // The question, as its echo will repeat it; when it was asked, how often.
  std::string question_;
  base::MonotonicTime asked_at_;
  int attempts_ = 0;
  int time_samples_ = 0;
  std::string output_;

  bool knows_sensor_ = false;
  ScipParameters parameters_;
  ScipVersion version_;
  std::string condition_;
  ScanCommand command_;
  core::RangeSensorInfo info_;
  std::chrono::nanoseconds first_beam_delay_{0};

  ScipScan scan_;
  int64_t last_time_ms_ = -1;
  // When the sensor counts as silent: put off by every good scan.
  base::MonotonicTime silent_at_;
  int64_t corrupt_scans_ = 0;
  int64_t corrupt_at_last_scan_ = 0;
  std::vector<core::LaserScan> scans_;
};

}  // namespace treeline::hokuyo

#endif  // NAV_AGENT_DRIVERS_HOKUYO_HOKUYO_PROTOCOL_H_
