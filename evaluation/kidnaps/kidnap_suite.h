// Kidnaps in simulated worlds: a robot that drives to its goal is carried
// somewhere else, or is told a wrong place as it begins. Does it notice, find
// its place, and go on? docs/reference/suites.md.
#ifndef EVALUATION_KIDNAPS_KIDNAP_SUITE_H_
#define EVALUATION_KIDNAPS_KIDNAP_SUITE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/relocalizer/relocalizer.h"
#include "evaluation/suites/suite_run.h"

namespace treeline::kidnaps {

// Back on its goal within this time of the kidnap, in simulated seconds.
inline constexpr double kBackWithin_s = 20;

enum class KidnapOutcome : uint8_t {
  // It drives to its goal again and knows where it is, within kBackWithin_s.
  kBack,
  // The same, later.
  kLate,
  // It went on though its estimate was wrong, whatever came then.
  kWrong,
  // It said that it is lost and needs help.
  kNeedHelp,
  // Neither noticed nor found its place.
  kUnnoticed,
  // It noticed and still searched when its time was over.
  kSearching,
  // It fell or tipped over.
  kFell
};
const char* KidnapOutcomeName(KidnapOutcome outcome);

struct KidnapOptions {
  uint64_t seed = 0;
  double camera_hz = 5;
  // nullopt: the default robot.
  std::optional<core::RobotDescription> robot = std::nullopt;
  bool has_rear_laser = true;
  // Obstacles are taken from depth pictures too, which are small then; false:
  // pictures are rendered in full, for questions and checks alone.
  bool sees_depth = false;
  // It is given so much time after the kidnap (s).
  double patience_s = 90;
  // Drives on to the goal once it is back; otherwise the run ends then.
  bool drives_on = true;
  // What the server calls the place's map.
  std::string scene;
  // The server that is asked; null: none.
  std::shared_ptr<relocalizer::Relocalizer> server;
  // What an answer takes in simulated time (s): the server's 0.1 s, the way
  // there and back over a wireless network, with room to spare.
  double latency_s = 0.5;
  // What a call may take in real time (s); then it is too late.
  double real_timeout_s = 60;
  behavior::NavigatorOptions navigator;
};

struct KidnapRun : suites::SuiteRun {
  bool is_warm = false;
  KidnapOutcome outcome = KidnapOutcome::kUnnoticed;
  simulator::RobotPlacement goal;
  // Where it was carried to, or where a cold robot really is, and how far that
  // is from where it thinks it is.
  simulator::RobotPlacement real;
  double away_m = 0;
  double turned_deg = 0;
  double kidnap_s = 0;
  // From the kidnap on; negative: never.
  double noticed_after_s = -1;
  double back_after_s = -1;
  // When it went on, right or wrong.
  suites::PoseMiss error_at_resumption;
  int resumptions = 0;
  int wrong_resumptions = 0;
  // To the server.
  int questions = 0;
  bool arrived = false;

  // Back in time, nothing hit, no stairs, no fall.
  bool IsGood() const {
    return outcome == KidnapOutcome::kBack && wrong_resumptions == 0 &&
           IsSafe();
  }
};

// Odd seeds are warm, even ones cold. Deterministic if the server is, times
// apart. CANCELLED if `stop` is requested.
absl::StatusOr<KidnapRun> RunKidnap(const suites::SuitePlace& place,
                                    const KidnapOptions& options,
                                    const std::stop_token& stop);

// Follows what a kidnapped robot does and what it estimates, step by step.
class KidnapJudge {
 public:
  explicit KidnapJudge(double kidnap_s) : kidnap_s_(kidnap_s) {}

  // error: of its estimate; nullopt: it has none.
  void Observe(double now_s, behavior::NavigatorMode mode, bool has_arrived,
               const std::optional<suites::PoseMiss>& error);

  // It drives and has known its place for kSure_s.
  bool IsBack() const { return back_s_.has_value(); }
  bool NeedsHelp() const { return needs_help_; }
  void Judge(KidnapRun& run) const;

  static constexpr double kSure_s = 1.0;

 private:
  double kidnap_s_;
  bool looked_ = false;
  bool needs_help_ = false;
  std::optional<double> noticed_s_;
  std::optional<double> right_since_s_;
  std::optional<double> back_s_;
  suites::PoseMiss right_error_;
  suites::PoseMiss resumed_error_;
  int resumptions_ = 0;
  int wrong_resumptions_ = 0;
};

}  // namespace treeline::kidnaps

#endif  // EVALUATION_KIDNAPS_KIDNAP_SUITE_H_
