#include "nav_agent/control/band_follower.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "nav_agent/control/driving_parameters.h"

namespace treeline::control {
namespace {

// Where along the path the end is reached (m).
constexpr double kEnd_m = 1e-6;

class CostmapSpace final : public BandSpace {
 public:
  explicit CostmapSpace(const LocalCostmap& costmap) : costmap_(&costmap) {}
  double FreeDistance_m(const geometry::Rigid2& map_from_base,
                        double max_distance_m) const override {
    return costmap_->FootprintDistance_m(map_from_base, max_distance_m);
  }
  geometry::Vec2 Away(geometry::Vec2 point_in_map) const override {
    return costmap_->Away(point_in_map);
  }

 private:
  const LocalCostmap* costmap_;
};

}  // namespace

BandFollowerOptions BandFollowerOptions::For(const core::RobotModel& robot,
                                             double inflation_m) {
  BandFollowerOptions options;
  options.band.influence_m = std::max(kCell_m, inflation_m);
  options.inset_m = robot.half_width_m + kPointMargin_m;
  options.aside_m = 4 * robot.half_width_m;
  options.search.clearance_m = robot.half_width_m + kManoeuvreRoom_m;
  options.search.desired_m = robot.half_width_m + inflation_m;
  return options;
}

void BandFollower::SetPath(const std::vector<core::LevelPose>& path) {
  progress_.SetPath(path);
  band_.Clear();
  end_along_m_ = 0;
  rest_ = 0;
}

std::vector<BandFollower::Stop> BandFollower::StopsAhead(
    const LocalCostmap& costmap) const {
  std::vector<Stop> stops;
  const double from_m = progress_.along_m();
  const double length_m = progress_.length_m();
  for (double ahead_m = kTwoCells_m; ahead_m < options_.horizon_m + kTwoCells_m;
       ahead_m += kTwoCells_m) {
    const bool is_end = from_m + ahead_m >= length_m - kEnd_m;
    const double along_m = is_end ? length_m : from_m + ahead_m;
    const core::LevelPose pose =
        is_end ? progress_.goal() : progress_.At(along_m);
    const geometry::Rigid2& at = pose.map_from_base;
    if (!costmap.Contains(at.translation, options_.inset_m)) break;
    stops.push_back(
        {.along_m = along_m,
         .map_from_base = at,
         .is_free = costmap.FootprintDistance_m(at, options_.room_m * 2) >
                    options_.room_m});
    if (is_end) break;
  }
  return stops;
}

void BandFollower::Renew(const core::LevelPose& pose,
                         const std::vector<Stop>& stops) {
  std::vector<geometry::Rigid2> line = {pose.map_from_base};
  end_along_m_ = progress_.along_m();
  for (size_t i = 0; i < stops.size(); ++i) {
    const bool is_last = i + 1 == stops.size();
    if (!is_last && stops[i].along_m - end_along_m_ < options_.spacing_m) {
      continue;
    }
    line.push_back(stops[i].map_from_base);
    end_along_m_ = stops[i].along_m;
  }
  band_.Set(line);
}

void BandFollower::CarryOn(const std::vector<Stop>& stops) {
  for (size_t i = 0; i < stops.size(); ++i) {
    const bool is_goal = stops[i].along_m >= progress_.length_m() - kEnd_m;
    if (stops[i].along_m < end_along_m_ + kEnd_m) continue;
    if (!is_goal && stops[i].along_m - end_along_m_ < options_.spacing_m) {
      continue;
    }
    if (!stops[i].is_free) continue;
    band_.Append(stops[i].map_from_base);
    end_along_m_ = stops[i].along_m;
  }
}

bool BandFollower::Mend(const core::LevelPose& pose,
                        const std::vector<Stop>& stops,
                        const LocalCostmap& costmap) {
  if (rest_ > 0) {
    --rest_;
    return false;
  }
  std::vector<geometry::Vec2> ends;
  std::vector<double> costs;
  std::vector<size_t> which;
  for (size_t i = 0; i < stops.size(); ++i) {
    // Back to the path beyond what stands on it: what is free before that leads
    // nowhere.
    const bool leads_on = std::ranges::all_of(
        stops.begin() + static_cast<std::ptrdiff_t>(i), stops.end(),
        [](const Stop& stop) { return stop.is_free; });
    if (!leads_on) continue;
    ends.push_back(stops[i].map_from_base.translation);
    costs.push_back(options_.skip_cost *
                    (stops.back().along_m - stops[i].along_m));
    which.push_back(i);
  }
  // Something stands where the path leaves the window: past it on a side.
  const bool ends_at_goal =
      !stops.empty() && stops.back().along_m >= progress_.length_m() - kEnd_m;
  if (ends.empty() && !stops.empty() && !ends_at_goal) {
    for (double aside_m = -options_.aside_m; aside_m <= options_.aside_m;
         aside_m += kTwoCells_m) {
      const geometry::Vec2 end =
          stops.back().map_from_base * geometry::Vec2{0, aside_m};
      if (!costmap.Contains(end, options_.search.inset_m) ||
          costmap.Distance_m(end) < options_.search.clearance_m) {
        continue;
      }
      ends.push_back(end);
      costs.push_back(std::abs(aside_m));
      which.push_back(stops.size());
    }
  }
  LocalWay way;
  if (!ends.empty()) {
    way = FindLocalWay(costmap, pose.map_from_base.translation, ends, costs,
                       options_.search);
  }
  if (way.points_in_map.size() < 2) {
    rest_ = kRestSteps;
    return false;
  }
  std::vector<geometry::Rigid2> line = {pose.map_from_base};
  for (const geometry::Vec2& point : way.points_in_map) {
    if (geometry::Norm(point - line.back().translation) < kTwoCells_m) {
      continue;
    }
    line.push_back({.translation = point, .yaw_rad = 0});
  }
  for (size_t i = which[way.end]; i < stops.size(); ++i) {
    if (i > which[way.end] && i + 1 < stops.size() &&
        geometry::Norm(stops[i].map_from_base.translation -
                       line.back().translation) < options_.spacing_m) {
      continue;
    }
    line.push_back(stops[i].map_from_base);
  }
  end_along_m_ = stops.back().along_m;
  band_.Set(line);
  ++mended_;
  return true;
}

BandTrack BandFollower::TrackOf(size_t whole_bubbles,
                                const LocalCostmap& costmap) const {
  BandTrack track;
  const std::vector<BandBubble>& bubbles = band_.bubbles();
  for (size_t i = 0; i < whole_bubbles; ++i) {
    const geometry::Vec2 to = bubbles[i].map_from_base.translation;
    const geometry::Vec2 from =
        i == 0 ? to : bubbles[i - 1].map_from_base.translation;
    const int pieces = std::max(
        1, static_cast<int>(std::lround(geometry::Norm(to - from) / kCell_m)));
    for (int piece = i == 0 ? pieces : 1; piece <= pieces; ++piece) {
      const double part = static_cast<double>(piece) / pieces;
      TrackPoint point = {.in_map = from + part * (to - from)};
      point.clearance_m = i == 0 ? bubbles[0].radius_m
                                 : (1 - part) * bubbles[i - 1].radius_m +
                                       part * bubbles[i].radius_m;
      const std::optional<core::LevelPlace> ground =
          costmap.GroundAt(point.in_map);
      if (ground.has_value()) {
        point.slope_rad = map_->SlopeAt_rad(ground->level, point.in_map);
      }
      point.max_mps = costmap.MaxSpeed_mps(point.in_map);
      track.points.push_back(point);
    }
  }
  // As slow as a zone two cells before its edge: a base brakes a little late.
  for (size_t i = 0; i + 1 < track.points.size(); ++i) {
    const size_t ahead = std::min(i + 2, track.points.size() - 1);
    track.points[i].max_mps =
        std::min({track.points[i].max_mps, track.points[i + 1].max_mps,
                  track.points[ahead].max_mps});
  }
  return track;
}

BandTrack BandFollower::Update(const core::LevelPose& pose,
                               const LocalCostmap& costmap) {
  progress_.Follow(pose);
  const CostmapSpace space(costmap);
  const std::vector<Stop> stops = StopsAhead(costmap);
  const double off_m = band_.BeginAt(pose.map_from_base);
  if (band_.bubbles().size() < 2 || off_m > options_.lost_band_m) {
    Renew(pose, stops);
  }
  CarryOn(stops);
  band_.Relax(space);
  std::optional<size_t> broken = band_.FirstBreak(space);
  if (broken.has_value()) {
    const ElasticBand before = band_;
    if (Mend(pose, stops, costmap)) {
      band_.Relax(space);
      const std::optional<size_t> again = band_.FirstBreak(space);
      // What is no better than before is not kept.
      if (again.has_value()) {
        rest_ = kRestSteps;
        if (*again <= *broken) {
          band_ = before;
        } else {
          broken = again;
        }
      } else {
        broken = std::nullopt;
      }
    }
  }
  const size_t whole = broken.value_or(band_.bubbles().size());
  BandTrack track = TrackOf(whole, costmap);
  if (broken.has_value()) {
    track.broken_at = band_.bubbles()[*broken].map_from_base.translation;
  } else if (!stops.empty() && !stops.back().is_free &&
             end_along_m_ < stops.back().along_m - kEnd_m) {
    // The band ends before something that stands on the path's last sight.
    for (const Stop& stop : stops) {
      if (!stop.is_free && stop.along_m > end_along_m_) {
        track.broken_at = stop.map_from_base.translation;
        break;
      }
    }
  }
  track.ends_at_goal =
      !broken.has_value() && end_along_m_ >= progress_.length_m() - kEnd_m;
  return track;
}

}  // namespace treeline::control
