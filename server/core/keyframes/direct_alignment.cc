#include "server/core/keyframes/direct_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "server/core/features/rgbd_samples.h"
#include "server/core/keyframes/alignment_kernels.h"
#include "server/core/keyframes/brightness_moments.h"
#include "server/core/keyframes/cell_agreement.h"
#include "server/core/keyframes/depth_lookup.h"
#include "server/core/keyframes/light_field.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Scales of the robust fit of exposure (grey levels), one after the other;
// where an earlier fit is at hand, only the last.
constexpr std::array<float, 2> kExposureScales = {30, 15};

// The points of each keyframe make four runs, each evenly spread over the
// keyframe: those at every first, third, second and last place of four. The
// first runs of all keyframes stand first, and coarse levels use no more.
constexpr std::array<size_t, 4> kPlaces = {0, 2, 1, 3};
struct PointRun {
  size_t begin = 0;
  size_t end = 0;
};

struct Exposure {
  float gain = 1;
  float offset = 0;
};

// The least squares fit.
Exposure ExposureFrom(const ExposureSums& s) {
  const float variance = s.xx - s.x * s.x / s.w;
  Exposure exposure;
  exposure.gain =
      std::clamp(variance > s.w ? (s.xy - s.x * s.y / s.w) / variance : 1.0F,
                 1 / kMaxGain.value, kMaxGain.value);
  // From values less 128 to values.
  exposure.offset =
      (s.y - exposure.gain * s.x) / s.w + 128 * (1 - exposure.gain);
  return exposure;
}

// The picture in parts, row by row.
using BrightnessCells =
    std::array<BrightnessMoments,
               static_cast<size_t>(kExposureCells) * kExposureCells>;

class Aligner {
 public:
  Aligner(const KeyframeMap& map, const features::GrayPyramid& image,
          const image::DepthImage* depth,
          const camera::RgbdCalibration& calibration,
          const AlignmentOptions& options)
      : map_(map),
        image_(image),
        depth_(depth),
        calibration_(calibration),
        depth_from_color_(calibration.color_from_depth.Inverse()),
        options_(options) {
    if (depth != nullptr) depth_view_ = DepthViewOf(calibration, *depth);
  }

  std::optional<Alignment> Run(const geometry::Rigid3& world_from_color) {
    camera_from_world_ = world_from_color.Inverse();
    const std::vector<size_t> keyframes =
        map_.MostVisible(world_from_color, calibration_.color,
                         static_cast<size_t>(options_.keyframes));
    if (keyframes.empty()) return std::nullopt;
    Gather(keyframes, world_from_color.translation);
    for (int level = options_.first_level; level >= options_.last_level;
         --level) {
      const bool surfaces = depth_ != nullptr && level <= kSurfaceLevel &&
                            !options_.only_measures_depth;
      for (int i = 0; i < options_.iterations; ++i) {
        See(level, i == 0);
        if (visible_ < MinVisible(level)) return std::nullopt;
        if (options_.evens_light && !IsUneven()) return std::nullopt;
        if (surfaces && i == 0) MeasureSurfaces();
        if (!Step(level, surfaces)) return std::nullopt;
        if (step_norm_ < 2e-5 * (1 << level)) break;
      }
    }
    See(options_.last_level, false);
    if (visible_ < MinVisible(options_.last_level)) return std::nullopt;
    return Judge();
  }

 private:
  // Of the four runs of each keyframe.
  static size_t RunsAt(int level) {
    return level == 0 ? 4 : level == 1 ? 2 : 1;
  }
  static int MinVisible(int level) {
    return kMinVisible * static_cast<int>(RunsAt(level)) / 4;
  }
  std::span<const PointRun> ActiveRuns(int level) const {
    return std::span(runs_).first(RunsAt(level) * exposures_.size());
  }
  Exposure& ExposureOf(size_t run) {
    return exposures_[run % exposures_.size()];
  }

  // The keyframes' points, as the inner loops read them.
  void Gather(const std::vector<size_t>& keyframes, geometry::Vec3 origin) {
    origin_ = origin;
    exposures_.resize(keyframes.size());
    for (const size_t keyframe : keyframes) {
      total_points_ += static_cast<int>(map_.points(keyframe).size());
    }
    points_.Reserve(static_cast<size_t>(total_points_) +
                    kPlaces.size() * keyframes.size() * kAlignmentBlock);
    for (const size_t place : kPlaces) {
      for (const size_t keyframe : keyframes) {
        const std::span<const KeyframePoint> points = map_.points(keyframe);
        const size_t begin = points_.size();
        for (size_t i = place; i < points.size(); i += kPlaces.size()) {
          Append(points[i]);
        }
        points_.Pad();
        runs_.push_back({begin, points_.size()});
      }
    }
    seen_.resize(points_.size());
    if (depth_ != nullptr) measured_.resize(points_.size());
  }

