#include "common/camera/camera.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"

namespace treeline::camera {
namespace {

constexpr int kMaxSize_px = 16384;
constexpr int kMaxIterations = 50;
// Newton stops when the distorted ray is this close to the one that is sought,
// in units of x/z: 1e-8 of a pixel and less for any focal length here.
constexpr double kConverged = 1e-12;
// Of the FOV model (rad).
constexpr double kMaxOmega = std::numbers::pi;

struct ModelEntry {
  CameraModel model;
  const char* name;
  const char* parameter_names;
  int parameter_count;
  int focal_length_count;
};

constexpr ModelEntry kModels[] = {
    {CameraModel::kSimplePinhole, "SIMPLE_PINHOLE", "f,cx,cy", 3, 1},
    {CameraModel::kPinhole, "PINHOLE", "fx,fy,cx,cy", 4, 2},
    {CameraModel::kSimpleRadial, "SIMPLE_RADIAL", "f,cx,cy,k", 4, 1},
    {CameraModel::kRadial, "RADIAL", "f,cx,cy,k1,k2", 5, 1},
    {CameraModel::kOpenCv, "OPENCV", "fx,fy,cx,cy,k1,k2,p1,p2", 8, 2},
    {CameraModel::kFullOpenCv, "FULL_OPENCV",
     "fx,fy,cx,cy,k1,k2,p1,p2,k3,k4,k5,k6", 12, 2},
    {CameraModel::kOpenCvFisheye, "OPENCV_FISHEYE", "fx,fy,cx,cy,k1,k2,k3,k4",
     8, 2},
    {CameraModel::kFov, "FOV", "fx,fy,cx,cy,omega", 5, 2},
    {CameraModel::kSimpleRadialFisheye, "SIMPLE_RADIAL_FISHEYE", "f,cx,cy,k", 4,
     1},
    {CameraModel::kRadialFisheye, "RADIAL_FISHEYE", "f,cx,cy,k1,k2", 5, 1},
    {CameraModel::kThinPrismFisheye, "THIN_PRISM_FISHEYE",
     "fx,fy,cx,cy,k1,k2,p1,p2,k3,k4,sx1,sy1", 12, 2},
};

const ModelEntry& EntryOf(CameraModel model) {
  for (const ModelEntry& entry : kModels) {
    if (entry.model == model) return entry;
  }
  return kModels[0];
}

// d(imaged)/d(ray) of a distortion.
struct Jacobian2 {
  double xx = 0, xy = 0, yx = 0, yy = 0;
};

// Newton from the distorted ray. The Jacobian's determinant and trace have to
// stay positive: where they do not, the image is folded and the ray means
// nothing.
template <typename Distortion>
std::optional<Pixel> InvertByNewton(const Distortion& distortion,
                                    Pixel distorted) {
  Pixel ray = distorted;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Pixel now = distortion.Distort(ray);
    const double ex = distorted.x - now.x;
    const double ey = distorted.y - now.y;
    const auto [xx, xy, yx, yy] = distortion.Jacobian(ray);
    const double determinant = xx * yy - xy * yx;
    if (!(determinant > 1e-9) || !(xx + yy > 0)) return std::nullopt;
    if (std::abs(ex) < kConverged && std::abs(ey) < kConverged) return ray;
    ray.x += (yy * ex - xy * ey) / determinant;
    ray.y += (xx * ey - yx * ex) / determinant;
  }
  return std::nullopt;
}

// The ray at angle |equidistant| from the optical axis, in its direction.
// Rays across or behind the camera have no (x/z, y/z).
std::optional<Pixel> RayOfEquidistant(Pixel equidistant) {
  const double theta = std::hypot(equidistant.x, equidistant.y);
  if (theta < 1e-12) return equidistant;
  if (!(theta < std::numbers::pi / 2)) return std::nullopt;
  const double scale = std::tan(theta) / theta;
  return Pixel{scale * equidistant.x, scale * equidistant.y};
}

// The inverse: where an ideal fisheye of focal length 1 images a ray.
Pixel EquidistantOfRay(Pixel ray) {
  const double r = std::hypot(ray.x, ray.y);
  if (r < 1e-12) return ray;
  const double scale = std::atan(r) / r;
  return {scale * ray.x, scale * ray.y};
}

// OpenCV's rational model with tangential distortion. With r2 = x^2 + y^2 and
//   g = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
// the ray (x, y) is imaged at
//   x' = g x + 2 p1 x y + p2 (r2 + 2 x^2)
//   y' = g y + p1 (r2 + 2 y^2) + 2 p2 x y.
// The polynomial models are special cases of it.
struct RationalDistortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;

