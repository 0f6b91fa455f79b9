#include "server/core/keyframes/direct_alignment.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "server/core/features/rgbd_samples.h"

namespace treeline {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kMinVisible = 60;
// Keyframes are chosen by every so manieth of their points.
constexpr size_t kGlance = 16;
// From this far away (as KeyframeMap::Nearest has it, m) a keyframe counts
// half.
constexpr double kSameView_m = 0.25;
constexpr double kNearest_m = 0.05;
// Surfaces seen at a grazing angle hide what lies behind: cosine.
constexpr double kMinFacing = 0.15;
// Brightness (grey levels): least noise, and what agrees at the end.
constexpr double kMinNoise = 3;
constexpr double kMaxNoise = 25;
constexpr double kAgreeing = 15;
// Neighbouring points err alike: the covariance is widened by this.
constexpr double kCorrelatedPoints = 4;
// Distances to measured surfaces (m): noise beside the sensor's own, and what
// is no longer the same surface.
constexpr double kSurfaceNoise_m = 0.01;
constexpr double kMaxSurfaceDistance_m = 0.15;

// A keyframe point as the image sees it.
struct Seen {
  Vec3 point_in_camera;
  // d(pixel at level 0) / d(point in camera).
  double du_dx, du_dz, dv_dy, dv_dz;
  double reference;  // brightness in the keyframe
  double brightness;
  double gradient_x;  // per pixel of level 0
  double gradient_y;
  double residual;
};

struct NormalEquations {
  Matrix6 h = Matrix6::Zero();
  Vector6 g = Vector6::Zero();

  // A residual r with derivative j with respect to the point in the camera;
  // the point moves by v + w x p for a step (v, w) in the camera's frame.
  void Add(Vec3 p, Vec3 j, double r, double weight) {
    const Vec3 turn = Cross(p, j);
    const double row[6] = {j.x, j.y, j.z, turn.x, turn.y, turn.z};
    for (int a = 0; a < 6; ++a) {
      const double wa = weight * row[a];
      for (int b = a; b < 6; ++b) h(a, b) += wa * row[b];
      g(a) += wa * r;
    }
  }
};

double GemanMcClure(double squared, double scale) {
  const double root = scale * scale / (scale * scale + squared);
  return root * root;
}

class Aligner {
 public:
  Aligner(const KeyframeMap& map, const GrayPyramid& image,
          const DepthImage* depth, const RgbdCalibration& calibration,
          const AlignmentOptions& options)
      : map_(map),
        image_(image),
        depth_(depth),
        calibration_(calibration),
        depth_from_color_(calibration.color_from_depth.Inverse()),
        options_(options) {}

  std::optional<Alignment> Run(const Rigid3& world_from_color) {
    camera_from_world_ = world_from_color.Inverse();
    ChooseKeyframes();
    if (keyframes_.empty()) return std::nullopt;
    for (int level = options_.first_level; level >= options_.last_level;
         --level) {
      for (int i = 0; i < options_.iterations; ++i) {
        See(level);
        if (static_cast<int>(seen_.size()) < kMinVisible) return std::nullopt;
        const bool surfaces = depth_ != nullptr && level <= 1;
        if (!Step(surfaces)) return std::nullopt;
        if (step_norm_ < 2e-5 * (1 << level)) break;
      }
    }
    See(options_.last_level);
    if (static_cast<int>(seen_.size()) < kMinVisible) return std::nullopt;
    return Judge();
  }

