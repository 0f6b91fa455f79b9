#include "client/scrape/metrics_text.h"

#include <cmath>
#include <limits>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace treeline::scrape {
namespace {

std::string Text(absl::string_view text) { return {text.data(), text.size()}; }

// One line, read from its front.
class LineReader {
 public:
  explicit LineReader(absl::string_view line) : rest_(line) {}

  // A name of a metric or a label; empty if there is none.
  std::string Name() {
    size_t size = 0;
    while (size < rest_.size() &&
           (absl::ascii_isalnum(static_cast<unsigned char>(rest_[size])) ||
            rest_[size] == '_' || rest_[size] == ':')) {
      ++size;
    }
    std::string name = Text(rest_.substr(0, size));
    rest_.remove_prefix(size);
    return name;
  }

  bool Take(char expected) {
    Blanks();
    if (rest_.empty() || rest_.front() != expected) return false;
    rest_.remove_prefix(1);
    return true;
  }

  // What stands between quotes; nullopt: they do not close.
  std::optional<std::string> Quoted() {
    if (!Take('"')) return std::nullopt;
    std::string value;
    while (!rest_.empty() && rest_.front() != '"') {
      char c = rest_.front();
      rest_.remove_prefix(1);
      if (c == '\\') {
        if (rest_.empty()) return std::nullopt;
        c = rest_.front() == 'n' ? '\n' : rest_.front();
        rest_.remove_prefix(1);
      }
      value.push_back(c);
    }
    if (rest_.empty()) return std::nullopt;
    rest_.remove_prefix(1);
    return value;
  }

  // {name="value",...}; an empty one and none at all are the same.
  std::optional<Labels> ReadLabels() {
    Labels labels;
    if (!Take('{')) return labels;
    while (!Take('}')) {
      Blanks();
      const std::string name = Name();
      if (name.empty() || !Take('=')) return std::nullopt;
      std::optional<std::string> value = Quoted();
      if (!value) return std::nullopt;
      labels[name] = *std::move(value);
      if (!Take(',') && (rest_.empty() || rest_.front() != '}')) {
        return std::nullopt;
      }
    }
    return labels;
  }

  // The value; a time stamp may follow.
  std::optional<double> Value() {
    const std::vector<absl::string_view> words =
        absl::StrSplit(rest_, absl::ByAnyChar(" \t"), absl::SkipEmpty());
    double value = 0;
    int64_t stamp = 0;
    if (words.empty() || words.size() > 2 ||
        !absl::SimpleAtod(words[0], &value) ||
        (words.size() == 2 && !absl::SimpleAtoi(words[1], &stamp))) {
      return std::nullopt;
    }
    return value;
  }

 private:
  void Blanks() { rest_ = absl::StripLeadingAsciiWhitespace(rest_); }

  absl::string_view rest_;
};

bool Matches(const Labels& labels, const Labels& match) {
  for (const auto& [name, value] : match) {
    const auto found = labels.find(name);
    if (found == labels.end() || found->second != value) return false;
  }
  return true;
}

}  // namespace

absl::StatusOr<MetricsSnapshot> MetricsSnapshot::Parse(absl::string_view text) {
  MetricsSnapshot snapshot;
  int number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty() || line.front() == '#') continue;
    LineReader reader(line);
    const std::string name = reader.Name();
    std::optional<Labels> labels = reader.ReadLabels();
    const std::optional<double> value = reader.Value();
    if (name.empty() || !labels || !value) {
      return absl::InvalidArgumentError(absl::StrCat(
          "line ", number, " is no metric in Prometheus' text format"));
    }
    snapshot.samples_[name].emplace_back(*std::move(labels), *value);
  }
  return snapshot;
}

double MetricsSnapshot::Sum(const std::string& name,
                            const Labels& match) const {
  const auto found = samples_.find(name);
  double sum = 0;
  if (found == samples_.end()) return sum;
  for (const auto& [labels, value] : found->second) {
    if (Matches(labels, match)) sum += value;
  }
  return sum;
}

std::map<std::string, double> MetricsSnapshot::SumBy(
    const std::string& name, const std::string& label) const {
  std::map<std::string, double> sums;
  const auto found = samples_.find(name);
  if (found == samples_.end()) return sums;
  for (const auto& [labels, value] : found->second) {
    const auto of = labels.find(label);
    if (of != labels.end()) sums[of->second] += value;
  }
  return sums;
}

std::map<double, double> MetricsSnapshot::Buckets(const std::string& histogram,
                                                  const Labels& match) const {
  std::map<double, double> buckets;
  const auto found = samples_.find(histogram + "_bucket");
  if (found == samples_.end()) return buckets;
  for (const auto& [labels, value] : found->second) {
    const auto bound = labels.find("le");
    double upper = 0;
    if (bound == labels.end() || !Matches(labels, match) ||
        !absl::SimpleAtod(bound->second, &upper) || std::isnan(upper)) {
      continue;
    }
    buckets[upper] += value;
  }
  return buckets;
}

double HistogramQuantile(double share,
                         const std::map<double, double>& buckets) {
  const double total = buckets.empty() ? 0 : buckets.rbegin()->second;
  if (!(total > 0)) return std::numeric_limits<double>::quiet_NaN();
  const double rank = share * total;
  double below_bound = 0;
  double below = 0;
  for (const auto& [bound, count] : buckets) {
    if (count >= rank) {
      if (std::isinf(bound) || count <= below) return below_bound;
      return below_bound +
             (bound - below_bound) * (rank - below) / (count - below);
    }
    below_bound = bound;
    below = count;
  }
  return below_bound;
}

}  // namespace treeline::scrape
