#include "common/metrics/testing_exposition.h"

#include <cmath>
#include <limits>
#include <memory>
#include <regex>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace treeline::metrics {
namespace {

struct ParsedSample {
  std::string name;
  std::map<std::string, std::string> labels;
  double value = 0;
};

absl::Status Bad(absl::string_view why) {
  return absl::InvalidArgumentError(why);
}

absl::StatusOr<double> ParseNumber(const std::string& text) {
  if (text == "+Inf") return std::numeric_limits<double>::infinity();
  if (text == "-Inf") return -std::numeric_limits<double>::infinity();
  if (text == "NaN") return std::nan("");
  double value = 0;
  static const std::regex number("[-+]?[0-9.]+(e[-+]?[0-9]+)?");
  if (!std::regex_match(text, number) || !absl::SimpleAtod(text, &value)) {
    return Bad(absl::StrCat("'", text, "' is not a number"));
  }
  return value;
}

// `rest` starts behind the opening brace, and then behind the closing one.
absl::Status ParseLabels(absl::string_view& rest, ParsedSample& sample) {
  static const std::regex label_name("[a-zA-Z_][a-zA-Z0-9_]*");
  while (true) {
    const size_t equals = rest.find("=\"");
    if (equals == absl::string_view::npos) return Bad("a label without =\"");
    const std::string name(rest.substr(0, equals));
    if (!std::regex_match(name, label_name)) return Bad("a bad label name");
    rest.remove_prefix(equals + 2);
    std::string value;
    while (true) {
      if (rest.empty()) return Bad("a label value without an end");
      char c = rest[0];
      rest.remove_prefix(1);
      if (c == '"') break;
      if (c == '\\') {
        if (rest.empty()) return Bad("a backslash at the end");
        c = rest[0];
        rest.remove_prefix(1);
        if (c != '\\' && c != '"' && c != 'n') return Bad("a bad escape");
        if (c == 'n') c = '\n';
      }
      value.push_back(c);
    }
    if (!sample.labels.insert({name, value}).second) {
      return Bad("a label twice");
    }
    if (absl::ConsumePrefix(&rest, "}")) return absl::OkStatus();
    if (!absl::ConsumePrefix(&rest, ",")) return Bad("no comma after a label");
  }
}

absl::StatusOr<ParsedSample> ParseSample(absl::string_view line) {
  static const std::regex metric_name("[a-zA-Z_:][a-zA-Z0-9_:]*");
  ParsedSample sample;
  const size_t end = line.find_first_of("{ ");
  if (end == absl::string_view::npos) return Bad("a sample without a value");
  sample.name = std::string(line.substr(0, end));
  if (!std::regex_match(sample.name, metric_name)) return Bad("a bad name");
  absl::string_view rest = line.substr(end);
  if (absl::ConsumePrefix(&rest, "{")) {
    const absl::Status status = ParseLabels(rest, sample);
    if (!status.ok()) return status;
  }
  if (!absl::ConsumePrefix(&rest, " ")) return Bad("no space before the value");
  const auto value = ParseNumber(std::string(rest));
  if (!value.ok()) return value.status();
  sample.value = *value;
  return sample;
}

std::string KeyOf(const std::string& name,
                  const std::map<std::string, std::string>& labels) {
  std::string key = name;
  for (const auto& [label, value] : labels) {
    absl::StrAppend(&key, key.size() == name.size() ? "{" : ",", label, "=",
                    value);
  }
  if (key.size() > name.size()) key += "}";
  return key;
}

// The family being read, and what its histograms have so far.
class FamilyReader {
 public:
  FamilyReader(std::string name, std::string help) : name_(std::move(name)) {
    family_.help = std::move(help);
  }

  const std::string& name() const { return name_; }
  ParsedFamily& family() { return family_; }

  absl::Status Add(ParsedSample sample) {
    const std::string key = KeyOf(sample.name, sample.labels);
    if (!family_.samples.insert({key, sample.value}).second) {
      return Bad(absl::StrCat(key, " twice"));
    }
    if (family_.type != "histogram") {
      if (sample.name != name_) return Bad("a sample of another family");
      if (family_.type == "counter" && !(sample.value >= 0)) {
        return Bad("a counter below 0");
      }
      return absl::OkStatus();
    }
    return AddToHistogram(std::move(sample));
  }