 private:
  // Those of which much should be seen, from about the same place.
  void ChooseKeyframes() {
    const Rigid3 world_from_camera = camera_from_world_.Inverse();
    const Vec3 axis = world_from_camera.rotation * Vec3{0, 0, 1};
    const Camera& camera = calibration_.color;
    const Mat3 r = camera_from_world_.rotation.Matrix();
    std::vector<std::pair<double, size_t>> seen;  // the best score is least
    for (size_t k = 0; k < map_.size(); ++k) {
      const std::span<const KeyframePoint> points = map_.points(k);
      int count = 0;
      for (size_t i = 0; i < points.size(); i += kGlance) {
        const auto& world = points[i].position_in_world;
        const Vec3 p = r * Vec3{world[0], world[1], world[2]} +
                       camera_from_world_.translation;
        if (!(p.z > kNearest_m) || !Faces(r, points[i], p)) continue;
        const Pixel pixel = camera.Project(p);
        count += pixel.x > 0 && pixel.y > 0 && pixel.x < camera.width() &&
                 pixel.y < camera.height();
      }
      if (count == 0) continue;
      const Rigid3& keyframe = map_.world_from_camera(k);
      const double turn =
          kViewDistance_m * Norm(keyframe.rotation * Vec3{0, 0, 1} - axis);
      const double distance2 =
          SquaredNorm(keyframe.translation - world_from_camera.translation) +
          turn * turn;
      seen.emplace_back(-count / (1 + distance2 / (kSameView_m * kSameView_m)),
                        k);
    }
    const size_t kept =
        std::min(seen.size(), static_cast<size_t>(options_.keyframes));
    std::partial_sort(seen.begin(),
                      seen.begin() + static_cast<std::ptrdiff_t>(kept),
                      seen.end());
    keyframes_.clear();
    for (size_t i = 0; i < kept; ++i) keyframes_.push_back(seen[i].second);
  }

  // Fills seen_ with the points of keyframes_ that lie in the image, each with
  // its brightness residual.
  void See(int level) {
    seen_.clear();
    const GrayPyramid::Level& image = image_.level(level);
    const Camera& camera = calibration_.color;
    const Mat3 r = camera_from_world_.rotation.Matrix();
    const Vec3 t = camera_from_world_.translation;
    const double shrink = 1.0 / (1 << level);
    const float right = static_cast<float>(image.width) - 2.5f;
    const float bottom = static_cast<float>(image.height) - 2.5f;
    for (const size_t k : keyframes_) {
      const size_t first = seen_.size();
      for (const KeyframePoint& point : map_.points(k)) {
        const Vec3 world{point.position_in_world[0], point.position_in_world[1],
                         point.position_in_world[2]};
        const Vec3 p = r * world + t;
        if (!(p.z > kNearest_m)) continue;
        const Pixel pixel = camera.Project(p);
        const float x = AtLevel(static_cast<float>(pixel.x), level);
        const float y = AtLevel(static_cast<float>(pixel.y), level);
        if (!(x > 1.5f && y > 1.5f && x < right && y < bottom)) continue;
        if (!Faces(r, point, p)) continue;
        Seen seen;
        seen.point_in_camera = p;
        const double iz = 1 / p.z;
        seen.du_dx = camera.fx() * iz;
        seen.du_dz = -camera.fx() * p.x * iz * iz;
        seen.dv_dy = camera.fy() * iz;
        seen.dv_dz = -camera.fy() * p.y * iz * iz;
        seen.reference = point.gray[static_cast<size_t>(level)];
        seen.brightness = static_cast<double>(image.At(x, y));
        seen.gradient_x = shrink * static_cast<double>(image.At(x + 0.5f, y) -
                                                       image.At(x - 0.5f, y));
        seen.gradient_y = shrink * static_cast<double>(image.At(x, y + 0.5f) -
                                                       image.At(x, y - 0.5f));
        seen.residual = 0;
        seen_.push_back(seen);
      }
      TakeOutExposure(first);
    }
    std::vector<double>& sizes = scratch_;
    sizes.clear();
    for (const Seen& s : seen_) sizes.push_back(std::abs(s.residual));
    if (sizes.empty()) return;
    const auto middle =
        sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    noise_ = std::clamp(1.5 * *middle, kMinNoise, kMaxNoise);
  }

  static bool Faces(const Mat3& r, const KeyframePoint& point, Vec3 p) {
    const auto& n = point.normal_in_world;
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) return true;
    const Vec3 normal = r * Vec3{n[0] / 127.0, n[1] / 127.0, n[2] / 127.0};
    return -Dot(normal, p) > kMinFacing * Norm(p);
  }

