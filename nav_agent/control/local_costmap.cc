#include "nav_agent/control/local_costmap.h"

#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/control/depth_columns.h"
#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {

namespace {

// Of the ground that the robot stands on, along the map's axes (m/m).
geometry::Vec2 RiseUnder(const ControlPose& pose) {
  const geometry::Vec3 up =
      MapFromBase3(pose).rotation * geometry::Vec3{0, 0, 1};
  return {-up.x / up.z, -up.y / up.z};
}

}  // namespace

absl::Status LocalCostmapOptions::Validate() const {
  if (!(length_m >= 1 && length_m <= 20 && width_m >= 1 && width_m <= 20)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the costmap must measure 1 to 20 m along each axis, not ",
                     length_m, " x ", width_m));
  }
  if (!(resolution_m >= 0.01 && resolution_m <= 0.2)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the costmap's resolution_m must be in [0.01, 0.2], not ",
                     resolution_m));
  }
  return absl::OkStatus();
}

absl::StatusOr<LocalCostmap> LocalCostmap::Make(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const core::RobotLasers& lasers,
    const LocalCostmapOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  if (map == nullptr) return absl::InvalidArgumentError("there is no map");
  for (const core::RangeSensorInfo& laser :
       {lasers.front, lasers.rear.value_or(lasers.front)}) {
    if (laser.beams < 1 || !(laser.range_max_m > laser.range_min_m)) {
      return absl::InvalidArgumentError(
          "a laser's beams and ranges are not known: it has not said them yet");
    }
  }
  return LocalCostmap(std::move(map), robot, lasers, options);
}

LocalCostmap::LocalCostmap(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const core::RobotLasers& lasers,
    const LocalCostmapOptions& options)
    : far_m_(options.length_m + options.width_m),
      map_resolution_m_(map->resolution_m()),
      robot_(robot),
      window_(options.length_m, options.width_m, options.resolution_m),
      gone_(map, robot),
      ground_(std::move(map), window_.cells()),
      zones_(window_.cells(), Footprint::Of(robot)),
      obstacles_(window_.cells(), lasers.rear.has_value()),
      front_(lasers.front, robot.BaseFrom(core::LaserMount::kFront),
             robot.height_m, far_m_),
      depth_(robot.base_from_camera, robot.height_m),
      cells_(window_.cells(), LocalCell::kMapObstacle),
      distances_(window_, Footprint::Of(robot)) {
  if (lasers.rear.has_value()) {
    rear_.emplace(*lasers.rear, robot.BaseFrom(core::LaserMount::kRear),
                  robot.height_m, far_m_);
  }
}

const LaserObserver* LocalCostmap::SightOf(core::LaserMount mount) const {
  if (mount == core::LaserMount::kFront) return &front_;
  return rear_.has_value() ? &*rear_ : nullptr;
}

int64_t LocalCostmap::SinceEpoch_ms(base::MonotonicTime time) const {
  if (!epoch_.has_value()) return 0;
  return std::chrono::duration_cast<std::chrono::milliseconds>(time - *epoch_)
      .count();
}

int64_t LocalCostmap::BeginEpoch_ms(base::MonotonicTime time) {
  if (!epoch_.has_value()) epoch_ = time;
  return SinceEpoch_ms(time);
}