  absl::Status Finish() const {
    if (family_.type.empty()) return Bad(name_ + " has no TYPE");
    for (const auto& [labels, histogram] : histograms_) {
      if (!std::isinf(histogram.last_bound)) return Bad("no bucket +Inf");
      if (!histogram.has_sum || histogram.count != histogram.last_count) {
        return Bad("_count or _sum is missing or wrong");
      }
    }
    return absl::OkStatus();
  }

 private:
  struct Read {
    double last_bound = -std::numeric_limits<double>::infinity();
    double last_count = 0;
    double count = -1;
    bool has_sum = false;
  };

  absl::Status AddToHistogram(ParsedSample sample) {
    std::string bound_text;
    if (const auto le = sample.labels.find("le"); le != sample.labels.end()) {
      bound_text = le->second;
      sample.labels.erase(le);
    }
    Read& read = histograms_[KeyOf("", sample.labels)];
    if (sample.name == name_ + "_sum") {
      read.has_sum = true;
    } else if (sample.name == name_ + "_count") {
      read.count = sample.value;
    } else if (sample.name == name_ + "_bucket") {
      const auto bound = ParseNumber(bound_text);
      if (!bound.ok()) return bound.status();
      if (!(*bound > read.last_bound)) return Bad("bounds do not ascend");
      if (sample.value < read.last_count) return Bad("buckets do not ascend");
      read.last_bound = *bound;
      read.last_count = sample.value;
    } else {
      return Bad("a sample of another family");
    }
    return absl::OkStatus();
  }

  const std::string name_;
  ParsedFamily family_;
  std::map<std::string, Read> histograms_;
};

// Reads line by line.
class Parser {
 public:
  absl::Status Add(absl::string_view line) {
    if (absl::ConsumePrefix(&line, "# HELP ")) return Start(line);
    if (reader_ == nullptr) return Bad("no HELP in front");
    if (absl::ConsumePrefix(&line, "# TYPE ")) return Type(line);
    if (absl::StartsWith(line, "#")) return Bad("a comment of no use");
    if (reader_->family().type.empty()) return Bad("no TYPE in front");
    auto sample = ParseSample(line);
    if (!sample.ok()) return sample.status();
    return reader_->Add(*std::move(sample));
  }

  absl::Status FinishFamily() {
    if (reader_ == nullptr) return absl::OkStatus();
    const absl::Status status = reader_->Finish();
    if (!status.ok()) return status;
    if (!families_.insert({reader_->name(), reader_->family()}).second) {
      return Bad(reader_->name() + " in two places");
    }
    reader_.reset();
    return absl::OkStatus();
  }

  std::map<std::string, ParsedFamily> TakeFamilies() {
    return std::move(families_);
  }

 private:
  absl::Status Start(absl::string_view line) {
    const absl::Status status = FinishFamily();
    if (!status.ok()) return status;
    const std::pair<std::string, std::string> words =
        absl::StrSplit(line, absl::MaxSplits(' ', 1));
    if (words.second.empty()) return Bad("HELP says nothing");
    reader_ = std::make_unique<FamilyReader>(words.first, words.second);
    return absl::OkStatus();
  }

  absl::Status Type(absl::string_view line) {
    const std::pair<std::string, std::string> words =
        absl::StrSplit(line, absl::MaxSplits(' ', 1));
    static const auto* const types =
        new std::set<std::string>{"counter", "gauge", "histogram"};
    if (words.first != reader_->name() || !reader_->family().type.empty() ||
        types->count(words.second) == 0) {
      return Bad("a bad TYPE");
    }
    reader_->family().type = words.second;
    return absl::OkStatus();
  }

  std::unique_ptr<FamilyReader> reader_;
  std::map<std::string, ParsedFamily> families_;
};

}  // namespace

absl::StatusOr<std::map<std::string, ParsedFamily>> ParseExposition(
    absl::string_view text) {
  if (!absl::EndsWith(text, "\n")) return Bad("the last line has no end");
  text.remove_suffix(1);
  Parser parser;
  int number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    const absl::Status status = parser.Add(line);
    if (!status.ok()) {
      return Bad(
          absl::StrCat("line ", number, ": ", status.message(), ": ", line));
    }
  }
  const absl::Status status = parser.FinishFamily();
  if (!status.ok()) return status;
  return parser.TakeFamilies();
}

double SampleOf(const std::map<std::string, ParsedFamily>& families,
                const std::string& key) {
  for (const auto& [name, family] : families) {
    const auto sample = family.samples.find(key);
    if (sample != family.samples.end()) return sample->second;
  }
  return 0;
}

}  // namespace treeline::metrics