  void Append(const KeyframePoint& point) {
    points_.Append(point.position_in_world, point.normal_in_world, origin_);
    for (size_t l = 0; l < points_.gray.size(); ++l) {
      points_.gray[l].push_back(point.gray[l]);
    }
  }

  PinholeView View() const {
    return ViewOf(camera_from_world_, calibration_.color, origin_);
  }

  // Fills seen_, exposures_ and visible_ from the pose; noise_ too if
  // `is_first` of a level.
  void See(int level, bool is_first) {
    const std::span<const PointRun> runs = ActiveRuns(level);
    const size_t end = runs.back().end;
    ProjectPoints(points_, 0, end, View(), seen_);
    if (calibration_.color.has_distortion()) {
      for (size_t i = 0; i < end; ++i) {
        if (seen_.seen[i] == 0) continue;
        const camera::Pixel pixel =
            calibration_.color.Project({seen_.x[i], seen_.y[i], seen_.z[i]});
        seen_.u[i] = static_cast<float>(pixel.x);
        seen_.v[i] = static_cast<float>(pixel.y);
      }
    }
    visible_ = SampleBrightness(image_, level, 0, end, seen_);
    if (options_.evens_light) EvenLight(level, is_first, end);
    for (size_t k = 0; k < exposures_.size(); ++k) FitExposure(level, k);
    if (is_first) MeasureNoise(level);
  }

  // As the light was at the level's first pose.
  void EvenLight(int level, bool is_first, size_t end) {
    if (is_first) {
      light_ = LightField::Fit(points_.gray[static_cast<size_t>(level)], seen_,
                               end, calibration_.color.width(),
                               calibration_.color.height());
    }
    if (light_) visible_ = light_->Even(end, seen_);
  }

  bool IsUneven() const {
    return light_ && light_->Unevenness() >= kMinUnevenness;
  }

  // Of keyframe k's points.
  ExposureSums SumsOf(int level, size_t k, const Exposure& exposure,
                      float scale) const {
    const std::span<const PointRun> runs = ActiveRuns(level);
    ExposureSums sums;
    for (size_t r = k; r < runs.size(); r += exposures_.size()) {
      sums += SumExposure(points_.gray[static_cast<size_t>(level)], seen_,
                          runs[r].begin, runs[r].end, exposure.gain,
                          exposure.offset, scale);
    }
    return sums;
  }

  // The same, part by part of the picture.
  BrightnessCells CellsOf(int level, size_t k) const {
    const auto& reference = points_.gray[static_cast<size_t>(level)];
    const std::span<const PointRun> runs = ActiveRuns(level);
    BrightnessCells cells;
    for (size_t r = k; r < runs.size(); r += exposures_.size()) {
      for (size_t i = runs[r].begin; i < runs[r].end; ++i) {
        if (seen_.seen[i] == 0) continue;
        cells[CellOf(i)].Add(reference[i], seen_.brightness[i]);
      }
    }
    return cells;
  }

  size_t CellOf(size_t i) const {
    const auto place = [](float at, int size) {
      return std::clamp(static_cast<int>(at) * kExposureCells / size, 0,
                        kExposureCells - 1);
    };
    return static_cast<size_t>(place(seen_.v[i], calibration_.color.height()) *
                                   kExposureCells +
                               place(seen_.u[i], calibration_.color.width()));
  }

  // What most of keyframe k's points agree with: of the exposures that fit the
  // whole picture and each part of it, since something may cover much of it.
  // Where brightness does not vary as the keyframe says, it tells none.
  Exposure FirstExposure(int level, size_t k) const {
    // A dim picture differs by less: else a gain that makes all alike would
    // explain anything.
    const auto support_of = [&](const Exposure& exposure) {
      return SumsOf(level, k, exposure,
                    kExposureScales.front() * std::min(1.0F, exposure.gain))
          .w;
    };
    Exposure best;
    float most = support_of(best);
    const auto consider = [&](const BrightnessMoments& moments) {
      if (moments.sums.w < kMinExposurePoints ||
          moments.Correlation() < kMinExposureCorrelation) {
        return;
      }
      const Exposure exposure = ExposureFrom(moments.sums);
      const float support = support_of(exposure);
      if (support <= most) return;
      most = support;
      best = exposure;
    };
    BrightnessMoments all;
    for (const BrightnessMoments& cell : CellsOf(level, k)) {
      consider(cell);
      all += cell;
    }
    consider(all);
    return best;
  }