  static RationalDistortion Of(CameraModel model, const double* parameters) {
    const double* p = parameters;
    switch (model) {
      case CameraModel::kSimpleRadial:
        return {.k1 = p[3]};
      case CameraModel::kRadial:
        return {.k1 = p[3], .k2 = p[4]};
      case CameraModel::kOpenCv:
        return {.k1 = p[4], .k2 = p[5], .p1 = p[6], .p2 = p[7]};
      case CameraModel::kFullOpenCv:
        return {p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11]};
      default:
        return {};
    }
  }

  Pixel Distort(Pixel ray) const {
    const double x = ray.x;
    const double y = ray.y;
    const double r2 = x * x + y * y;
    const double g = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) /
                     (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
    return {g * x + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            g * y + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  }

  Jacobian2 Jacobian(Pixel ray) const {
    const double x = ray.x;
    const double y = ray.y;
    const double r2 = x * x + y * y;
    const double numerator = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double denominator = 1 + r2 * (k4 + r2 * (k5 + r2 * k6));
    const double numerator_slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);
    const double denominator_slope = k4 + r2 * (2 * k5 + r2 * 3 * k6);
    const double g = numerator / denominator;
    const double slope =
        (numerator_slope - g * denominator_slope) / denominator;
    const double xy = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
    return {g + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x, xy, xy,
            g + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x};
  }
};

// OpenCV's fisheye model: a ray at angle theta from the optical axis is imaged
// at radius theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
// COLMAP's radial fisheyes are special cases of it.
struct FisheyeDistortion {
  std::array<double, 4> k{};

  static FisheyeDistortion Of(CameraModel model, const double* parameters) {
    const double* p = parameters;
    switch (model) {
      case CameraModel::kSimpleRadialFisheye:
        return {{p[3]}};
      case CameraModel::kRadialFisheye:
        return {{p[3], p[4]}};
      default:
        return {{p[4], p[5], p[6], p[7]}};
    }
  }

  double Radius(double theta) const {
    const double t2 = theta * theta;
    return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  }

  double Slope(double theta) const {
    const double t2 = theta * theta;
    return 1 +
           t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
  }

  Pixel Distort(Pixel ray) const {
    const double r = std::hypot(ray.x, ray.y);
    if (r < 1e-12) return ray;
    const double scale = Radius(std::atan(r)) / r;
    return {scale * ray.x, scale * ray.y};
  }

  std::optional<Pixel> Undistort(Pixel distorted) const {
    const double radius = std::hypot(distorted.x, distorted.y);
    if (radius < 1e-12) return distorted;
    double theta = std::min(radius, std::numbers::pi / 2);
    for (int i = 0; i < kMaxIterations; ++i) {
      const double error = radius - Radius(theta);
      const double slope = Slope(theta);
      if (!(slope > 1e-9)) return std::nullopt;
      if (std::abs(error) < kConverged) {
        // Rays across or behind the camera have no (x/z, y/z).
        if (theta <= 0 || theta >= std::numbers::pi / 2) return std::nullopt;
        const double scale = std::tan(theta) / radius;
        return Pixel{scale * distorted.x, scale * distorted.y};
      }
      theta += error / slope;
    }
    return std::nullopt;
  }
};

