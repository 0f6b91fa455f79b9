#include "server/core/training/rgbd_calibrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "server/core/training/edge_alignment.h"
#include "server/core/training/pose_convention.h"
#include "server/core/training/surface_consistency.h"

namespace treeline::training {
namespace {

// The unknowns, as changes of the nominal calibration. Focal lengths and the
// scale are logarithms of factors; rotation and translation are those of
// color_from_depth.
enum Unknown : size_t {
  kRotationX,
  kRotationY,
  kRotationZ,
  kTranslationX,
  kTranslationY,
  kTranslationZ,
  kScale,
  kDepthFocal,
  kDepthCx,
  kDepthCy,
  kDepthRadial,
  kColorFocal,
  kColorCx,
  kColorCy,
  kUnknowns
};
using Values = std::array<double, kUnknowns>;
using Choice = std::array<bool, kUnknowns>;

// Standard deviations of the prior knowledge about consumer RGB-D
// cameras, in rad, m, 1, 1, px, 1, 1, px: their two lenses look the same way
// from one row. Where few frames are given, this decides; see
// docs/research/universal.md.
constexpr Values kPriorSigma = {0.015, 0.015, 0.015, 0.03, 0.01, 0.01, 0.02,
                                0.01,  5,     5,     0.1,  0.01, 5,    5};
// Steps of numerical differentiation.
constexpr Values kStep = {1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4,
                          1e-4, 0.05, 0.05, 1e-4, 1e-4, 0.05, 0.05};
// First steps of the edge search.
constexpr Values kSearchStep = {0.004, 0.004, 0.004, 0.004, 0.004, 0.004, 0.004,
                                0.004, 2,     2,     0.01,  0.004, 2,     2};

// So many compared points count as one: those of a frame share the error of
// its pose.
constexpr double kPointsPerObservation = 40;
// Depth is rounded, and its noise is not known better than that.
constexpr double kMinVariance = 0.01;
constexpr int kIterations = 12;
// Residuals above this many standard deviations are no match; wider at first.
constexpr double kMaxResidualSigmas = 4;
constexpr double kMaxInitialResidualSigmas = 10;
constexpr double kReportCutoff_m = 0.1;
// The surface fit is kept if it lowers their distance by this share.
constexpr double kMinImprovement = 0.03;
constexpr std::array<double, 2> kSmoothing_px = {3.0, 1.5};

// `camera` with focal lengths scaled and principal point moved. radial != 0
// makes it an OPENCV camera; otherwise the model is kept.
camera::Camera Adjusted(const camera::Camera& camera, double focal_factor,
                        double dx_px, double dy_px, double radial) {
  absl::StatusOr<camera::Camera> adjusted = camera;
  if (radial != 0) {
    const double p[8] = {camera.fx() * focal_factor,
                         camera.fy() * focal_factor,
                         camera.cx() + dx_px,
                         camera.cy() + dy_px,
                         radial,
                         0,
                         0,
                         0};
    adjusted = camera::Camera::Create(camera::CameraModel::kOpenCv,
                                      camera.width(), camera.height(), p, 8);
  } else {
    std::array<double, camera::Camera::kMaxParameters> p = camera.parameters();
    const bool one_focal =
        camera.model() == camera::CameraModel::kSimplePinhole ||
        camera.model() == camera::CameraModel::kSimpleRadial ||
        camera.model() == camera::CameraModel::kRadial;
    const size_t focals = one_focal ? 1 : 2;
    for (size_t i = 0; i < focals; ++i) p[i] *= focal_factor;
    p[focals] += dx_px;
    p[focals + 1] += dy_px;
    adjusted = camera::Camera::Create(
        camera.model(), camera.width(), camera.height(), p.data(),
        camera::CameraParameterCount(camera.model()));
  }
  return adjusted.value_or(camera);
}

camera::RgbdCalibration Apply(const camera::RgbdCalibration& nominal,
                              const Values& x) {
  camera::RgbdCalibration calibration = nominal;
  calibration.color_from_depth =
      geometry::Rigid3{geometry::Rotation3::FromAxisAngle(
                           {x[kRotationX], x[kRotationY], x[kRotationZ]}),
                       {x[kTranslationX], x[kTranslationY], x[kTranslationZ]}} *
      nominal.color_from_depth;
  calibration.depth_scale = nominal.depth_scale * std::exp(x[kScale]);
  calibration.depth = Adjusted(nominal.depth, std::exp(x[kDepthFocal]),
                               x[kDepthCx], x[kDepthCy], x[kDepthRadial]);
  calibration.color = Adjusted(nominal.color, std::exp(x[kColorFocal]),
                               x[kColorCx], x[kColorCy], 0);
  return calibration;
}

// Of every stride-th of the residuals, in units of the depth noise; 0 stands
// for none. Poses have errors, too: where surfaces lie further apart than noise
// explains, they tell less.
double RobustVariance(const std::vector<double>& residuals, size_t stride) {
  std::vector<double> sizes;
  for (size_t r = 0; r < residuals.size(); r += stride) {
    if (residuals[r] != 0) sizes.push_back(std::abs(residuals[r]));
  }
  if (sizes.empty()) return 1;
  const auto middle =
      sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  // 1.4826: a normal distribution's standard deviation by its median deviation.
  const double sigma = 1.4826 * *middle;
  return std::max(sigma * sigma, kMinVariance);
}

// Gauss-Newton with Tukey's loss on the surface residuals and the priors.
class SurfaceFit {
 public:
  SurfaceFit(SurfaceConsistency& surfaces,
             const camera::RgbdCalibration& nominal, const Choice& unknowns,
             int threads)
      : surfaces_(surfaces), nominal_(nominal), threads_(threads) {
    for (size_t u = 0; u < kUnknowns; ++u) {
      if (unknowns[u]) unknowns_.push_back(u);
    }
  }

