#include "nav_agent/docking/dock_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "nav_agent/docking/parameters.h"
#include "nav_agent/mapping/scan_matcher.h"

namespace treeline::docking {
namespace {

using mapping::MatchSearch;
using mapping::ScanMatch;
using mapping::ScanOutline;

constexpr size_t kSectors = 720;
constexpr double kViewStep_rad =
    2 * std::numbers::pi / static_cast<double>(kSectors);
// A direction is seen if this share of the scans has a range there, and these
// lie so far apart at most, but for the farthest quarter at both ends (m).
constexpr double kSeenShare = 0.5;
constexpr double kAgree_m = 0.08;
// Neighbours so near to each other are of one surface; nearer ones are thinned
// out (m).
constexpr double kJoin_m = 0.15;
constexpr double kSpacing_m = 0.02;
// What is further is seen coarsely (m).
constexpr double kFarthest_m = 8;
constexpr mapping::ScanMatcherOptions kMatcher = {.cell_m = 0.03,
                                                  .sigma_m = 0.04};
// Of a charger's thickness (m), beyond the robot's edge at the docked pose.
constexpr double kBodyDepth_m = 0.3;
// Its face: so many points at least, so deep, and so far from where the robot's
// width ends (m).
constexpr size_t kFacePoints = 8;
constexpr double kFaceDepth_m = 0.05;
constexpr double kFaceEnd_m = 0.02;
// Directions of a view are compared this coarsely. A beam that ends so near is
// as in the view, and one that goes so much further goes through it (m).
constexpr size_t kCompared = 180;
constexpr double kSame_m = 0.1;
constexpr double kThrough_m = 0.3;
// Of the directions compared: a door that opens is less, and a crowd leaves
// more than that.
constexpr double kThroughShare = 0.25;
constexpr double kSameShare = 0.1;

ScanOutline OutlineOf(std::span<const geometry::Vec2> points,
                      const geometry::Rigid2& target_from_points) {
  ScanOutline outline;
  for (const geometry::Vec2& from : points) {
    const geometry::Vec2 point = target_from_points * from;
    if (geometry::Norm(point) > kFarthest_m) continue;
    const double gap_m = outline.empty()
                             ? kFarthest_m
                             : geometry::Norm(point - outline.points_m.back());
    if (gap_m < kSpacing_m) continue;
    if (!outline.empty()) outline.joined.back() = gap_m <= kJoin_m ? 1 : 0;
    outline.points_m.push_back(point);
    outline.joined.push_back(0);
  }
  return outline;
}

ScanMatch Match(const ScanOutline& view, const ScanOutline& scan,
                const MatchSearch& search) {
  const mapping::PlacedScan reference = {.scan = &view, .target_from_scan = {}};
  const mapping::SurfaceGrid grid =
      mapping::MakeSurfaceGrid({&reference, 1}, scan, {}, search, kMatcher);
  return mapping::MatchScan(grid, scan, {}, search, kMatcher);
}

bool IsSure(const ScanMatch& match, double response) {
  return match.points > 0 && !match.is_at_border &&
         match.response >= response &&
         std::sqrt(std::max(match.covariance[0], match.covariance[4])) <=
             kViewStd_m;
}

// The face of a dock's body, in the docked base: how far ahead it is, and its
// middle (m).
struct BodyFace {
  double ahead_m = 0;
  double middle_m = 0;
};

// Beyond the robot's edge, or where a dock that was moved would be: the nearest
// things that end within the robot's width on both sides. nullopt: there are
// none, or they go on.
std::optional<BodyFace> FaceOf(std::span<const geometry::Vec2> points,
                               const geometry::Rigid2& docked_from_points,
                               const Dock& dock,
                               const core::RobotModel& robot) {
  const double edge_m = dock.is_backward ? robot.rear_m : robot.front_m;
  std::vector<geometry::Vec2> ahead;
  for (const geometry::Vec2& from : points) {
    geometry::Vec2 point = docked_from_points * from;
    if (dock.is_backward) point = {-point.x, -point.y};
    if (point.x >= edge_m - kBodyReach_m &&
        point.x <= edge_m + kBodyDepth_m + kBodyReach_m &&
        std::abs(point.y) <= robot.half_width_m) {
      ahead.push_back(point);
    }
  }
  if (ahead.size() < kFacePoints) return std::nullopt;
  std::ranges::sort(ahead, {}, &geometry::Vec2::x);
  // Noise puts some of them nearer.
  const double front_m = ahead[kFacePoints / 2].x;
  const auto end =
      std::ranges::find_if(ahead, [&](const geometry::Vec2& point) {
        return point.x > front_m + kFaceDepth_m;
      });
  ahead.erase(end, ahead.end());
  if (ahead.size() < kFacePoints) return std::nullopt;
  const double middle_x_m = ahead[ahead.size() / 2].x;
  const auto [right, left] =
      std::ranges::minmax_element(ahead, {}, &geometry::Vec2::y);
  if (std::max(left->y, -right->y) > robot.half_width_m - kFaceEnd_m) {
    return std::nullopt;
  }
  return BodyFace{.ahead_m = middle_x_m,
                  .middle_m = 0.5 * (left->y + right->y)};
}

// How the dock's body stands now to how it stood in the view, along its way in
// and to the left; nullopt: as it did, as far as one sees.
std::optional<geometry::Vec2> MovedBody(
    const Dock& dock, std::span<const geometry::Vec2> scan_in_map,
    const geometry::Rigid2& docked_from_map, const core::RobotModel& robot) {
  const std::optional<BodyFace> before = FaceOf(dock.view, {}, dock, robot);
  const std::optional<BodyFace> now =
      FaceOf(scan_in_map, docked_from_map, dock, robot);
  if (!before.has_value() || !now.has_value()) return std::nullopt;
  const geometry::Vec2 moved = {now->ahead_m - before->ahead_m,
                                now->middle_m - before->middle_m};
  const double moved_m = geometry::Norm(moved);
  if (moved_m < kBodyMoved_m || moved_m > kBodyReach_m) return std::nullopt;
  return dock.is_backward ? geometry::Vec2{-moved.x, -moved.y} : moved;
}

// The nearest end in each direction from the laser (m); infinity: none.
std::vector<double> NearestEnds(std::span<const geometry::Vec2> ends_in_base,
                                geometry::Vec2 laser) {
  std::vector<double> nearest_m(kCompared,
                                std::numeric_limits<double>::infinity());
  for (const geometry::Vec2& end : ends_in_base) {
    const geometry::Vec2 from_laser = end - laser;
    const double turns =
        std::atan2(from_laser.y, from_laser.x) / (2 * std::numbers::pi) + 0.5;
    double& so_far_m =
        nearest_m[static_cast<size_t>(turns * kCompared) % kCompared];
    so_far_m = std::min(so_far_m, geometry::Norm(from_laser));
  }
  return nearest_m;
}

}  // namespace

void DockViewMaker::Reset() {
  scans_ = 0;
  ranges_m_.assign(kSectors, {});
}

void DockViewMaker::Add(std::span<const geometry::Vec2> scan_in_base) {
  if (ranges_m_.empty()) Reset();
  ++scans_;
  for (const geometry::Vec2& end : scan_in_base) {
    const geometry::Vec2 from_laser = end - laser_;
    const double angle_rad =
        std::atan2(from_laser.y, from_laser.x) + std::numbers::pi;
    const auto sector =
        static_cast<size_t>(angle_rad / kViewStep_rad) % kSectors;
    ranges_m_[sector].push_back(static_cast<float>(geometry::Norm(from_laser)));
  }
}

bool DockViewMaker::IsDone() const { return scans_ >= kViewScans; }

std::vector<geometry::Vec2> DockViewMaker::View() const {
  std::vector<geometry::Vec2> view;
  for (size_t i = 0; i < ranges_m_.size(); ++i) {
    std::vector<float> ranges_m = ranges_m_[i];
    if (ranges_m.empty() ||
        static_cast<double>(ranges_m.size()) < kSeenShare * scans_) {
      continue;
    }
    std::ranges::sort(ranges_m);
    const size_t quarter = ranges_m.size() / 4;
    if (ranges_m[ranges_m.size() - 1 - quarter] - ranges_m[quarter] >
        kAgree_m) {
      continue;
    }
    const double range_m = ranges_m[ranges_m.size() / 2];
    const double angle_rad =
        (static_cast<double>(i) + 0.5) * kViewStep_rad - std::numbers::pi;
    view.push_back(laser_ + range_m * geometry::Vec2{std::cos(angle_rad),
                                                     std::sin(angle_rad)});
  }
  return view;
}

std::optional<SeenDock> FindDock(const Dock& dock,
                                 std::span<const geometry::Vec2> scan_in_map,
                                 const core::RobotModel& robot) {
  if (dock.view.empty()) return std::nullopt;
  const geometry::Rigid2 believed_from_map = dock.map_from_docked.Inverse();
  const ScanMatch match =
      Match(OutlineOf(dock.view, {}), OutlineOf(scan_in_map, believed_from_map),
            {.half_extent_m = kViewReach_m, .half_angle_rad = kViewTurn_rad});
  if (!IsSure(match, kViewResponse)) return std::nullopt;
  const geometry::Rigid2 docked_from_map =
      match.target_from_scan * believed_from_map;
  SeenDock seen = {.map_from_docked = docked_from_map.Inverse(),
                   .response = match.response};
  const std::optional<geometry::Vec2> moved =
      MovedBody(dock, scan_in_map, docked_from_map, robot);
  if (moved.has_value()) {
    seen.map_from_docked = seen.map_from_docked * geometry::Rigid2{*moved, 0};
    seen.moved_m = geometry::Norm(*moved);
  }
  return seen;
}

std::optional<geometry::Rigid2> PlaceInDock(
    const Dock& dock, std::span<const geometry::Vec2> scan_in_base) {
  if (dock.view.empty()) return std::nullopt;
  const ScanMatch match =
      Match(OutlineOf(dock.view, {}), OutlineOf(scan_in_base, {}),
            {.half_extent_m = kViewReach_m, .half_angle_rad = kViewTurn_rad});
  if (!IsSure(match, kInDockResponse)) return std::nullopt;
  return dock.map_from_docked * match.target_from_scan;
}

bool IsElsewhere(const Dock& dock, std::span<const geometry::Vec2> scan_in_base,
                 const core::RobotModel& robot) {
  const geometry::Vec2 laser = {robot.base_from_laser.translation.x,
                                robot.base_from_laser.translation.y};
  const std::vector<double> view_m = NearestEnds(dock.view, laser);
  const std::vector<double> scan_m = NearestEnds(scan_in_base, laser);
  int compared = 0;
  int same = 0;
  int through = 0;
  for (size_t i = 0; i < kCompared; ++i) {
    if (!std::isfinite(view_m[i]) || !std::isfinite(scan_m[i])) continue;
    ++compared;
    same += std::abs(scan_m[i] - view_m[i]) <= kSame_m ? 1 : 0;
    through += scan_m[i] > view_m[i] + kThrough_m ? 1 : 0;
  }
  return compared > 0 &&
         (through >= kThroughShare * compared || same <= kSameShare * compared);
}

std::shared_ptr<const localization::KnownThings> ThingsAt(
    std::span<const Dock> docks) {
  auto things = std::make_shared<localization::KnownThings>();
  for (const Dock& dock : docks) {
    std::vector<geometry::Vec2> in_map = dock.view;
    for (geometry::Vec2& point : in_map) point = dock.map_from_docked * point;
    things->Add(dock.level, in_map);
  }
  return things;
}

}  // namespace treeline::docking
