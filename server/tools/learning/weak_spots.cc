#include "server/tools/learning/weak_spots.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "absl/strings/str_cat.h"

namespace treeline::learning {
namespace {

using keyframes::CoverageMap;
using keyframes::CoveragePlace;

// Less is what any recording has: near walls, and looking at them.
constexpr double kMinMissing = 0.4;
// Somebody who stands there and turns round covers about this much of a room;
// large scenes have larger spots, so that a few of them matter.
constexpr double kMinRadius_m = 0.4;
constexpr double kMaxRadius_m = 2;
constexpr double kRadiusOfScene = 0.08;  // times the root of the open area
// A disc with less open ground in it is a corner.
constexpr double kMinOpen = 0.2;
constexpr double kApart = 2.5;  // radii
// From here on, "turn round" says more than a direction.
constexpr double kNearlyAll = 0.75;

double MissingShare(const CoverageMap& coverage, const CoveragePlace& place) {
  return 1 - static_cast<double>(std::popcount(place.good)) / coverage.headings;
}

// Calls visit(place) for the open places within `radius_m` of a point.
template <typename Visit>
void ForEachNear(const CoverageMap& coverage, double x_m, double y_m,
                 double radius_m, const Visit& visit) {
  const auto first = [&](double at_m, double min_m) {
    return std::max(
        0, static_cast<int>((at_m - radius_m - min_m) / coverage.cell_m - 1));
  };
  for (int r = first(y_m, coverage.min_y_m); r < coverage.rows; ++r) {
    const double y = coverage.min_y_m + (r + 0.5) * coverage.cell_m;
    if (y > y_m + radius_m) break;
    for (int c = first(x_m, coverage.min_x_m); c < coverage.columns; ++c) {
      const double x = coverage.min_x_m + (c + 0.5) * coverage.cell_m;
      if (x > x_m + radius_m) break;
      const CoveragePlace& place =
          coverage.places[static_cast<size_t>(r * coverage.columns + c)];
      if (place.is_open && std::hypot(x - x_m, y - y_m) <= radius_m) {
        visit(place);
      }
    }
  }
}

// The middle of the headings that most of the disc lacks.
std::optional<double> Towards(const CoverageMap& coverage,
                              const WeakSpot& spot) {
  if (spot.missing_share > kNearlyAll) return std::nullopt;
  double x = 0;
  double y = 0;
  ForEachNear(coverage, spot.x_m, spot.y_m, spot.radius_m,
              [&](const CoveragePlace& place) {
                for (int h = 0; h < coverage.headings; ++h) {
                  if (((place.good >> h) & 1u) != 0) continue;
                  x += std::cos(coverage.Heading_rad(h));
                  y += std::sin(coverage.Heading_rad(h));
                }
              });
  if (x == 0 && y == 0) return std::nullopt;
  return std::atan2(y, x);
}

struct Candidate {
  WeakSpot spot;
  double missing = 0;  // places times share
};

std::vector<Candidate> Candidates(const CoverageMap& coverage,
                                  double radius_m) {
  const double disc_places = std::numbers::pi * radius_m * radius_m /
                             (coverage.cell_m * coverage.cell_m);
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < coverage.places.size(); ++i) {
    if (!coverage.places[i].is_open) continue;
    const int row = static_cast<int>(i) / coverage.columns;
    const int column = static_cast<int>(i) % coverage.columns;
    Candidate candidate{
        .spot = {.x_m = coverage.min_x_m + (column + 0.5) * coverage.cell_m,
                 .y_m = coverage.min_y_m + (row + 0.5) * coverage.cell_m,
                 .radius_m = radius_m}};
    int places = 0;
    ForEachNear(coverage, candidate.spot.x_m, candidate.spot.y_m, radius_m,
                [&](const CoveragePlace& place) {
                  ++places;
                  candidate.missing += MissingShare(coverage, place);
                });
    candidate.spot.missing_share = candidate.missing / places;
    if (candidate.spot.missing_share >= kMinMissing &&
        places >= kMinOpen * disc_places) {
      candidates.push_back(candidate);
    }
  }
  return candidates;
}

}  // namespace

std::vector<WeakSpot> FindWeakSpots(const CoverageMap& coverage, int count) {
  const double open_m2 = keyframes::Summarize(coverage).open_m2;
  const double radius_m = std::clamp(kRadiusOfScene * std::sqrt(open_m2),
                                     kMinRadius_m, kMaxRadius_m);
  std::vector<Candidate> candidates = Candidates(coverage, radius_m);
  std::ranges::stable_sort(candidates, std::ranges::greater(),
                           &Candidate::missing);
  std::vector<WeakSpot> spots;
  for (const Candidate& candidate : candidates) {
    if (static_cast<int>(spots.size()) >= count) break;
    const WeakSpot& spot = candidate.spot;
    const bool is_apart = std::ranges::all_of(spots, [&](const WeakSpot& s) {
      return std::hypot(s.x_m - spot.x_m, s.y_m - spot.y_m) >=
             kApart * radius_m;
    });
    if (!is_apart) continue;
    spots.push_back(spot);
    spots.back().towards_rad = Towards(coverage, spot);
  }
  return spots;
}

std::string DirectionOnPlan(double heading_rad) {
  constexpr const char* kNames[] = {"right",    "top right",   "top",
                                    "top left", "left",        "bottom left",
                                    "bottom",   "bottom right"};
  constexpr int kCount = 8;
  const int nearest = static_cast<int>(
      std::lround(heading_rad / (2 * std::numbers::pi) * kCount));
  return absl::StrCat("the ", kNames[((nearest % kCount) + kCount) % kCount],
                      " of the plan");
}

}  // namespace treeline::learning
