// A Hokuyo laser scanner, played by a program: the sensor's side of SCIP 2.x.
#ifndef SIMULATION_EMULATORS_HOKUYO_EMULATOR_H_
#define SIMULATION_EMULATORS_HOKUYO_EMULATOR_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "nav_agent/drivers/hokuyo/scip_codec.h"
#include "nav_agent/drivers/hokuyo/scip_replies.h"
#include "simulation/emulators/emulated_device.h"
#include "simulation/emulators/laser_source.h"
#include "simulation/simulator/scenario_player.h"

namespace treeline::emulators {

struct HokuyoEmulatorOptions {
  hokuyo::ScipParameters parameters;
  hokuyo::ScipVersion version = {.vendor = "Hokuyo Automatic Co.,Ltd.",
                                 .product = "SOKUIKI Sensor UTM-30LX-EW",
                                 .firmware = "1.1.0 (emulated by Treeline)",
                                 .protocol = "SCIP 2.2",
                                 .serial = "H0000001"};
  // What its clock says when it is switched on; [0, 2^24).
  int64_t first_time_ms = 0;
  // Sensors with an Ethernet socket refuse SS with status 0F.
  bool ethernet = true;
  // After RB twice, it says nothing for so long.
  double reboot_s = 1;

  absl::Status Validate() const;
};

// Understands VV, PP, II, BM, QT, RS, RB (twice within a second), TM0 to TM2,
// SS, MD, ME, MS, GD, GE and GS, each also with a string of up to 16
// characters after ';'; refuses everything else with status 0E. It turns all
// the time; a scan is sent when its last beam was measured, with the time of
// its step 0. In time mode it knows TM, RS and RB alone, and refuses the rest
// with 0E. Multi-echo commands (HD, ND, ...) are not understood.
//
// A program that does not keep up loses scans: none is sent later than four
// turns after it was measured.
class HokuyoEmulator final : public EmulatedDevice {
 public:
  // Is switched on at `now`. `source` must outlive it; `options` must be
  // valid.
  HokuyoEmulator(const HokuyoEmulatorOptions& options, LaserSource& source,
                 base::MonotonicTime now);

  void Connect(base::MonotonicTime now) override;
  void SetFaults(const ActiveFaults& faults, base::MonotonicTime now) override;
  void Receive(std::span<const uint8_t> bytes,
               base::MonotonicTime now) override;
  std::string TakeOutput(base::MonotonicTime now) override;
  base::MonotonicTime NextEvent() const override;

  bool laser_on() const { return laser_on_; }
  bool time_mode() const { return time_mode_; }
  // What its clock says.
  int64_t Time_ms(base::MonotonicTime now) const;

 private:
  // A running M... command, as it was received.
  struct Measurement {
    hokuyo::ScanCommand command;
    std::string text;    // without count and string
    std::string string;  // ";abc", or empty
    int remaining = 0;   // scans; of those without end 0
    int64_t next_turn = 0;
  };

  void Answer(absl::string_view line, base::MonotonicTime now);
  void AnswerTime(absl::string_view line, absl::string_view command,
                  base::MonotonicTime now);
  void AnswerReboot(absl::string_view line, base::MonotonicTime now);
  void AnswerScan(absl::string_view line, absl::string_view command,
                  base::MonotonicTime now);
  void StartMeasurement(absl::string_view line, absl::string_view command,
                        const hokuyo::ScanCommand& scan,
                        base::MonotonicTime now);
  // "00" if `command` asks for something that there is.
  std::string StatusOf(absl::string_view command) const;
  std::string InfoLines(base::MonotonicTime now) const;
  void Reply(absl::string_view echo, absl::string_view status,
             absl::string_view rest = "\n");
  void SendScans(base::MonotonicTime now);
  void SendErrors();
  void SwitchOff();
  std::string EncodeTurn(int64_t turn, const hokuyo::ScanCommand& command);

  // Turns are numbered from when it was switched on; a turn's scan is complete
  // when the last step was measured.
  base::MonotonicTime StartOf(int64_t turn) const;
  base::MonotonicTime EndOf(int64_t turn) const;
  int64_t LastComplete(base::MonotonicTime now) const;

  HokuyoEmulatorOptions options_;
  LaserSource& source_;
  base::MonotonicTime switched_on_;
  // Its clock: at clock_from_ it said clock_ms_.
  base::MonotonicTime clock_from_;
  double clock_ms_;
  double skew_ppm_ = 0;

  std::string line_;
  std::string output_;
  std::optional<base::MonotonicTime> reboot_asked_;
  base::MonotonicTime silent_until_;
  bool laser_on_ = false;
  bool time_mode_ = false;
  int error_status_ = 0;
  bool error_told_ = false;
  std::optional<Measurement> measurement_;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_HOKUYO_EMULATOR_H_
