#include "evaluation/lost/lost_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace treeline::lost {
namespace {

constexpr int kSteps = 3000;
constexpr double kRate = 4;
// Of the squares of the weights: those that nothing speaks for stay small.
constexpr double kRidge = 1e-4;

struct Row {
  bool is_lost = false;
  std::array<double, localization::kLostFeatures> values{};
};

absl::StatusOr<std::vector<Row>> ReadRows(const std::string& table) {
  std::vector<Row> rows;
  int number = 0;
  for (const absl::string_view line : absl::StrSplit(table, '\n')) {
    ++number;
    if (number == 1 || line.empty()) continue;
    const std::vector<absl::string_view> fields = absl::StrSplit(line, ',');
    Row row;
    bool is_good = fields.size() == localization::kLostFeatures + 2 &&
                   (fields[0] == "0" || fields[0] == "1");
    if (is_good) row.is_lost = fields[0] == "1";
    for (size_t i = 0; is_good && i < localization::kLostFeatures; ++i) {
      is_good = absl::SimpleAtod(fields[i + 2], &row.values[i]) &&
                std::isfinite(row.values[i]);
    }
    if (!is_good) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", number, " is no row of a feature table"));
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

absl::StatusOr<localization::LostModel> FitLostModel(const std::string& table) {
  const absl::StatusOr<std::vector<Row>> rows = ReadRows(table);
  if (!rows.ok()) return rows.status();
  const auto lost = std::ranges::count(*rows, true, &Row::is_lost);
  const auto others = static_cast<std::ptrdiff_t>(rows->size()) - lost;
  if (lost == 0 || others == 0) {
    return absl::InvalidArgumentError(
        "a fit needs scans of robots that are lost, and of others");
  }
  localization::LostModel model;
  for (int step = 0; step < kSteps; ++step) {
    double bias_slope = 0;
    std::array<double, localization::kLostFeatures> slopes{};
    for (const Row& row : *rows) {
      const double p = 1 / (1 + std::exp(-model.LogRatio(row.values)));
      const double error = row.is_lost ? (p - 1) / static_cast<double>(lost)
                                       : p / static_cast<double>(others);
      bias_slope += error / 2;
      for (size_t i = 0; i < localization::kLostFeatures; ++i) {
        slopes[i] += error / 2 * row.values[i];
      }
    }
    model.bias -= kRate * bias_slope;
    for (size_t i = 0; i < localization::kLostFeatures; ++i) {
      model.weights[i] =
          std::max(0.0, model.weights[i] -
                            kRate * (slopes[i] + kRidge * model.weights[i]));
    }
  }
  return model;
}

std::string LostModelText(const localization::LostModel& model) {
  std::string text = absl::StrFormat("bias %.3f; weights", model.bias);
  for (const double weight : model.weights) {
    absl::StrAppendFormat(&text, " %.3f", weight);
  }
  return text + "\n";
}

}  // namespace treeline::lost