// COLMAP's thin prism fisheye: the rational model's kind of polynomial on the
// equidistant image (u, v) of the ray. With r2 = u^2 + v^2 and
//   g = 1 + k1 r2 + k2 r2^2 + k3 r2^3 + k4 r2^4
// it is imaged at
//   u' = g u + 2 p1 u v + p2 (r2 + 2 u^2) + sx1 r2
//   v' = g v + p1 (r2 + 2 v^2) + 2 p2 u v + sy1 r2.
struct ThinPrismDistortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, sx1 = 0, sy1 = 0;

  static ThinPrismDistortion Of(const double* p) {
    return {p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11]};
  }

  Pixel Distort(Pixel equidistant) const {
    const double u = equidistant.x;
    const double v = equidistant.y;
    const double r2 = u * u + v * v;
    const double g = 1 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)));
    return {g * u + 2 * p1 * u * v + p2 * (r2 + 2 * u * u) + sx1 * r2,
            g * v + p1 * (r2 + 2 * v * v) + 2 * p2 * u * v + sy1 * r2};
  }

  Jacobian2 Jacobian(Pixel equidistant) const {
    const double u = equidistant.x;
    const double v = equidistant.y;
    const double r2 = u * u + v * v;
    const double g = 1 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)));
    const double slope = 2 * (k1 + r2 * (2 * k2 + r2 * (3 * k3 + r2 * 4 * k4)));
    const double cross = u * v * slope + 2 * p1 * u + 2 * p2 * v;
    return {g + u * u * slope + 2 * p1 * v + 6 * p2 * u + 2 * sx1 * u,
            cross + 2 * sx1 * v, cross + 2 * sy1 * u,
            g + v * v * slope + 6 * p1 * v + 2 * p2 * u + 2 * sy1 * v};
  }
};

// Devernay and Faugeras' model of a lens of field of view omega: radius r is
// imaged at atan(2 r tan(omega / 2)) / omega.
struct FovDistortion {
  double omega = 0;

  // Below this the lens is a pinhole to all digits.
  bool is_none() const { return std::abs(omega) < 1e-8; }

  Pixel Distort(Pixel ray) const {
    const double r = std::hypot(ray.x, ray.y);
    if (is_none() || r < 1e-12) return ray;
    const double scale = std::atan(2 * r * std::tan(omega / 2)) / (omega * r);
    return {scale * ray.x, scale * ray.y};
  }

  std::optional<Pixel> Undistort(Pixel distorted) const {
    const double radius = std::hypot(distorted.x, distorted.y);
    if (is_none() || radius < 1e-12) return distorted;
    if (!(std::abs(radius * omega) < std::numbers::pi / 2)) return std::nullopt;
    const double scale =
        std::tan(radius * omega) / (2 * radius * std::tan(omega / 2));
    return Pixel{scale * distorted.x, scale * distorted.y};
  }
};

std::string ShortestText(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return std::string(buffer, end);
}

}  // namespace

absl::string_view CameraModelName(CameraModel model) {
  return EntryOf(model).name;
}

absl::StatusOr<CameraModel> ParseCameraModel(absl::string_view name) {
  for (const ModelEntry& entry : kModels) {
    if (name == entry.name) return entry.model;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "unknown camera model '", name, "'; known are ",
      absl::StrJoin(kModels, ", ", [](std::string* out, const ModelEntry& e) {
        out->append(e.name);
      })));
}

int CameraParameterCount(CameraModel model) {
  return EntryOf(model).parameter_count;
}

int CameraPrincipalPointIndex(CameraModel model) {
  return EntryOf(model).focal_length_count;
}

absl::StatusOr<Camera> Camera::Create(CameraModel model, int width, int height,
                                      const double* parameters,
                                      int parameter_count) {
  const ModelEntry& entry = EntryOf(model);
  if (entry.model != model) {
    return absl::InvalidArgumentError(absl::StrCat(
        "camera model number ", static_cast<int>(model), " does not exist"));
  }
  if (parameter_count != entry.parameter_count) {
    return absl::InvalidArgumentError(absl::StrCat(
        "camera model ", entry.name, " takes ", entry.parameter_count,
        " parameters (", entry.parameter_names, "), not ", parameter_count));
  }
  if (width < 1 || width > kMaxSize_px || height < 1 || height > kMaxSize_px) {
    return absl::InvalidArgumentError(absl::StrCat("camera size ", width, " x ",
                                                   height, " is outside 1..",
                                                   kMaxSize_px, " pixels"));
  }
  Camera camera;
  camera.model_ = model;
  camera.width_ = width;
  camera.height_ = height;
  camera.parameters_ = {};
  for (int i = 0; i < parameter_count; ++i) {
    if (!std::isfinite(parameters[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat("camera parameter ", i + 1, " of ", entry.name, " (",
                       entry.parameter_names, ") is not a finite number"));
    }
    camera.parameters_[static_cast<size_t>(i)] = parameters[i];
  }
  for (int i = 0; i < entry.focal_length_count; ++i) {
    if (!(parameters[i] > 0)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "camera focal length ", parameters[i], " px is not positive"));
    }
  }
  const int focal_count = entry.focal_length_count;
  camera.fx_ = parameters[0];
  camera.fy_ = parameters[focal_count - 1];
  camera.cx_ = parameters[focal_count];
  camera.cy_ = parameters[focal_count + 1];
  if (model == CameraModel::kFov && !(std::abs(parameters[4]) < kMaxOmega)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "camera omega ", parameters[4], " rad is outside (-pi, pi)"));
  }
  // A fisheye bends even with all coefficients 0.
  camera.has_distortion_ = model == CameraModel::kOpenCvFisheye ||
                           model == CameraModel::kSimpleRadialFisheye ||
                           model == CameraModel::kRadialFisheye ||
                           model == CameraModel::kThinPrismFisheye;
  for (int i = focal_count + 2; i < parameter_count; ++i) {
    if (parameters[i] != 0) camera.has_distortion_ = true;
  }
  return camera;
}