  absl::Status Run(Values& x, base::Progress& progress,
                   const std::stop_token& stop) {
    for (int i = 0; i < kIterations; ++i) {
      if (stop.stop_requested()) {
        return absl::CancelledError("calibration was interrupted");
      }
      Step(x, i < kIterations / 3 ? kMaxInitialResidualSigmas
                                  : kMaxResidualSigmas);
      progress.Add(1);
    }
    return absl::OkStatus();
  }

 private:
  void Step(Values& x, double cutoff) {
    const size_t n = unknowns_.size();
    // Of x, and for columns of the Jacobian by central differences two more
    // each.
    std::vector<camera::RgbdCalibration> calibrations = {Apply(nominal_, x)};
    for (size_t i = 0; i < 2 * n; ++i) {
      Values y = x;
      y[unknowns_[i / 2]] += (i % 2 == 0 ? 1 : -1) * kStep[unknowns_[i / 2]];
      calibrations.push_back(Apply(nominal_, y));
    }
    surfaces_.Associate(calibrations.front(), threads_);
    std::vector<double> residuals;
    surfaces_.Residuals(calibrations, threads_, residuals);
    const size_t stride = calibrations.size();
    const double variance = RobustVariance(residuals, stride);
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n),
                                              static_cast<Eigen::Index>(n));
    Eigen::VectorXd g = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
    Eigen::VectorXd row(static_cast<Eigen::Index>(n));
    for (size_t r = 0; r < residuals.size(); r += stride) {
      const double residual = residuals[r];
      if (residual == 0 || std::abs(residual) > cutoff) continue;
      for (size_t c = 0; c < n; ++c) {
        row[static_cast<Eigen::Index>(c)] =
            (residuals[r + 1 + 2 * c] - residuals[r + 2 + 2 * c]) /
            (2 * kStep[unknowns_[c]]);
      }
      // Where a distorted image folds, rays have no derivative.
      if (!row.allFinite()) continue;
      const double t = residual / cutoff;
      const double weight =
          (1 - t * t) * (1 - t * t) / (kPointsPerObservation * variance);
      h.noalias() += weight * row * row.transpose();
      g.noalias() += weight * residual * row;
    }
    for (size_t c = 0; c < n; ++c) {
      const Eigen::Index i = static_cast<Eigen::Index>(c);
      const double prior =
          1 / (kPriorSigma[unknowns_[c]] * kPriorSigma[unknowns_[c]]);
      h(i, i) += prior;
      g[i] += prior * x[unknowns_[c]];
    }
    const Eigen::VectorXd step = h.ldlt().solve(-g);
    for (size_t c = 0; c < n; ++c) {
      x[unknowns_[c]] += step[static_cast<Eigen::Index>(c)];
    }
  }