  // What of keyframe k's brightness gain and offset explain.
  void FitExposure(int level, size_t k) {
    Exposure& exposure = exposures_[k];
    if (!is_exposed_) exposure = FirstExposure(level, k);
    for (const float scale : kExposureScales) {
      if (is_exposed_ && scale != kExposureScales.back()) continue;
      const ExposureSums sums = SumsOf(level, k, exposure, scale);
      if (!(sums.w > 0)) return;
      exposure = ExposureFrom(sums);
    }
    is_exposed_ = is_exposed_ || k + 1 == exposures_.size();
  }

  float Residual(int level, size_t run, size_t i) {
    const Exposure& exposure = ExposureOf(run);
    return seen_.brightness[i] -
           exposure.gain * points_.gray[static_cast<size_t>(level)][i] -
           exposure.offset;
  }

  void MeasureNoise(int level) {
    sizes_.clear();
    const std::span<const PointRun> runs = ActiveRuns(level);
    // One run of a keyframe says enough.
    for (size_t r = 0; r < exposures_.size(); ++r) {
      for (size_t i = runs[r].begin; i < runs[r].end; ++i) {
        if (seen_.seen[i] == 0) continue;
        sizes_.push_back(std::abs(Residual(level, r, i)));
      }
    }
    if (sizes_.empty()) return;
    const auto middle =
        sizes_.begin() + static_cast<std::ptrdiff_t>(sizes_.size() / 2);
    std::nth_element(sizes_.begin(), middle, sizes_.end());
    noise_ = std::clamp<double>(1.5 * static_cast<double>(*middle),
                                kMinBrightnessNoise, kMaxBrightnessNoise);
  }