void LocalCostmap::MoveTo(const ControlPose& control_pose) {
  const core::LevelPose& pose = control_pose.pose;
  if (control_pose.map_is_unknown != ground_.map_is_unknown()) {
    placed_at_.reset();
  }
  const geometry::Vec2 rise =
      control_pose.map_is_unknown ? RiseUnder(control_pose) : geometry::Vec2();
  const CostmapWindow window =
      window_.CenteredAt(pose.map_from_base.translation);
  gone_.MoveTo(control_pose);
  const bool opens = ground_.SetFreed(gone_.freed());
  if (placed_at_.has_value()) {
    const bool rolls = !window.IsSamePlaceAs(window_);
    const bool climbs =
        pose.place.level != placed_at_->place.level ||
        std::abs(pose.place.height_m - placed_at_->place.height_m) >
            kClimbVoxels * map_resolution_m_;
    const bool tilts = geometry::Norm(rise - placed_rise_) > kNewRise;
    if (!rolls && !climbs && !tilts && !opens) {
      zones_.LetOut(window_, ground_, pose);
      return;
    }
    if (rolls) obstacles_.Roll(window_, window);
  } else {
    obstacles_.Clear();
  }
  window_ = window;
  placed_at_ = pose;
  placed_rise_ = rise;
  if (control_pose.map_is_unknown) {
    ground_.SpreadLevel(window_, pose, rise);
  } else {
    ground_.Spread(window_, pose);
  }
  zones_.Spread(window_, ground_);
  zones_.LetOut(window_, ground_, pose);
}

void LocalCostmap::SetZones(std::shared_ptr<const zones::ZoneMap> zones) {
  zones_.SetZones(std::move(zones));
  if (!placed_at_.has_value()) return;
  zones_.Spread(window_, ground_);
  zones_.LetOut(window_, ground_, *placed_at_);
}

absl::Status LocalCostmap::AddScan(const ControlPose& pose,
                                   const core::LaserScan& scan,
                                   core::LaserMount mount) {
  if (mount == core::LaserMount::kRear && !rear_.has_value()) {
    return absl::InvalidArgumentError("there is no laser that looks back");
  }
  LaserObserver& sight = mount == core::LaserMount::kRear ? *rear_ : front_;
  TL_RETURN_IF_ERROR(sight.Check(scan));
  if (!geometry::IsFinite(MapFromBase3(pose))) {
    return absl::InvalidArgumentError("the pose of a scan is not finite");
  }
  if (!placed_at_.has_value()) MoveTo(pose);
  // 0 is before everything.
  const int64_t now_ms = BeginEpoch_ms(scan.stamp) + 1;
  sight.Add(pose, scan, window_, ground_, now_ms, obstacles_);
  return absl::OkStatus();
}

absl::Status LocalCostmap::AddDepth(const ControlPose& pose,
                                    const core::RgbdFrame& frame) {
  TL_RETURN_IF_ERROR(DepthObserver::Check(frame));
  if (!geometry::IsFinite(MapFromBase3(pose))) {
    return absl::InvalidArgumentError("the pose of a frame is not finite");
  }
  if (!placed_at_.has_value()) MoveTo(pose);
  const int64_t now_ms = BeginEpoch_ms(frame.stamp) + 1;
  depth_.Add(pose, frame, window_, ground_, now_ms, obstacles_);
  for (const size_t i : obstacles_.hits()) {
    const int cell = static_cast<int>(i);
    const geometry::Vec2 center =
        window_.CenterInMap(cell % window_.width(), cell / window_.width());
    if (front_.ShowsMoverNear(center) ||
        (rear_.has_value() && rear_->ShowsMoverNear(center))) {
      obstacles_.MarkAsOfMover(i);
    }
  }
  const DepthColumns columns(pose, frame, robot_);
  gone_.Look(
      pose,
      [this, &frame](const ThingColumn& column) {
        return LookByLasers(column, frame.stamp);
      },
      [&columns](const ThingColumn& column, double beyond_m) {
        return columns.Look(column, beyond_m);
      },
      now_ms);
  return absl::OkStatus();
}

LaserSight LocalCostmap::LookByLasers(const ThingColumn& column,
                                      base::MonotonicTime stamp) const {
  LaserSight sight;
  for (const LaserObserver* laser : {&front_, rear_ ? &*rear_ : nullptr}) {
    if (laser == nullptr || !laser->last_scan().has_value() ||
        std::abs(base::SecondsBetween(*laser->last_scan(), stamp)) >
            kLately_s) {
      continue;
    }
    const LaserSight look = laser->Look(column);
    if (look.sight == ColumnSight::kMet) return look;
    if (look.sight == ColumnSight::kThrough) sight = look;
  }
  return sight;
}

