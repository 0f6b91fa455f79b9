#include "nav_agent/recording/laser_log_json.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/dataset/text_lines.h"
#include "nav_agent/recording/log_builder.h"

namespace treeline::recording {
namespace {

using Json = nlohmann::json;

// Walks over text and counts its lines, which the parser does not tell.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, int* line) : at_(at), line_(line) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    if (*at_ == '\n') ++*line_;
    ++at_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator old = *this;
    ++*this;
    return old;
  }
  bool operator==(const CountingIterator& other) const {
    return at_ == other.at_;
  }
  bool operator!=(const CountingIterator& other) const {
    return at_ != other.at_;
  }

 private:
  const char* at_;
  int* line_;
};

struct ScanFields {
  int line = 0;
  std::string stamp;
  std::vector<float> ranges_m = {};
  bool has_ranges = false;
  std::optional<double> x_m = {};
  std::optional<double> y_m = {};
  std::optional<double> theta_rad = {};
};

// Takes the parser's events: nothing is kept but the scans themselves.
class Handler {
 public:
  Handler(std::string name, const int* line)
      : name_(std::move(name)), line_(line) {}

  bool null() { return Fail("null where a number belongs"); }
  bool boolean(bool) { return Fail("true or false where a number belongs"); }
  bool number_integer(int64_t value) {
    return Number(static_cast<double>(value));
  }
  bool number_unsigned(uint64_t value) {
    return Number(static_cast<double>(value));
  }
  bool number_float(double value, const std::string&) { return Number(value); }
  bool string(std::string&) { return Fail("a text where a number belongs"); }
  bool binary(Json::binary_t&) { return Fail("binary data"); }

  bool start_object(std::size_t) {
    if (in_ranges_) return Fail("an object within \"range\"");
    if (depth_ == 3) return Fail("an object within a scan");
    if (depth_ == 2) {
      scan_ = {.line = *line_, .stamp = key_};
    }
    if (depth_ == 1 && key_ != "map") {
      return Fail(absl::StrCat("expected \"map\", not \"",
                               absl::CHexEscape(key_.substr(0, 40)), "\""));
    }
    ++depth_;
    return true;
  }
  bool key(std::string& name) {
    key_ = name;
    return true;
  }
  bool end_object() {
    if (depth_ == 3) scans_.push_back(std::move(scan_));
    --depth_;
    return true;
  }
  bool start_array(std::size_t) {
    if (in_ranges_ || depth_ != 3 || key_ != "range" || scan_.has_ranges) {
      return Fail("a list where none belongs");
    }
    in_ranges_ = true;
    scan_.has_ranges = true;
    return true;
  }
  bool end_array() {
    in_ranges_ = false;
    return true;
  }
  bool parse_error(std::size_t, const std::string&,
                   const nlohmann::detail::exception&) {
    return Fail("not JSON from here on");
  }

  const absl::Status& status() const { return status_; }
  std::vector<ScanFields>& scans() { return scans_; }

 private:
  bool Fail(absl::string_view what) {
    if (status_.ok()) status_ = dataset::LineError(name_, *line_, what);
    return false;
  }
  bool Number(double value) {
    if (!std::isfinite(value)) return Fail("a number that is not finite");
    if (in_ranges_) {
      if (scan_.ranges_m.size() >= static_cast<size_t>(kMaxLogBeams)) {
        return Fail("too many beams");
      }
      scan_.ranges_m.push_back(static_cast<float>(value));
      return true;
    }
    if (depth_ != 3) return Fail("a number where scans belong");
    std::optional<double>* field = nullptr;
    if (key_ == "x") field = &scan_.x_m;
    if (key_ == "y") field = &scan_.y_m;
    if (key_ == "theta") field = &scan_.theta_rad;
    if (field == nullptr) return true;  // more than we need
    if (field->has_value()) return Fail(absl::StrCat("two of ", key_));
    *field = value;
    return true;
  }

  const std::string name_;
  const int* const line_;
  absl::Status status_;
  int depth_ = 0;
  bool in_ranges_ = false;
  std::string key_;
  ScanFields scan_;
  std::vector<ScanFields> scans_;
};

}  // namespace

absl::StatusOr<LaserLog> ParseLaserLogJson(absl::string_view text,
                                           const std::string& name,
                                           const LaserLogOptions& options) {
  int line = 1;
  Handler handler(name, &line);
  int end_line = 0;
  const bool read = Json::sax_parse(
      CountingIterator(text.data(), &line),
      CountingIterator(text.data() + text.size(), &end_line), &handler);
  if (!read || !handler.status().ok()) {
    return handler.status().ok() ? dataset::LineError(name, line, "not JSON")
                                 : handler.status();
  }
  std::vector<std::pair<RecordingTime, ScanFields>> scans;
  for (ScanFields& scan : handler.scans()) {
    const std::optional<RecordingTime> stamp = ParseRecordingTime(scan.stamp);
    if (!stamp.has_value()) {
      return dataset::LineError(
          name, scan.line,
          absl::StrCat("'", absl::CHexEscape(scan.stamp.substr(0, 40)),
                       "' is not a time stamp in seconds"));
    }
    if (!scan.x_m || !scan.y_m || !scan.theta_rad || !scan.has_ranges) {
      return dataset::LineError(name, scan.line,
                                "a scan needs range, x, y and theta");
    }
    scans.emplace_back(*stamp, std::move(scan));
  }
  // The order of an object's members means nothing in JSON.
  std::stable_sort(
      scans.begin(), scans.end(),
      [](const auto& a, const auto& b) { return a.first < b.first; });
  LogBuilder builder(name, options);
  for (auto& [stamp, scan] : scans) {
    const core::RangeSensorInfo laser =
        SickGeometry(static_cast<int>(scan.ranges_m.size()));
    const absl::Status added = builder.AddScan(
        scan.line, stamp, {{*scan.x_m, *scan.y_m}, *scan.theta_rad}, laser,
        std::move(scan.ranges_m));
    if (!added.ok()) return added;
  }
  return builder.Build();
}

}  // namespace treeline::recording
