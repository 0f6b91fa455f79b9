#include "server/tools/coverage_text.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "absl/strings/str_format.h"
#include "nlohmann/json.hpp"

namespace treeline::tools {
namespace {

using Json = nlohmann::ordered_json;

double Degrees(double rad) { return rad * 180 / std::numbers::pi; }

// A JSON list a row of the grid.
template <typename Value>
Json Rows(const keyframes::CoverageMap& coverage, const Value& value) {
  Json rows = Json::array();
  for (int r = 0; r < coverage.rows; ++r) {
    Json row = Json::array();
    for (int c = 0; c < coverage.columns; ++c) {
      row.push_back(value(
          coverage.places[static_cast<size_t>(r * coverage.columns + c)]));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

DescriptionSection DescribeCoverage(const keyframes::CoverageMap& coverage) {
  const keyframes::CoverageSummary summary = keyframes::Summarize(coverage);
  return {"Coverage (predicted)",
          {{"open area", absl::StrFormat("%.1f m^2", summary.open_m2)},
           {"views answered", absl::StrFormat("%.0f %% good, %.0f %% perhaps",
                                              100 * summary.good_share,
                                              100 * summary.weak_share)},
           {"places answered",
            absl::StrFormat("%.0f %% in some heading, %.0f %% in all",
                            100 * summary.any_heading_share,
                            100 * summary.all_headings_share)},
           {"of cameras",
            absl::StrFormat("%.2f m above the ground, tilted %+.0f deg",
                            coverage.height_m - coverage.ground_m,
                            Degrees(coverage.tilt_rad))}}};
}

std::string CoverageJson(const keyframes::CoverageMap& coverage) {
  const keyframes::CoverageSummary summary = keyframes::Summarize(coverage);
  const geometry::Rotation3& q = coverage.plan_from_world;
  Json headings_deg = Json::array();
  for (int h = 0; h < coverage.headings; ++h) {
    headings_deg.push_back(Degrees(coverage.Heading_rad(h)));
  }
  const Json json{
      {"plan_from_world", {{"qw", q.w}, {"qx", q.x}, {"qy", q.y}, {"qz", q.z}}},
      {"min_x_m", coverage.min_x_m},
      {"min_y_m", coverage.min_y_m},
      {"cell_m", coverage.cell_m},
      {"columns", coverage.columns},
      {"rows", coverage.rows},
      {"height_m", coverage.height_m},
      {"ground_m", coverage.ground_m},
      {"tilt_deg", Degrees(coverage.tilt_rad)},
      {"headings_deg", std::move(headings_deg)},
      {"summary",
       {{"open_m2", summary.open_m2},
        {"good_share", summary.good_share},
        {"weak_share", summary.weak_share},
        {"any_heading_share", summary.any_heading_share},
        {"all_headings_share", summary.all_headings_share}}},
      {"open", Rows(coverage, [](const auto& p) { return p.is_open ? 1 : 0; })},
      {"good", Rows(coverage, [](const auto& p) { return p.good; })},
      {"weak", Rows(coverage, [](const auto& p) { return p.weak; })}};
  return json.dump() + "\n";
}

}  // namespace treeline::tools
