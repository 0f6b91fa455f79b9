// What the lost suite's runs come to.
#ifndef EVALUATION_LOST_LOST_SUITE_REPORT_H_
#define EVALUATION_LOST_LOST_SUITE_REPORT_H_

#include <string>
#include <vector>

#include "evaluation/lost/lost_suite.h"

namespace treeline::lost {

// Of some kidnaps, for one threshold.
struct KidnapTally {
  int kidnaps = 0;
  // In time, while lost.
  int declared = 0;
  // These do not count: localization found its place again before anything was
  // declared, or the robot was not taken far enough away to be lost; the
  // detector said lost before the kidnap.
  int not_lost = 0;
  int alarmed_before = 0;
  std::vector<double> delays_s;

  double Share() const {
    return kidnaps > 0 ? static_cast<double>(declared) / kidnaps : 0;
  }
};

struct RocPoint {
  double log_odds = 0;
  double detection = 0;
  double false_alarms_per_h = 0;
};

// A time for which log odds were at or above the threshold while the robot was
// not lost; those less than five seconds apart are one. None in the ten seconds
// after a real loss and the three seconds before.
struct FalseAlarm {
  std::string world;
  uint64_t seed = 0;
  LostSample sample;
};

class LostReport {
 public:
  LostReport(std::vector<LostRun> runs, double threshold_log_odds)
      : runs_(std::move(runs)), threshold_(threshold_log_odds) {}

  const std::vector<LostRun>& runs() const { return runs_; }
  double threshold_log_odds() const { return threshold_; }
  // Warm and cold kidnaps; `world` empty: of all.
  KidnapTally Kidnaps(double threshold, const std::string& world) const;
  KidnapTally KidnapsOf(double threshold, KidnapStart start, bool drives) const;
  std::vector<FalseAlarm> FalseAlarms(double threshold,
                                      const std::string& world) const;
  // Of driving, without the time in which localization was really lost.
  double Hours(const std::string& world) const;
  std::vector<RocPoint> Roc() const;

  // For people and for programs.
  std::string Summary() const;
  std::string Json() const;
  // "lost,jump,FEATURE..." and one line a scan, for LostFit: every fifth scan
  // of drives, all of the three seconds after kidnaps.
  std::string FeatureTable() const;

 private:
  std::vector<std::string> Worlds() const;

  std::vector<LostRun> runs_;
  double threshold_;
};

}  // namespace treeline::lost

#endif  // EVALUATION_LOST_LOST_SUITE_REPORT_H_