  SurfaceConsistency& surfaces_;
  const camera::RgbdCalibration& nominal_;
  const int threads_;
  std::vector<size_t> unknowns_;
};

// Climbs the edge strength along one unknown after the other, halving the
// steps when none helps.
void ClimbEdges(const EdgeAlignment& edges,
                const camera::RgbdCalibration& nominal, const Choice& unknowns,
                double step_scale, Values& x, base::Progress& progress,
                const std::stop_token& stop) {
  constexpr int kSweeps = 12;
  double best = edges.Strength(Apply(nominal, x));
  double scale = step_scale;
  for (int sweep = 0; sweep < kSweeps && !stop.stop_requested(); ++sweep) {
    bool improved = false;
    for (size_t u = 0; u < kUnknowns; ++u) {
      if (!unknowns[u]) continue;
      for (double direction : {-1.0, 1.0}) {
        while (true) {
          Values y = x;
          y[u] += direction * scale * kSearchStep[u];
          // Stay where consumer cameras are.
          if (std::abs(y[u]) > 4 * kPriorSigma[u]) break;
          const double strength = edges.Strength(Apply(nominal, y));
          if (strength <= best) break;
          best = strength;
          x = y;
          improved = true;
        }
      }
    }
    if (!improved) scale /= 2;
    progress.Add(1);
  }
}

Choice Choose(std::initializer_list<Unknown> unknowns) {
  Choice choice{};
  for (Unknown u : unknowns) choice[u] = true;
  return choice;
}

struct LoadedFrames {
  std::vector<image::Frame> frames;
  std::vector<PosedDepth> depths;
};

// Frames with depth and a pose.
std::vector<int> UsableFrames(const dataset::Dataset& dataset) {
  std::vector<int> usable;
  for (int i = 0; i < dataset.size(); ++i) {
    if (dataset.frame(i).world_from_camera &&
        !dataset.frame(i).depth_path.empty()) {
      usable.push_back(i);
    }
  }
  return usable;
}

absl::StatusOr<LoadedFrames> LoadFrames(const dataset::Dataset& dataset,
                                        const CalibratorOptions& options,
                                        bool quiet,
                                        const std::stop_token& stop) {
  const std::vector<int> usable = UsableFrames(dataset);
  if (usable.size() < 2) {
    return absl::FailedPreconditionError(
        absl::StrCat(dataset.uri(),
                     ": calibration needs at least two frames with depth "
                     "and pose, and there are ",
                     usable.size()));
  }
  const size_t count =
      std::min(usable.size(), static_cast<size_t>(options.frames));
  std::vector<absl::StatusOr<image::Frame>> loaded(
      count, absl::UnknownError("not read"));
  const auto index = [&](size_t i) {
    return usable[i * usable.size() / count];
  };
  base::Progress progress("reading frames", static_cast<int64_t>(count), quiet);
  base::ParallelFor(static_cast<int64_t>(count), options.threads,
                    [&](int64_t i) {
                      if (!stop.stop_requested()) {
                        loaded[static_cast<size_t>(i)] =
                            dataset.Load(index(static_cast<size_t>(i)));
                      }
                      progress.Add(1);
                    });
  if (stop.stop_requested()) {
    return absl::CancelledError("calibration was interrupted");
  }
  LoadedFrames result;
  for (size_t i = 0; i < count; ++i) {
    TL_RETURN_IF_ERROR(loaded[i].status());
    result.depths.push_back(
        {*loaded[i]->depth, *dataset.frame(index(i)).world_from_camera});
    result.frames.push_back(*std::move(loaded[i]));
  }
  return result;
}

absl::Status CheckConvention(const dataset::Dataset& dataset,
                             const LoadedFrames& loaded, int threads) {
  const std::optional<OtherConvention> other =
      FindOtherConvention(loaded.depths, dataset.calibration(), threads);
  return other ? ConventionError(dataset.uri(), *other) : absl::OkStatus();
}