absl::StatusOr<Camera> Camera::Parse(absl::string_view text, int width,
                                     int height) {
  const std::vector<absl::string_view> parts = absl::StrSplit(text, ',');
  const auto context = [&] {
    return absl::StrCat("camera '", text, "' (expected MODEL,p1,p2,...)");
  };
  const absl::StatusOr<CameraModel> model =
      ParseCameraModel(absl::StripAsciiWhitespace(parts[0]));
  if (!model.ok()) return base::Annotate(model.status(), context());
  std::vector<double> parameters;
  for (size_t i = 1; i < parts.size(); ++i) {
    double value = 0;
    if (!absl::SimpleAtod(parts[i], &value)) {
      return absl::InvalidArgumentError(
          absl::StrCat(context(), ": '", parts[i], "' is not a number"));
    }
    parameters.push_back(value);
  }
  absl::StatusOr<Camera> camera =
      Create(*model, width, height, parameters.data(),
             static_cast<int>(parameters.size()));
  if (!camera.ok()) return base::Annotate(camera.status(), context());
  return camera;
}

std::string Camera::ToString() const {
  const ModelEntry& entry = EntryOf(model_);
  std::string text = entry.name;
  for (int i = 0; i < entry.parameter_count; ++i) {
    absl::StrAppend(&text, ",",
                    ShortestText(parameters_[static_cast<size_t>(i)]));
  }
  return text;
}

Pixel Camera::Project(geometry::Vec3 point_in_camera) const {
  const Pixel ray = {point_in_camera.x / point_in_camera.z,
                     point_in_camera.y / point_in_camera.z};
  const Pixel distorted = has_distortion_ ? Distort(ray) : ray;
  return {fx_ * distorted.x + cx_, fy_ * distorted.y + cy_};
}

std::optional<Pixel> Camera::Unproject(Pixel pixel) const {
  const Pixel distorted = {(pixel.x - cx_) / fx_, (pixel.y - cy_) / fy_};
  return has_distortion_ ? Undistort(distorted) : distorted;
}

Pixel Camera::Distort(Pixel ray) const {
  const double* p = parameters_.data();
  switch (model_) {
    case CameraModel::kOpenCvFisheye:
    case CameraModel::kSimpleRadialFisheye:
    case CameraModel::kRadialFisheye:
      return FisheyeDistortion::Of(model_, p).Distort(ray);
    case CameraModel::kThinPrismFisheye:
      return ThinPrismDistortion::Of(p).Distort(EquidistantOfRay(ray));
    case CameraModel::kFov:
      return FovDistortion{p[4]}.Distort(ray);
    default:
      return RationalDistortion::Of(model_, p).Distort(ray);
  }
}

std::optional<Pixel> Camera::Undistort(Pixel distorted) const {
  const double* p = parameters_.data();
  switch (model_) {
    case CameraModel::kOpenCvFisheye:
    case CameraModel::kSimpleRadialFisheye:
    case CameraModel::kRadialFisheye:
      return FisheyeDistortion::Of(model_, p).Undistort(distorted);
    case CameraModel::kThinPrismFisheye: {
      const std::optional<Pixel> equidistant =
          InvertByNewton(ThinPrismDistortion::Of(p), distorted);
      return equidistant ? RayOfEquidistant(*equidistant) : std::nullopt;
    }
    case CameraModel::kFov:
      return FovDistortion{p[4]}.Undistort(distorted);
    default:
      return InvertByNewton(RationalDistortion::Of(model_, p), distorted);
  }
}

}  // namespace treeline::camera
