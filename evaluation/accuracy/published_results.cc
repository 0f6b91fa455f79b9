#include "evaluation/accuracy/published_results.h"

#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "evaluation/accuracy/published_data.h"

namespace treeline::accuracy {
namespace {

constexpr const char* kSeparator = " | ";

std::string Field(const std::vector<std::string>& fields, size_t i) {
  return i < fields.size() ? fields[i] : std::string();
}

std::optional<double> Figure(const std::vector<std::string>& fields, size_t i) {
  double value = 0;
  if (!absl::SimpleAtod(Field(fields, i), &value)) return std::nullopt;
  return value;
}

std::vector<PublishedTable> Parse(absl::string_view text) {
  std::vector<PublishedTable> tables;
  PublishedResult method;
  for (absl::string_view line :
       absl::StrSplit(text, '\n', absl::SkipWhitespace())) {
    const bool starts_table = absl::ConsumePrefix(&line, "dataset: ");
    const bool starts_method = absl::ConsumePrefix(&line, "method: ");
    const std::vector<std::string> fields = absl::StrSplit(line, kSeparator);
    if (starts_table) {
      tables.push_back(
          {Field(fields, 0), Field(fields, 1), Field(fields, 2), {}});
    } else if (starts_method) {
      method = {};
      method.method = Field(fields, 0);
      method.training = Field(fields, 1);
      method.query = Field(fields, 2);
      method.source = Field(fields, 3);
      method.note = Field(fields, 4);
    } else {
      PublishedResult result = method;
      result.scene = Field(fields, 0);
      result.correct_percent = Figure(fields, 1);
      result.median_cm = Figure(fields, 2);
      result.median_deg = Figure(fields, 3);
      tables.back().results.push_back(std::move(result));
    }
  }
  return tables;
}

// Lower-case letters and digits alone.
std::string Bare(absl::string_view text) {
  std::string bare;
  for (char c : text) {
    if (absl::ascii_isalnum(static_cast<unsigned char>(c))) {
      bare += absl::ascii_tolower(static_cast<unsigned char>(c));
    }
  }
  return bare;
}

}  // namespace

std::vector<PublishedTable> PublishedTables() { return Parse(PublishedData()); }

std::optional<PublishedTable> PublishedFor(absl::string_view dataset_uri) {
  const absl::string_view scheme = dataset_uri.substr(0, dataset_uri.find(':'));
  const absl::string_view kind =
      scheme == "colmap" || scheme == "nvm" ? "cambridge" : scheme;
  std::vector<PublishedTable> tables = PublishedTables();
  for (PublishedTable& table : tables) {
    if (kind == table.kind) return std::move(table);
  }
  return std::nullopt;
}

std::string SceneOf(const PublishedTable& table,
                    absl::string_view dataset_uri) {
  const std::string name = Bare(dataset_uri);
  std::string longest;
  for (const PublishedResult& result : table.results) {
    if (result.scene != "average" && result.scene.size() > longest.size() &&
        absl::StrContains(name, Bare(result.scene))) {
      longest = result.scene;
    }
  }
  return longest;
}

std::vector<PublishedResult> ResultsFor(const PublishedTable& table,
                                        absl::string_view scene) {
  std::vector<PublishedResult> results;
  for (const PublishedResult& result : table.results) {
    if (result.scene == scene) results.push_back(result);
  }
  return results;
}

}  // namespace treeline::accuracy