absl::Status CheckSizes(const LoadedFrames& loaded,
                        const camera::RgbdCalibration& nominal) {
  for (const image::Frame& frame : loaded.frames) {
    if (frame.color.width != nominal.color.width() ||
        frame.color.height != nominal.color.height() ||
        frame.depth->width != nominal.depth.width() ||
        frame.depth->height != nominal.depth.height()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "a frame has colour ", frame.color.width, " x ", frame.color.height,
          " and depth ", frame.depth->width, " x ", frame.depth->height,
          ", but the cameras are for ", nominal.color.width(), " x ",
          nominal.color.height(), " and ", nominal.depth.width(), " x ",
          nominal.depth.height()));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<CalibrationReport> CalibrateRgbd(
    const dataset::Dataset& dataset, const CalibratorOptions& options,
    bool quiet, const std::stop_token& stop) {
  if (options.frames < 2 || options.frames > 1000) {
    return absl::InvalidArgumentError(absl::StrCat(
        "calibration frames is ", options.frames, "; it must be 2 to 1000"));
  }
  const camera::RgbdCalibration nominal = dataset.calibration();
  TL_ASSIGN_OR_RETURN(const LoadedFrames loaded,
                      LoadFrames(dataset, options, quiet, stop));
  TL_RETURN_IF_ERROR(CheckSizes(loaded, nominal));
  TL_RETURN_IF_ERROR(CheckConvention(dataset, loaded, options.threads));
  CalibrationReport report;
  report.frames = static_cast<int>(loaded.frames.size());

  Choice by_surfaces = Choose({kScale});
  Choice by_edges{};
  if (!dataset.depth_is_registered()) {
    if (nominal.pose_sensor == camera::RgbdSensor::kColor) {
      by_surfaces = Choose({kRotationX, kRotationY, kRotationZ, kTranslationX,
                            kTranslationY, kTranslationZ, kScale, kDepthFocal,
                            kDepthCx, kDepthCy, kDepthRadial});
      // The colour camera is the one that the poses were found with.
      by_edges = Choose({kRotationX, kRotationY, kRotationZ});
    } else {
      // Surfaces say nothing about the colour camera here.
      by_edges = Choose(
          {kTranslationX, kTranslationY, kColorFocal, kColorCx, kColorCy});
    }
    if (nominal.depth.has_distortion()) by_surfaces[kDepthRadial] = false;
  }

  base::Progress progress(
      "calibrating", kIterations + (dataset.depth_is_registered() ? 0 : 24),
      quiet);
  Values x{};
  SurfaceConsistency surfaces(loaded.depths, nominal);
  report.pairs = surfaces.pairs();
  if (report.pairs == 0) {
    return absl::FailedPreconditionError(absl::StrCat(
        dataset.uri(), ": no two of the ", report.frames,
        " frames see the same surfaces from different directions; give more "
        "frames, or a calibration (--calibration nominal: the cameras as the "
        "recording has them)"));
  }
  surfaces.Associate(nominal, options.threads);
  report.surface_rms_before_m = surfaces.Rms_m(kReportCutoff_m);
  TL_RETURN_IF_ERROR(SurfaceFit(surfaces, nominal, by_surfaces, options.threads)
                         .Run(x, progress, stop));
  surfaces.Associate(Apply(nominal, x), options.threads);
  report.surface_rms_after_m = surfaces.Rms_m(kReportCutoff_m);
  if (report.surface_rms_after_m >
      (1 - kMinImprovement) * report.surface_rms_before_m) {
    // Where the surfaces do not ask for a change, noise decides it.
    x = Values{};
    report.surface_rms_after_m = report.surface_rms_before_m;
  }

  if (!dataset.depth_is_registered()) {
    double step_scale = 1;
    for (double smoothing_px : kSmoothing_px) {
      const EdgeAlignment edges(loaded.frames, Apply(nominal, x).depth,
                                smoothing_px, options.threads);
      report.edge_strength_before = edges.Strength(nominal);
      ClimbEdges(edges, nominal, by_edges, step_scale, x, progress, stop);
      report.edge_strength_after = edges.Strength(Apply(nominal, x));
      step_scale /= 4;
    }
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("calibration was interrupted");
  }
  report.calibration = Apply(nominal, x);
  return report;
}

absl::Status CheckPoses(const dataset::Dataset& dataset,
                        const CalibratorOptions& options, bool quiet,
                        const std::stop_token& stop) {
  if (UsableFrames(dataset).size() < 2) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const LoadedFrames loaded,
                      LoadFrames(dataset, options, quiet, stop));
  // Pictures of another size than the cameras' are refused where they matter.
  if (!CheckSizes(loaded, dataset.calibration()).ok()) return absl::OkStatus();
  return CheckConvention(dataset, loaded, options.threads);
}

}  // namespace treeline::training