void LocalCostmap::ClearObstacles() {
  obstacles_.Clear();
  front_.ForgetPoints();
  if (rear_.has_value()) rear_->ForgetPoints();
  depth_.ForgetPoints();
  if (placed_at_.has_value() && epoch_.has_value()) Update(*epoch_);
}

void LocalCostmap::Update(base::MonotonicTime now) {
  obstacles_.Forget(BeginEpoch_ms(now));
  gone_.Forget(SinceEpoch_ms(now));
  std::vector<uint8_t> is_obstacle(cells_.size());
  for (size_t i = 0; i < cells_.size(); ++i) {
    cells_[i] = !ground_.IsGround(i) || zones_.IsClosed(i)
                    ? LocalCell::kMapObstacle
                : obstacles_.Counts(i) ? LocalCell::kSeen
                                       : LocalCell::kFree;
    is_obstacle[i] = cells_[i] == LocalCell::kFree ? 0 : 1;
  }
  obstacles_.Widen(window_, ground_, is_obstacle);
  distances_.Measure(window_, is_obstacle, far_m_);
}

LocalCell LocalCostmap::CellAt(geometry::Vec2 point_in_map) const {
  const core::CellIndex cell = window_.CellOf(point_in_map);
  return window_.IsInside(cell) ? cells_[window_.IndexOf(cell.x, cell.y)]
                                : LocalCell::kMapObstacle;
}

std::optional<core::LevelPlace> LocalCostmap::GroundAt(
    geometry::Vec2 point_in_map) const {
  const core::CellIndex cell = window_.CellOf(point_in_map);
  if (!window_.IsInside(cell)) return std::nullopt;
  return ground_.PlaceAt(window_.IndexOf(cell.x, cell.y));
}

double LocalCostmap::MaxSpeed_mps(geometry::Vec2 point_in_map) const {
  const std::optional<core::LevelPlace> ground =
      ground_.map_is_unknown() ? std::nullopt : GroundAt(point_in_map);
  return ground.has_value() ? zones_.MaxSpeed_mps(ground->level, point_in_map)
                            : std::numeric_limits<double>::infinity();
}

std::vector<geometry::Vec2> LocalCostmap::MapObstacles(
    const core::LevelPose& pose, double radius_m) const {
  std::vector<geometry::Vec2> obstacles = ground_.MapObstacles(pose, radius_m);
  const std::vector<geometry::Vec2> edges = zones_.Edges(pose, radius_m);
  obstacles.insert(obstacles.end(), edges.begin(), edges.end());
  return obstacles;
}

std::vector<RememberedObstacle> LocalCostmap::UnseenObstacles(
    geometry::Vec2 at, double radius_m, base::MonotonicTime now) const {
  if (!epoch_.has_value()) return {};
  return UnseenObstaclesNear(window_, ground_, obstacles_, at, radius_m,
                             SinceEpoch_ms(now));
}

ObservedObstacle LocalCostmap::ObstacleNear(geometry::Vec2 point_in_map,
                                            double reach_m,
                                            base::MonotonicTime now) const {
  if (!epoch_.has_value()) return {};
  return ObservedObstacleNear(window_, ground_, obstacles_, point_in_map,
                              reach_m, SinceEpoch_ms(now));
}

std::span<const ObservedPoint> LocalCostmap::scan_points(
    core::LaserMount mount) const {
  const LaserObserver* sight = SightOf(mount);
  return sight == nullptr ? std::span<const ObservedPoint>() : sight->points();
}

std::optional<base::MonotonicTime> LocalCostmap::last_scan(
    core::LaserMount mount) const {
  const LaserObserver* sight = SightOf(mount);
  return sight == nullptr ? std::nullopt : sight->last_scan();
}

}  // namespace treeline::control
