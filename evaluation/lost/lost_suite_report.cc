#include "evaluation/lost/lost_suite_report.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/sample_statistics.h"
#include "nlohmann/json.hpp"

namespace treeline::lost {
namespace {

constexpr double kRearm_s = 5;
// After it was really lost, an alarm is no false one for so long; nor is one
// that comes so long before, while the error grows.
constexpr double kAftermath_s = 10;
constexpr double kForesight_s = 3;
constexpr double kRocFrom = -8;
constexpr double kRocTo = 8;
constexpr double kRocStep = 0.1;
constexpr int kTableEvery = 5;
constexpr std::array<const char*, localization::kLostFeatures> kNames = {
    "long_share", "residual", "changed_share", "deficit",
    "slide",      "spread",   "elsewhere"};

void Add(const KidnapTrial& trial, double threshold, KidnapTally& tally) {
  // What was already said before is no detection.
  if (trial.log_odds_before >= threshold) {
    ++tally.alarmed_before;
    return;
  }
  bool is_out = trial.samples.empty();
  for (const LostSample& sample : trial.samples) {
    const double delay_s = sample.time_s - trial.time_s;
    if (is_out || delay_s > kDeclareWithin_s) break;
    if (!sample.is_lost) is_out = true;
    if (!is_out && sample.log_odds >= threshold) {
      ++tally.kidnaps;
      ++tally.declared;
      tally.delays_s.push_back(delay_s);
      return;
    }
  }
  ++(is_out ? tally.not_lost : tally.kidnaps);
}

// Whether the robot is really lost soon after a sample of a drive.
bool IsLostSoon(const std::vector<LostSample>& drive, size_t from) {
  for (size_t i = from; i < drive.size(); ++i) {
    if (drive[i].time_s - drive[from].time_s > kForesight_s) return false;
    if (drive[i].is_lost) return true;
  }
  return false;
}

void AddRow(bool is_lost, const localization::LostFeatures& features,
            std::string& table) {
  absl::StrAppendFormat(&table, "%d,%.4f", is_lost ? 1 : 0, features.jump);
  for (const double value : features.values) {
    absl::StrAppendFormat(&table, ",%.4f", value);
  }
  table += '\n';
}

nlohmann::ordered_json TallyJson(const KidnapTally& tally) {
  return {{"kidnaps", tally.kidnaps},
          {"declared", tally.declared},
          {"share", tally.Share()},
          {"not_lost", tally.not_lost},
          {"alarmed_before", tally.alarmed_before},
          {"delay_median_s", base::Quantile(tally.delays_s, 0.5)},
          {"delay_p90_s", base::Quantile(tally.delays_s, 0.9)},
          {"delay_p99_s", base::Quantile(tally.delays_s, 0.99)}};
}

}  // namespace

std::vector<std::string> LostReport::Worlds() const {
  std::vector<std::string> worlds;
  for (const LostRun& run : runs_) {
    if (std::ranges::find(worlds, run.world) == worlds.end()) {
      worlds.push_back(run.world);
    }
  }
  return worlds;
}

KidnapTally LostReport::Kidnaps(double threshold,
                                const std::string& world) const {
  KidnapTally tally;
  for (const LostRun& run : runs_) {
    if (!world.empty() && run.world != world) continue;
    for (const KidnapTrial& trial : run.trials) {
      if (trial.start != KidnapStart::kAnywhere) Add(trial, threshold, tally);
    }
  }
  return tally;
}

KidnapTally LostReport::KidnapsOf(double threshold, KidnapStart start,
                                  bool drives) const {
  KidnapTally tally;
  for (const LostRun& run : runs_) {
    for (const KidnapTrial& trial : run.trials) {
      if (trial.start == start && trial.drives == drives) {
        Add(trial, threshold, tally);
      }
    }
  }
  return tally;
}

std::vector<FalseAlarm> LostReport::FalseAlarms(
    double threshold, const std::string& world) const {
  std::vector<FalseAlarm> alarms;
  for (const LostRun& run : runs_) {
    if (!world.empty() && run.world != world) continue;
    double last_above_s = -1e9;
    double last_lost_s = -1e9;
    for (size_t i = 0; i < run.drive.size(); ++i) {
      const LostSample& sample = run.drive[i];
      if (sample.is_first) last_above_s = -1e9;
      if (sample.is_lost) last_lost_s = sample.time_s;
      if (sample.log_odds < threshold) continue;
      if (sample.time_s - last_above_s > kRearm_s &&
          sample.time_s - last_lost_s > kAftermath_s &&
          !IsLostSoon(run.drive, i)) {
        alarms.push_back(
            {.world = run.world, .seed = run.seed, .sample = sample});
      }
      last_above_s = sample.time_s;
    }
  }
  return alarms;
}

double LostReport::Hours(const std::string& world) const {
  double seconds = 0;
  for (const LostRun& run : runs_) {
    if (!world.empty() && run.world != world) continue;
    for (size_t i = 1; i < run.drive.size(); ++i) {
      if (!run.drive[i].is_lost) {
        seconds += run.drive[i].time_s - run.drive[i - 1].time_s;
      }
    }
  }
  return seconds / 3600;
}

std::vector<RocPoint> LostReport::Roc() const {
  std::vector<RocPoint> roc;
  const double hours = std::max(1e-9, Hours(""));
  const int steps = static_cast<int>((kRocTo - kRocFrom) / kRocStep + 0.5);
  for (int i = 0; i <= steps; ++i) {
    const double threshold = kRocFrom + kRocStep * i + 1e-4;
    roc.push_back(
        {.log_odds = threshold,
         .detection = Kidnaps(threshold, "").Share(),
         .false_alarms_per_h =
             static_cast<double>(FalseAlarms(threshold, "").size()) / hours});
  }
  return roc;
}

std::string LostReport::Summary() const {
  std::string text;
  const auto line = [&](const std::string& name, const KidnapTally& tally,
                        const std::string& rest) {
    absl::StrAppendFormat(
        &text,
        "%-17s %4d of %4d (%5.1f %%), %3d + %d do not count, %3.1f / %3.1f "
        "s%s\n",
        name, tally.declared, tally.kidnaps, 100 * tally.Share(),
        tally.not_lost, tally.alarmed_before,
        base::Quantile(tally.delays_s, 0.5),
        base::Quantile(tally.delays_s, 0.9), rest);
  };
  absl::StrAppendFormat(
      &text,
      "Kidnaps declared within %.0f s; delay: median / 90 %%; false alarms\n",
      kDeclareWithin_s);
  for (const std::string& world : Worlds()) {
    int losses = 0;
    for (const LostRun& run : runs_) {
      if (run.world == world) losses += run.losses;
    }
    line(world, Kidnaps(threshold_, world),
         absl::StrFormat(", %d in %.1f h; really lost %d times",
                         FalseAlarms(threshold_, world).size(), Hours(world),
                         losses));
  }
  for (const KidnapStart start :
       {KidnapStart::kWarm, KidnapStart::kCold, KidnapStart::kAnywhere}) {
    line(absl::StrCat(KidnapStartName(start), ", driving"),
         KidnapsOf(threshold_, start, true), "");
    line(absl::StrCat(KidnapStartName(start), ", standing"),
         KidnapsOf(threshold_, start, false), "");
  }
  const std::vector<FalseAlarm> alarms = FalseAlarms(threshold_, "");
  line("warm and cold", Kidnaps(threshold_, ""), "");
  double mean_us = 0;
  double highest_us = 0;
  for (const LostRun& run : runs_) {
    mean_us += run.mean_us / static_cast<double>(runs_.size());
    highest_us = std::max(highest_us, run.highest_us);
  }
  absl::StrAppendFormat(
      &text,
      "%d false alarms in %.2f h of driving: %.2f an hour\n"
      "A scan takes %.0f us of processor time (mean), %.0f us (highest)\n",
      alarms.size(), Hours(""),
      static_cast<double>(alarms.size()) / std::max(1e-9, Hours("")), mean_us,
      highest_us);
  return text;
}

std::string LostReport::Json() const {
  nlohmann::ordered_json json;
  json["declare_within_s"] = kDeclareWithin_s;
  json["threshold_log_odds"] = threshold_;
  json["hours"] = Hours("");
  json["warm_and_cold"] = TallyJson(Kidnaps(threshold_, ""));
  for (const KidnapStart start :
       {KidnapStart::kWarm, KidnapStart::kCold, KidnapStart::kAnywhere}) {
    json["by_start"][KidnapStartName(start)] = {
        {"driving", TallyJson(KidnapsOf(threshold_, start, true))},
        {"standing", TallyJson(KidnapsOf(threshold_, start, false))}};
  }
  for (const std::string& world : Worlds()) {
    nlohmann::ordered_json entry = TallyJson(Kidnaps(threshold_, world));
    entry["hours"] = Hours(world);
    entry["false_alarms"] = FalseAlarms(threshold_, world).size();
    json["by_world"][world] = std::move(entry);
  }
  nlohmann::ordered_json alarms = nlohmann::ordered_json::array();
  for (const FalseAlarm& alarm : FalseAlarms(threshold_, "")) {
    nlohmann::ordered_json entry = {{"world", alarm.world},
                                    {"seed", alarm.seed},
                                    {"time_s", alarm.sample.time_s},
                                    {"x_m", alarm.sample.position.x},
                                    {"y_m", alarm.sample.position.y},
                                    {"z_m", alarm.sample.position.z},
                                    {"error_m", alarm.sample.error_m},
                                    {"error_deg", alarm.sample.error_deg},
                                    {"jump", alarm.sample.features.jump}};
    for (size_t i = 0; i < localization::kLostFeatures; ++i) {
      entry[kNames[i]] = alarm.sample.features.values[i];
    }
    alarms.push_back(std::move(entry));
  }
  json["false_alarms"] = std::move(alarms);
  // Where localization got really lost in drives.
  nlohmann::ordered_json losses = nlohmann::ordered_json::array();
  for (const LostRun& run : runs_) {
    for (size_t i = 1; i < run.drive.size(); ++i) {
      const LostSample& sample = run.drive[i];
      if (!sample.is_lost || run.drive[i - 1].is_lost) continue;
      losses.push_back({{"world", run.world},
                        {"seed", run.seed},
                        {"time_s", sample.time_s},
                        {"x_m", sample.position.x},
                        {"y_m", sample.position.y},
                        {"z_m", sample.position.z},
                        {"error_m", sample.error_m},
                        {"error_deg", sample.error_deg},
                        {"log_odds", sample.log_odds}});
    }
  }
  json["losses"] = std::move(losses);
  nlohmann::ordered_json missed = nlohmann::ordered_json::array();
  for (const LostRun& run : runs_) {
    for (const KidnapTrial& trial : run.trials) {
      KidnapTally tally;
      Add(trial, threshold_, tally);
      if (tally.kidnaps == tally.declared) continue;
      missed.push_back({{"world", run.world},
                        {"seed", run.seed},
                        {"start", KidnapStartName(trial.start)},
                        {"drives", trial.drives},
                        {"time_s", trial.time_s},
                        {"away_m", trial.away_m},
                        {"turned_deg", trial.turned_deg}});
    }
  }
  json["missed"] = std::move(missed);
  nlohmann::ordered_json roc = nlohmann::ordered_json::array();
  for (const RocPoint& point : Roc()) {
    roc.push_back({{"log_odds", point.log_odds},
                   {"detection", point.detection},
                   {"false_alarms_per_h", point.false_alarms_per_h}});
  }
  json["roc"] = std::move(roc);
  json["delays_s"] = Kidnaps(threshold_, "").delays_s;
  return json.dump(1) + "\n";
}

std::string LostReport::FeatureTable() const {
  std::string table = "lost,jump";
  for (const char* name : kNames) absl::StrAppend(&table, ",", name);
  table += '\n';
  for (const LostRun& run : runs_) {
    for (size_t i = 0; i < run.drive.size(); i += kTableEvery) {
      // Localization that really was lost in a drive is no clean example.
      if (!run.drive[i].is_lost) AddRow(false, run.drive[i].features, table);
    }
    for (const KidnapTrial& trial : run.trials) {
      for (const LostSample& sample : trial.samples) {
        if (sample.is_first || !sample.is_lost ||
            sample.time_s - trial.time_s > kDeclareWithin_s) {
          continue;
        }
        AddRow(true, sample.features, table);
      }
    }
  }
  return table;
}

}  // namespace treeline::lost