  // One Gauss-Newton step. False: the pose is not determined.
  bool Step(int level, bool surfaces) {
    NormalSums sums;
    const PinholeView view = View();
    const std::span<const PointRun> runs = ActiveRuns(level);
    const double share = 4.0 / static_cast<double>(RunsAt(level));
    for (size_t r = 0; r < runs.size(); ++r) {
      const Exposure& exposure = ExposureOf(r);
      AddBrightness(points_.gray[static_cast<size_t>(level)], seen_,
                    runs[r].begin, runs[r].end, view, exposure.gain,
                    exposure.offset, static_cast<float>(2 * noise_),
                    static_cast<float>(share / (noise_ * noise_)), sums);
    }
    if (surfaces) {
      AddSurfaces(surfaces_, view, kMaxSurfaceDistance_m, sums);
    }
    Vector6 g;
    size_t next = 0;
    for (int a = 0; a < 6; ++a) {
      for (int b = a; b < 6; ++b) {
        information_(a, b) = information_(b, a) = sums.h[next++];
      }
      g(a) = sums.g[static_cast<size_t>(a)];
    }
    const Eigen::LDLT<Matrix6> factors(information_);
    if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-12)) {
      return false;
    }
    const Vector6 step = -factors.solve(g);
    const geometry::Rotation3 turn =
        geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]});
    camera_from_world_ = {
        geometry::Normalized(turn * camera_from_world_.rotation),
        turn * camera_from_world_.translation +
            geometry::Vec3{step[0], step[1], step[2]}};
    step_norm_ = step.norm();
    return geometry::IsFinite(camera_from_world_);
  }

  // The measured point where keyframe point p (in the colour camera) projects
  // into the depth image. False: nothing was measured there.
  bool Measured(geometry::Vec3 p, geometry::Vec3& measured,
                double& sigma_m) const {
    const camera::Camera& camera = calibration_.depth;
    const geometry::Vec3 q = depth_from_color_ * p;
    if (!(q.z > kMinPointDepth_m)) return false;
    const camera::Pixel pixel = camera.Project(q);
    if (!(pixel.x > 0 && pixel.y > 0 && pixel.x < camera.width() - 1 &&
          pixel.y < camera.height() - 1)) {
      return false;
    }
    const int x = static_cast<int>(pixel.x + 0.5);
    const int y = static_cast<int>(pixel.y + 0.5);
    const uint16_t value =
        depth_->values[static_cast<size_t>(y) *
                           static_cast<size_t>(depth_->width) +
                       static_cast<size_t>(x)];
    if (!image::IsMeasured(value)) return false;
    const double z = calibration_.depth_scale * depth_->unit_m * value;
    // The ray through the pixel's centre, from that through p's image.
    const geometry::Vec3 ray{q.x / q.z + (x - pixel.x) / camera.fx(),
                             q.y / q.z + (y - pixel.y) / camera.fy(), 1};
    measured = calibration_.color_from_depth * (z * ray);
    sigma_m = features::DepthSigma_m(z);
    return true;
  }

  // Fills measured_ for the first `end` points, as they are seen now.
  void MeasureUpTo(size_t end) {
    if (depth_view_) {
      MeasureDepth(seen_, 0, end, *depth_view_, measured_);
      return;
    }
    for (size_t i = 0; i < end; ++i) {
      geometry::Vec3 measured;
      double sigma_m = 0;
      measured_.sigma_m[i] = 0;
      if (seen_.seen[i] == 0 ||
          !Measured({seen_.x[i], seen_.y[i], seen_.z[i]}, measured, sigma_m)) {
        continue;
      }
      measured_.x[i] = static_cast<float>(measured.x);
      measured_.y[i] = static_cast<float>(measured.y);
      measured_.z[i] = static_cast<float>(measured.z);
      measured_.sigma_m[i] = static_cast<float>(sigma_m);
    }
  }

  // Whether point i has a normal, and something was measured there.
  bool HasSurface(size_t i) const {
    return measured_.sigma_m[i] > 0 &&
           (points_.nx[i] != 0 || points_.ny[i] != 0 || points_.nz[i] != 0);
  }

  // Finds the measured points that the keyframes' first runs project to; they
  // are held on to while a level is aligned, since a step moves a point along
  // its surface by less than the surface bends. `only_agreeing`: those whose
  // brightness agrees, too.
  void MeasureSurfaces(bool only_agreeing = false) {
    surfaces_.clear();
    const size_t first_runs = exposures_.size();
    MeasureUpTo(runs_[first_runs - 1].end);
    for (size_t run = 0; run < first_runs; ++run) {
      for (size_t i = runs_[run].begin; i < runs_[run].end; ++i) {
        if (!HasSurface(i)) continue;
        if (only_agreeing && !AgreesInBrightness(run, i)) continue;
        AppendSurface(i);
      }
    }
    surfaces_.Pad();
  }

  void AppendSurface(size_t i) {
    const double sigma_m = measured_.sigma_m[i];
    surfaces_.Append({points_.x[i], points_.y[i], points_.z[i]},
                     {points_.nx[i], points_.ny[i], points_.nz[i]},
                     {measured_.x[i], measured_.y[i], measured_.z[i]},
                     sigma_m * sigma_m + kSurfaceNoise_m * kSurfaceNoise_m);
  }

  // A dim image differs by less.
  bool AgreesInBrightness(size_t run, size_t i) {
    return std::abs(Residual(options_.last_level, run, i)) <=
           kAgreeingBrightness * std::min(1.0F, ExposureOf(run).gain);
  }

  // What is covered agrees neither in brightness nor in depth, and tells
  // nothing; what lies on its surface and looks otherwise contradicts.
  void JudgeSurfaces(Alignment& alignment, CellAgreement& cells) {
    const geometry::Mat3 r = camera_from_world_.rotation.Matrix();
    const std::span<const PointRun> runs = ActiveRuns(options_.last_level);
    MeasureUpTo(runs.back().end);
    int lying = 0;
    for (size_t run = 0; run < runs.size(); ++run) {
      for (size_t i = runs[run].begin; i < runs[run].end; ++i) {
        if (!HasSurface(i)) continue;
        const geometry::Vec3 normal{points_.nx[i], points_.ny[i],
                                    points_.nz[i]};
        const geometry::Vec3 gap{seen_.x[i] - measured_.x[i],
                                 seen_.y[i] - measured_.y[i],
                                 seen_.z[i] - measured_.z[i]};
        const bool lies = std::abs(geometry::Dot(r * normal, gap)) <=
                          0.02 + 3 * static_cast<double>(measured_.sigma_m[i]);
        const bool agrees = AgreesInBrightness(run, i);
        alignment.measured += agrees;
        lying += agrees && lies;
        if (lies) AddTo(cells, run, i, agrees);
      }
    }
    if (alignment.measured > 0) {
      alignment.depth_agreement =
          static_cast<double>(lying) / alignment.measured;
    }
  }

  void AddTo(CellAgreement& cells, size_t run, size_t i, bool agrees) {
    const float brightness = seen_.brightness[i];
    cells.Add(seen_.u[i], seen_.v[i],
              brightness - Residual(options_.last_level, run, i), brightness,
              agrees);
  }

  std::optional<DepthScale> JudgeDepthScale() {
    PoseInformation information;
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        information[static_cast<size_t>(6 * i + j)] = information_(i, j);
      }
    }
    if (!options_.only_measures_depth) {
      return DepthScaleStep(surfaces_, View(), information);
    }
    MeasureSurfaces(/*only_agreeing=*/true);
    return EstimateDepthScale(surfaces_, View(), information);
  }

  Alignment Judge() {
    Alignment alignment;
    alignment.world_from_camera = camera_from_world_.Inverse();
    alignment.visible = visible_;
    alignment.overlap = static_cast<double>(visible_) / total_points_;
    double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
    int agreeing = 0;
    CellAgreement cells(calibration_.color.width(),
                        calibration_.color.height());
    const std::span<const PointRun> runs = ActiveRuns(options_.last_level);
    for (size_t run = 0; run < runs.size(); ++run) {
      for (size_t i = runs[run].begin; i < runs[run].end; ++i) {
        if (seen_.seen[i] == 0) continue;
        const bool agrees = AgreesInBrightness(run, i);
        agreeing += agrees;
        if (depth_ == nullptr) AddTo(cells, run, i, agrees);
        // Against what the keyframe, exposed alike, would have shown.
        const double b = seen_.brightness[i];
        const double a = b - Residual(options_.last_level, run, i);
        sa += a;
        sb += b;
        saa += a * a;
        sbb += b * b;
        sab += a * b;
      }
    }
    const double n = alignment.visible;
    alignment.agreement = agreeing / n;
    const double va = saa - sa * sa / n;
    const double vb = sbb - sb * sb / n;
    if (va > n && vb > n) {
      alignment.correlation = (sab - sa * sb / n) / std::sqrt(va * vb);
    }
    if (depth_ != nullptr) {
      JudgeSurfaces(alignment, cells);
      alignment.depth_scale = JudgeDepthScale();
    }
    alignment.contradicted = cells.Contradicted();
    // From a step in the camera's frame to one in the world's.
    const Matrix6 in_camera =
        kCorrelatedPoints * information_.ldlt().solve(Matrix6::Identity());
    const geometry::Mat3 r = alignment.world_from_camera.rotation.Matrix();
    Eigen::Matrix3d rotation;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) rotation(i, j) = r(i, j);
    }
    Matrix6 turn = Matrix6::Zero();
    turn.topLeftCorner<3, 3>() = rotation;
    turn.bottomRightCorner<3, 3>() = rotation;
    const Matrix6 in_world = turn * in_camera * turn.transpose();
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        alignment.covariance[static_cast<size_t>(6 * i + j)] =
            0.5 * (in_world(i, j) + in_world(j, i));
      }
    }
    return alignment;
  }

  const KeyframeMap& map_;
  const features::GrayPyramid& image_;
  const image::DepthImage* depth_;
  const camera::RgbdCalibration& calibration_;
  const geometry::Rigid3 depth_from_color_;
  const AlignmentOptions& options_;
  AlignmentPoints points_;
  VisiblePoints seen_;
  // nullopt: of a lens that is looked through point by point.
  std::optional<DepthView> depth_view_;
  MeasuredPoints measured_;
  SurfacePoints surfaces_;
  std::vector<PointRun> runs_;
  geometry::Vec3 origin_;
  geometry::Rigid3 camera_from_world_;
  std::vector<Exposure> exposures_;  // one a keyframe
  bool is_exposed_ = false;          // they have been fitted
  std::optional<LightField> light_;
  std::vector<float> sizes_;
  int total_points_ = 0;
  int visible_ = 0;
  Matrix6 information_ = Matrix6::Zero();
  double noise_ = kMaxBrightnessNoise;
  double step_norm_ = 0;
};

}  // namespace

std::optional<Alignment> AlignToKeyframes(
    const KeyframeMap& map, const features::GrayPyramid& image,
    const image::DepthImage* depth, const camera::RgbdCalibration& calibration,
    const geometry::Rigid3& world_from_color, const AlignmentOptions& options) {
  return Aligner(map, image, depth, calibration, options).Run(world_from_color);
}

}  // namespace treeline::keyframes