  // Residuals of seen_[first, end): what gain and offset do not explain.
  void TakeOutExposure(size_t first) {
    double gain = 1;
    double offset = 0;
    double scale = 1e9;
    for (int round = 0; round < 3; ++round) {
      double sw = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
      for (size_t i = first; i < seen_.size(); ++i) {
        const Seen& s = seen_[i];
        const double r = s.brightness - gain * s.reference - offset;
        const double w = GemanMcClure(r * r, scale);
        sw += w;
        sx += w * s.reference;
        sy += w * s.brightness;
        sxx += w * s.reference * s.reference;
        sxy += w * s.reference * s.brightness;
      }
      if (!(sw > 0)) return;
      const double variance = sxx - sx * sx / sw;
      gain = variance > sw ? (sxy - sx * sy / sw) / variance : 1;
      gain = std::clamp(gain, 0.5, 2.0);
      offset = (sy - gain * sx) / sw;
      scale = round == 0 ? 30 : 15;
    }
    for (size_t i = first; i < seen_.size(); ++i) {
      Seen& s = seen_[i];
      s.residual = s.brightness - gain * s.reference - offset;
    }
  }

  // One Gauss-Newton step. False: the pose is not determined.
  bool Step(bool surfaces) {
    equations_ = NormalEquations{};
    const double weight = 1 / (noise_ * noise_);
    for (const Seen& s : seen_) {
      const Vec3 j{s.gradient_x * s.du_dx, s.gradient_y * s.dv_dy,
                   s.gradient_x * s.du_dz + s.gradient_y * s.dv_dz};
      equations_.Add(
          s.point_in_camera, j, s.residual,
          weight * GemanMcClure(s.residual * s.residual, 2 * noise_));
    }
    if (surfaces) AddSurfaces();
    Matrix6& h = equations_.h;
    h.triangularView<Eigen::StrictlyLower>() = h.transpose();
    const Eigen::LDLT<Matrix6> factors(h);
    if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-12)) {
      return false;
    }
    const Vector6 step = -factors.solve(equations_.g);
    const Rotation3 turn =
        Rotation3::FromAxisAngle({step[3], step[4], step[5]});
    camera_from_world_ = {Normalized(turn * camera_from_world_.rotation),
                          turn * camera_from_world_.translation +
                              Vec3{step[0], step[1], step[2]}};
    step_norm_ = step.norm();
    return IsFinite(camera_from_world_);
  }

  // The measured point where keyframe point p (in the colour camera) projects
  // into the depth image. False: nothing was measured there.
  bool Measured(Vec3 p, Vec3& measured, double& sigma_m) const {
    const Camera& camera = calibration_.depth;
    const Vec3 q = depth_from_color_ * p;
    if (!(q.z > kNearest_m)) return false;
    const Pixel pixel = camera.Project(q);
    if (!(pixel.x > 0 && pixel.y > 0 && pixel.x < camera.width() - 1 &&
          pixel.y < camera.height() - 1)) {
      return false;
    }
    const int x = static_cast<int>(std::lround(pixel.x));
    const int y = static_cast<int>(std::lround(pixel.y));
    const uint16_t value =
        depth_->values[static_cast<size_t>(y) *
                           static_cast<size_t>(depth_->width) +
                       static_cast<size_t>(x)];
    if (!IsMeasured(value)) return false;
    const double z = calibration_.depth_scale * depth_->unit_m * value;
    // The ray through the pixel's centre, from that through p's image.
    const Vec3 ray{q.x / q.z + (x - pixel.x) / camera.fx(),
                   q.y / q.z + (y - pixel.y) / camera.fy(), 1};
    measured = calibration_.color_from_depth * (z * ray);
    sigma_m = DepthSigma_m(z);
    return true;
  }

  template <typename Visit>
  void VisitSurfaces(const Visit& visit) const {
    const Mat3 r = camera_from_world_.rotation.Matrix();
    for (const size_t k : keyframes_) {
      for (const KeyframePoint& point : map_.points(k)) {
        const auto& n = point.normal_in_world;
        if (n[0] == 0 && n[1] == 0 && n[2] == 0) continue;
        const Vec3 world{point.position_in_world[0], point.position_in_world[1],
                         point.position_in_world[2]};
        const Vec3 p = r * world + camera_from_world_.translation;
        if (!Faces(r, point, p)) continue;
        Vec3 measured;
        double sigma_m = 0;
        if (!Measured(p, measured, sigma_m)) continue;
        const Vec3 normal = r * Vec3{n[0] / 127.0, n[1] / 127.0, n[2] / 127.0};
        visit(p, normal, Dot(normal, p - measured), sigma_m);
      }
    }
  }

  void AddSurfaces() {
    VisitSurfaces([&](Vec3 p, Vec3 normal, double distance_m, double sigma_m) {
      if (std::abs(distance_m) > kMaxSurfaceDistance_m) return;
      const double variance =
          sigma_m * sigma_m + kSurfaceNoise_m * kSurfaceNoise_m;
      equations_.Add(
          p, normal, distance_m,
          GemanMcClure(distance_m * distance_m, 2 * std::sqrt(variance)) /
              variance);
    });
  }

  Alignment Judge() {
    Alignment alignment;
    alignment.world_from_camera = camera_from_world_.Inverse();
    alignment.visible = static_cast<int>(seen_.size());
    size_t points = 0;
    for (const size_t k : keyframes_) points += map_.points(k).size();
    alignment.overlap =
        static_cast<double>(seen_.size()) / static_cast<double>(points);
    double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
    int agreeing = 0;
    for (const Seen& s : seen_) {
      agreeing += std::abs(s.residual) <= kAgreeing;
      // Against what the keyframe, exposed alike, would have shown.
      const double a = s.brightness - s.residual;
      const double b = s.brightness;
      sa += a;
      sb += b;
      saa += a * a;
      sbb += b * b;
      sab += a * b;
    }
    const double n = alignment.visible;
    alignment.agreement = agreeing / n;
    const double va = saa - sa * sa / n;
    const double vb = sbb - sb * sb / n;
    if (va > n && vb > n) {
      alignment.correlation = (sab - sa * sb / n) / std::sqrt(va * vb);
    }
    if (depth_ != nullptr) {
      int lying = 0;
      VisitSurfaces([&](Vec3, Vec3, double distance_m, double sigma_m) {
        ++alignment.measured;
        lying += std::abs(distance_m) <= 0.02 + 3 * sigma_m;
      });
      if (alignment.measured > 0) {
        alignment.depth_agreement =
            static_cast<double>(lying) / alignment.measured;
      }
    }
    // From a step in the camera's frame to one in the world's.
    const Matrix6 in_camera =
        kCorrelatedPoints * equations_.h.ldlt().solve(Matrix6::Identity());
    const Mat3 r = alignment.world_from_camera.rotation.Matrix();
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
  const GrayPyramid& image_;
  const DepthImage* depth_;
  const RgbdCalibration& calibration_;
  const Rigid3 depth_from_color_;
  const AlignmentOptions& options_;
  std::vector<size_t> keyframes_;
  Rigid3 camera_from_world_;
  std::vector<Seen> seen_;
  std::vector<double> scratch_;
  NormalEquations equations_;
  double noise_ = kMaxNoise;
  double step_norm_ = 0;
};

}  // namespace

std::optional<Alignment> AlignToKeyframes(const KeyframeMap& map,
                                          const GrayPyramid& image,
                                          const DepthImage* depth,
                                          const RgbdCalibration& calibration,
                                          const Rigid3& world_from_color,
                                          const AlignmentOptions& options) {
  return Aligner(map, image, depth, calibration, options).Run(world_from_color);
}

}  // namespace treeline
