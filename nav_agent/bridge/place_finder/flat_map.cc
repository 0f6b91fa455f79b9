#include "nav_agent/bridge/place_finder/flat_map.h"

#include <array>
#include <cmath>
#include <utility>

#include "common/base/status_macros.h"
#include "nav_agent/behavior/relocalization_parameters.h"
#include "nav_agent/core/distance_field.h"

namespace treeline::place_finder {
namespace {

constexpr double kReach_m = 2;

}  // namespace

absl::StatusOr<FlatMap> FlatMap::Make(core::OccupancyGrid grid) {
  TL_ASSIGN_OR_RETURN(localization::ScanChecker checker,
                      localization::ScanChecker::Create(
                          localization::LaserMap::AllOpaque(grid), {}));
  return FlatMap(std::move(grid), std::move(checker));
}

FlatMap::FlatMap(core::OccupancyGrid grid, localization::ScanChecker checker)
    : grid_(std::move(grid)),
      checker_(std::move(checker)),
      distances_m_(core::DistanceToOccupied(grid_, kReach_m)) {}

double FlatMap::Clearance_m(geometry::Vec2 point_in_map) const {
  const core::CellIndex cell = grid_.CellOf(point_in_map);
  if (grid_.AtOrUnknown(cell) != core::Occupancy::kFree) return 0;
  return static_cast<double>(distances_m_[grid_.IndexOf(cell)]);
}

std::optional<localization::ScanFit> FlatMap::FitOf(
    const PlacedScan& scan, const geometry::Rigid2& map_from_base) const {
  const auto beams = checker_.Check({.map_from_base = map_from_base,
                                     .pitch_rad = scan.pitch_rad,
                                     .roll_rad = scan.roll_rad},
                                    scan.info, scan.base_from_laser, scan.scan);
  if (!beams.ok()) return std::nullopt;
  localization::ScanFit fit;
  for (const localization::CheckedBeam& beam : *beams) {
    if (beam.fit == localization::BeamFit::kNotJudged) continue;
    ++fit.judged;
    fit.explained += beam.fit == localization::BeamFit::kExplained ? 1 : 0;
    fit.contradicted += beam.fit == localization::BeamFit::kLong ? 1 : 0;
  }
  if (fit.judged == 0) return fit;
  fit.explained /= fit.judged;
  fit.contradicted /= fit.judged;
  return fit;
}

std::optional<localization::FittedPose> FlatMap::BestNear(
    const PlacedScan& scan, const geometry::Rigid2& map_from_base,
    const behavior::FixGateOptions& gate) const {
  const auto here = FitOf(scan, map_from_base);
  if (!here.has_value()) return std::nullopt;
  const core::LevelPose begin = {.map_from_base = map_from_base, .place = {}};
  const std::array<localization::FitStep, 2> passes = {
      {{.m = gate.search_m * 2 / 3, .rad = gate.search_rad * 2 / 3},
       {.m = gate.search_m / 3, .rad = gate.search_rad / 3}}};
  return localization::RefineFit(
      {.pose = begin, .fit = *here, .score = localization::FitScore(*here)},
      passes, 1e-9,
      [&](const core::LevelPose& pose) {
        return FitOf(scan, pose.map_from_base);
      },
      [&](const core::LevelPose& pose, const localization::ScanFit& fit) {
        const double moved_m = geometry::Norm(pose.map_from_base.translation -
                                              map_from_base.translation);
        const double turned_rad = std::abs(geometry::NormalizedAngle_rad(
            pose.map_from_base.yaw_rad - map_from_base.yaw_rad));
        return localization::FitScore(fit) -
               behavior::kFitMoveCost_per_m * moved_m -
               behavior::kFitTurnCost_per_rad * turned_rad;
      });
}

}  // namespace treeline::place_finder
