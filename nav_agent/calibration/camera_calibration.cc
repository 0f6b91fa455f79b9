#include "nav_agent/calibration/camera_calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/sample_statistics.h"
#include "nav_agent/calibration/parameters.h"
#include "nav_agent/calibration/robust_fit.h"
#include "nav_agent/calibration/wheel_path.h"

namespace treeline::calibration {
namespace {

using Numbers = std::array<double, kCameraQuantities>;
// The unknowns of the motions: all but z.
constexpr std::array<CameraQuantity, 6> kOfMotions = {
    CameraQuantity::kX,    CameraQuantity::kY,    CameraQuantity::kYaw,
    CameraQuantity::kDown, CameraQuantity::kRoll, CameraQuantity::kDelay};
constexpr size_t kFewestHeights = 10;
constexpr double kBin_m = 0.02;
constexpr double kLowest_m = 3;
constexpr double kHighest_m = 0.1;
constexpr double kFloorShare = 0.1;
constexpr int kPixelStep = 8;

struct CameraMotion {
  double begin_s = 0;
  double end_s = 0;
  geometry::Rigid3 begin_from_end;
};

geometry::Rigid3 ToRigid3(const geometry::Rigid2& pose) {
  return {geometry::Rotation3::FromAxisAngle({0, 0, pose.yaw_rad}),
          {pose.translation.x, pose.translation.y, 0}};
}

size_t Index(CameraQuantity quantity) { return static_cast<size_t>(quantity); }

geometry::Rigid3 PoseOf(const Numbers& v) {
  const geometry::Rotation3 looks =
      geometry::Rotation3::FromAxisAngle(
          {0, 0, v[Index(CameraQuantity::kYaw)]}) *
      core::RobotModel::UprightCamera({}, v[Index(CameraQuantity::kDown)])
          .rotation;
  return {looks * geometry::Rotation3::FromAxisAngle(
                      {0, 0, v[Index(CameraQuantity::kRoll)]}),
          {v[Index(CameraQuantity::kX)], v[Index(CameraQuantity::kY)],
           v[Index(CameraQuantity::kZ)]}};
}

Numbers NumbersOf(const geometry::Rigid3& base_from_camera) {
  const geometry::Vec3 ahead =
      base_from_camera.rotation * geometry::Vec3{0, 0, 1};
  Numbers v{};
  v[Index(CameraQuantity::kX)] = base_from_camera.translation.x;
  v[Index(CameraQuantity::kY)] = base_from_camera.translation.y;
  v[Index(CameraQuantity::kZ)] = base_from_camera.translation.z;
  v[Index(CameraQuantity::kYaw)] = std::atan2(ahead.y, ahead.x);
  v[Index(CameraQuantity::kDown)] = -std::asin(std::clamp(ahead.z, -1.0, 1.0));
  // What is left turns the camera's own x axis.
  const geometry::Vec3 x =
      PoseOf(v).rotation.Inverse() *
      (base_from_camera.rotation * geometry::Vec3{1, 0, 0});
  v[Index(CameraQuantity::kRoll)] = std::atan2(x.y, x.x);
  return v;
}

bool IsStill(const geometry::Rigid2& motion) {
  return geometry::Norm(motion.translation) < kStillWay_m &&
         std::abs(motion.yaw_rad) < kStillTurn_rad;
}

std::vector<CameraMotion> MotionsOf(std::span<const CameraView> views,
                                    const WheelPath& path, const Drive& drive,
                                    const Wheels& wheels) {
  std::vector<CameraMotion> motions;
  size_t begin = 0;
  for (size_t i = 1; i < views.size(); ++i) {
    const CameraView& from = views[begin];
    const CameraView& to = views[i];
    const auto motion = path.Motion(from.time_s, to.time_s, wheels);
    if (to.time_s - views[i - 1].time_s > drive.longest_gap_s || !motion ||
        to.time_s - from.time_s > kLongestWindow_s || IsStill(*motion)) {
      begin = i;
      continue;
    }
    if (geometry::Norm(motion->translation) < kWindowWay_m &&
        std::abs(motion->yaw_rad) < kWindowTurn_rad) {
      continue;
    }
    motions.push_back({from.time_s, to.time_s,
                       from.map_from_camera.Inverse() * to.map_from_camera});
    begin = i;
  }
  return motions;
}

// Translation (m) and rotation (rad) of the camera by wheels beside by
// pictures.
bool Differ(const WheelPath& path, const Wheels& wheels, const Numbers& v,
            const CameraMotion& motion, std::span<double> difference) {
  const double delay_s = v[Index(CameraQuantity::kDelay)];
  const auto base =
      path.Motion(motion.begin_s - delay_s, motion.end_s - delay_s, wheels);
  if (!base) return false;
  const geometry::Rigid3 base_from_camera = PoseOf(v);
  const geometry::Rigid3 by_wheels =
      base_from_camera.Inverse() * ToRigid3(*base) * base_from_camera;
  const geometry::Vec3 off =
      by_wheels.translation - motion.begin_from_end.translation;
  const geometry::Vec3 turned = geometry::ToAxisAngle(
      motion.begin_from_end.rotation.Inverse() * by_wheels.rotation);
  const double all[6] = {off.x, off.y, off.z, turned.x, turned.y, turned.z};
  std::copy(all, all + 6, difference.begin());
  return true;
}

Residuals ResidualsOf(const WheelPath& path, const Wheels& wheels,
                      const Numbers& v, std::span<const CameraMotion> motions,
                      std::span<const double> norms) {
  std::vector<double> m;
  std::vector<double> rad;
  for (size_t i = 0; i < motions.size(); ++i) {
    double d[6];
    if (norms[i] < 0 || norms[i] > kOutlierSigmas ||
        !Differ(path, wheels, v, motions[i], d)) {
      continue;
    }
    m.push_back(std::hypot(d[0], d[1], d[2]));
    rad.push_back(std::hypot(d[3], d[4], d[5]));
  }
  const base::ErrorSummary in_m = base::Summarize(m);
  const base::ErrorSummary in_rad = base::Summarize(rad);
  return {in_m.median, in_rad.median, in_m.rmse, in_rad.rmse};
}

FitProblem MotionProblem(std::span<const CameraMotion> motions,
                         const Numbers& assumed) {
  FitProblem problem;
  problem.rows = motions.size();
  problem.size = 6;
  problem.first_angle = 3;
  std::vector<double> covariance(36, 0.0);
  for (size_t i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? kMatchNoise_m : kMatchNoise_rad;
    covariance[7 * i] = sigma * sigma;
  }
  problem.covariances.assign(motions.size(), covariance);
  for (const CameraQuantity quantity : kOfMotions) {
    problem.prior.push_back(assumed[Index(quantity)]);
  }
  problem.prior_sigma = {kPriorMount_m, kPriorMount_m, kPriorYaw_rad,
                         kPriorYaw_rad, kPriorYaw_rad, kPriorDelay_s};
  problem.step = {1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 4e-3};
  problem.free = kOfMotions.size();
  problem.is_sane = [](std::span<const double> at) {
    // Not straight up or down, where yaw and roll are the same.
    return std::abs(at[3]) < 1.5 && std::abs(at[5]) < 2;
  };
  problem.bias = {kCameraBias_m,  kCameraBias_m,  kCameraBias_m,
                  kMatchBias_rad, kMatchBias_rad, kMatchBias_rad};
  return problem;
}

double KnownSigma(CameraQuantity quantity) {
  switch (quantity) {
    case CameraQuantity::kX:
    case CameraQuantity::kY:
    case CameraQuantity::kZ:
      return kKnownMount_m;
    case CameraQuantity::kYaw:
    case CameraQuantity::kDown:
    case CameraQuantity::kRoll:
      return kKnownYaw_rad;
    case CameraQuantity::kDelay:
      return kKnownDelay_s;
  }
  return 0;
}

void TakeHeight(std::span<const double> heights_m,
                CameraCalibration& calibration) {
  Estimate& z = calibration.estimates[Index(CameraQuantity::kZ)];
  z = {calibration.assumed[Index(CameraQuantity::kZ)], kPriorMount_m, false};
  if (heights_m.size() < kFewestHeights) return;
  const double median_m =
      base::Quantile({heights_m.begin(), heights_m.end()}, 0.5);
  std::vector<double> off_m;
  for (const double height_m : heights_m) {
    off_m.push_back(std::abs(height_m - median_m));
  }
  // All pictures err alike by what depth errs.
  const double sigma_m =
      std::hypot(1.4826 * base::Quantile(off_m, 0.5), kDepthShare * median_m);
  z = {median_m, sigma_m, sigma_m < KnownSigma(CameraQuantity::kZ)};
  if (!z.is_known) z.value = calibration.assumed[Index(CameraQuantity::kZ)];
}

}  // namespace

const char* NameOf(CameraQuantity quantity) {
  constexpr const char* kNames[] = {"camera x",    "camera y",    "camera z",
                                    "camera yaw",  "camera down", "camera roll",
                                    "camera delay"};
  return kNames[Index(quantity)];
}

const char* DriveFor(CameraQuantity quantity) {
  switch (quantity) {
    case CameraQuantity::kZ:
      return "see the floor: free ground in front of the camera";
    case CameraQuantity::kYaw:
      return "drive straight ahead for 20 m";
    default:
      return "turn on the spot, a few whole turns each way, some of them quick";
  }
}

geometry::Rigid3 CameraCalibration::BaseFromCamera() const {
  Numbers v{};
  for (size_t i = 0; i < v.size(); ++i) v[i] = estimates[i].value;
  return PoseOf(v);
}

absl::StatusOr<CameraCalibration> CalibrateCamera(
    const Drive& drive, const Setup& found, std::span<const CameraView> views,
    std::span<const double> heights_m, const geometry::Rigid3& assumed) {
  const WheelPath path(drive.readings, drive.longest_gap_s);
  const std::vector<CameraMotion> motions =
      MotionsOf(views, path, drive, found.wheels);
  if (motions.size() < static_cast<size_t>(kMinMotions)) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the camera knew where it was in ", views.size(), " pictures, in ",
        motions.size(), " stretches of half a metre or 20 degrees; ",
        kMinMotions.value,
        " are needed: drive slower, where there is something to see"));
  }
  CameraCalibration calibration;
  calibration.assumed = NumbersOf(assumed);
  FitProblem problem = MotionProblem(motions, calibration.assumed);
  const auto numbers = [&](std::span<const double> at) {
    Numbers v = calibration.assumed;
    for (size_t i = 0; i < kOfMotions.size(); ++i) {
      v[Index(kOfMotions[i])] = at[i];
    }
    return v;
  };
  problem.difference = [&](size_t row, std::span<const double> at,
                           std::span<double> difference) {
    return Differ(path, found.wheels, numbers(at), motions[row], difference);
  };
  const FitSolution solution = SolveRobustly(problem);
  for (size_t i = 0; i < kOfMotions.size(); ++i) {
    const CameraQuantity quantity = kOfMotions[i];
    Estimate& estimate = calibration.estimates[Index(quantity)];
    estimate.sigma = std::sqrt(solution.covariance[i * kOfMotions.size() + i]);
    estimate.is_known = estimate.sigma < KnownSigma(quantity);
    estimate.value = estimate.is_known ? solution.at[i]
                                       : calibration.assumed[Index(quantity)];
  }
  TakeHeight(heights_m, calibration);
  calibration.stretches = static_cast<int>(motions.size());
  calibration.outliers = static_cast<int>(
      std::count_if(solution.norms.begin(), solution.norms.end(),
                    [](double norm) { return norm > kOutlierSigmas; }));
  calibration.before = ResidualsOf(path, found.wheels, calibration.assumed,
                                   motions, solution.norms);
  Numbers after{};
  for (size_t i = 0; i < after.size(); ++i) {
    after[i] = calibration.estimates[i].value;
  }
  calibration.after =
      ResidualsOf(path, found.wheels, after, motions, solution.norms);
  return calibration;
}

std::optional<double> FloorBelow_m(
    const image::DepthImage& depth, const camera::RgbdCalibration& calibration,
    const geometry::Rotation3& base_from_camera) {
  const geometry::Rigid3 sensor_from_depth =
      calibration.pose_sensor == camera::RgbdSensor::kColor
          ? calibration.color_from_depth
          : geometry::Rigid3();
  std::vector<double> below_m;
  for (int v = 0; v < depth.height; v += kPixelStep) {
    for (int u = 0; u < depth.width; u += kPixelStep) {
      const uint16_t value = depth.values[static_cast<size_t>(v) *
                                              static_cast<size_t>(depth.width) +
                                          static_cast<size_t>(u)];
      if (!image::IsMeasured(value)) continue;
      const auto ray = calibration.depth.Unproject(
          {static_cast<double>(u), static_cast<double>(v)});
      if (!ray) continue;
      const double depth_m = calibration.depth_scale * depth.unit_m * value;
      const geometry::Vec3 point =
          sensor_from_depth *
          geometry::Vec3{depth_m * ray->x, depth_m * ray->y, depth_m};
      below_m.push_back(-(base_from_camera * point).z);
    }
  }
  std::vector<int> bins(static_cast<size_t>(kLowest_m / kBin_m) + 1, 0);
  for (const double m : below_m) {
    if (m > kHighest_m && m < kLowest_m) {
      ++bins[static_cast<size_t>(m / kBin_m)];
    }
  }
  const auto most = std::max_element(bins.begin(), bins.end());
  if (below_m.empty() ||
      *most < kFloorShare * static_cast<double>(below_m.size())) {
    return std::nullopt;
  }
  const double about_m =
      (static_cast<double>(most - bins.begin()) + 0.5) * kBin_m;
  std::erase_if(below_m, [about_m](double m) {
    return std::abs(m - about_m) > 1.5 * kBin_m;
  });
  return base::Quantile(std::move(below_m), 0.5);
}

}  // namespace treeline::calibration
