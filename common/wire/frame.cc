#include "common/wire/frame.h"

#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/camera/assumed_camera.h"
#include "common/image/exif.h"
#include "common/wire/camera.h"
#include "common/wire/geometry.h"

namespace treeline::wire {
namespace {

constexpr double kMaxDepthUnit_m = 1.0;
// Of a sensor in free fall there is no direction.
constexpr double kMinGravity_mps2 = 1e-3;

v1::DepthRegistration RegistrationToProto(DepthRegistration registration) {
  switch (registration) {
    case DepthRegistration::kSceneCalibration:
      return v1::DEPTH_REGISTRATION_SCENE_CALIBRATION;
    case DepthRegistration::kRegisteredToColor:
      return v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR;
    case DepthRegistration::kExplicit:
      return v1::DEPTH_REGISTRATION_EXPLICIT;
  }
  return v1::DEPTH_REGISTRATION_UNSPECIFIED;
}

v1::Orientation OrientationToProto(image::QuarterTurn upright_turn) {
  switch (upright_turn) {
    case image::QuarterTurn::kNone:
      return v1::ORIENTATION_TOP_UP;
    case image::QuarterTurn::kClockwise:
      return v1::ORIENTATION_LEFT_UP;
    case image::QuarterTurn::kHalf:
      return v1::ORIENTATION_BOTTOM_UP;
    case image::QuarterTurn::kCounterclockwise:
      return v1::ORIENTATION_RIGHT_UP;
  }
  return v1::ORIENTATION_UNSPECIFIED;
}

// nullopt: not stated.
absl::StatusOr<std::optional<image::QuarterTurn>> UprightTurnFrom(
    v1::Orientation proto, absl::string_view field) {
  if (proto == v1::ORIENTATION_UNSPECIFIED) return std::nullopt;
  for (const image::QuarterTurn turn : image::kQuarterTurns) {
    if (OrientationToProto(turn) == proto) return turn;
  }
  return FieldError(field,
                    absl::StrCat(static_cast<int>(proto), " is no side"));
}

// What is stated, else what gravity says, else a guess: stated, or EXIF's.
absl::StatusOr<image::Orientation> OrientationFrom(const v1::Frame& proto,
                                                   absl::string_view field) {
  TL_ASSIGN_OR_RETURN(const std::optional<image::QuarterTurn> stated,
                      UprightTurnFrom(proto.orientation(),
                                      absl::StrCat(field, ".orientation")));
  std::optional<image::Orientation> measured;
  if (proto.has_gravity_in_camera_mps2()) {
    const std::string name = absl::StrCat(field, ".gravity_in_camera_mps2");
    TL_ASSIGN_OR_RETURN(const geometry::Vec3 gravity,
                        FromProto(proto.gravity_in_camera_mps2(), name));
    const double norm = geometry::Norm(gravity);
    if (!(norm >= kMinGravity_mps2) || !std::isfinite(norm)) {
      return FieldError(name, absl::StrCat("has the length ", norm,
                                           ", which is no direction"));
    }
    measured = image::OrientationFromGravity(gravity);
  }
  if (stated && !proto.orientation_is_guess()) {
    return image::Orientation{*stated, /*is_certain=*/true};
  }
  if (measured) return *measured;
  const std::optional<image::QuarterTurn> guess =
      stated ? stated : image::ReadExifUprightTurn(proto.color().encoded());
  return image::Orientation{guess.value_or(image::QuarterTurn::kNone),
                            /*is_certain=*/false};
}

void FillColor(const QueryFrame& frame, v1::ColorImage& proto) {
  if (const auto* encoded = std::get_if<EncodedImage>(&frame.color)) {
    proto.set_encoded(encoded->bytes);
    return;
  }
  const image::ColorImage& image = std::get<image::ColorImage>(frame.color);
  v1::Rgb8Image& raw = *proto.mutable_rgb8();
  raw.set_width_px(image.width);
  raw.set_height_px(image.height);
  raw.mutable_data()->assign(image.rgb.begin(), image.rgb.end());
}

void FillDepth(const QueryDepth& depth, v1::DepthImage& proto) {
  if (const auto* encoded = std::get_if<EncodedImage>(&depth.image)) {
    proto.set_png(encoded->bytes);
  } else {
    const image::DepthImage& image = std::get<image::DepthImage>(depth.image);
    v1::Uint16Image& raw = *proto.mutable_raw();
    raw.set_width_px(image.width);
    raw.set_height_px(image.height);
    std::string& data = *raw.mutable_data();
    data.resize(2 * image.values.size());
    for (size_t i = 0; i < image.values.size(); ++i) {
      data[2 * i] = static_cast<char>(image.values[i] & 0xff);
      data[2 * i + 1] = static_cast<char>(image.values[i] >> 8);
    }
  }
  proto.set_unit_m(depth.unit_m);
  proto.set_registration(RegistrationToProto(depth.registration));
  if (depth.geometry) {
    *proto.mutable_calibration()->mutable_depth_camera() =
        ToProto(depth.geometry->depth_camera);
    *proto.mutable_calibration()->mutable_color_from_depth() =
        ToProto(depth.geometry->color_from_depth);
  }
  if (depth.depth_scale) proto.set_depth_scale(*depth.depth_scale);
}

// The size and length of an image without encoding.
template <typename RawImage>
absl::Status CheckRawImage(const RawImage& raw, int bytes_per_pixel,
                           const image::DecodeLimits& limits,
                           absl::string_view field) {
  const int64_t width = raw.width_px();
  const int64_t height = raw.height_px();
  if (width < 1 || height < 1) {
    return FieldError(field,
                      absl::StrCat("has no pixels: ", width, " x ", height));
  }
  if (width > limits.max_width || height > limits.max_height ||
      width > limits.max_pixels / height) {
    return FieldError(
        field,
        absl::StrCat(width, " x ", height, " pixels is over the limit of ",
                     limits.max_width, " x ", limits.max_height, " and ",
                     limits.max_pixels, " pixels"));
  }
  const int64_t expected = width * height * bytes_per_pixel;
  if (static_cast<int64_t>(raw.data().size()) != expected) {
    return FieldError(
        absl::StrCat(field, ".data"),
        absl::StrCat(raw.data().size(), " bytes; ", width, " x ", height,
                     " pixels of ", bytes_per_pixel, " bytes are ", expected));
  }
  return absl::OkStatus();
}

absl::StatusOr<image::ColorImage> DecodeColorField(
    const v1::ColorImage& proto, const image::DecodeLimits& limits,
    absl::string_view field) {
  switch (proto.data_case()) {
    case v1::ColorImage::kEncoded: {
      absl::StatusOr<image::ColorImage> image =
          image::DecodeColor(proto.encoded(), limits);
      if (!image.ok()) {
        return base::Annotate(image.status(), absl::StrCat(field, ".encoded"));
      }
      return image;
    }
    case v1::ColorImage::kRgb8: {
      const v1::Rgb8Image& raw = proto.rgb8();
      TL_RETURN_IF_ERROR(
          CheckRawImage(raw, 3, limits, absl::StrCat(field, ".rgb8")));
      image::ColorImage image{
          .width = raw.width_px(), .height = raw.height_px(), .rgb = {}};
      image.rgb.assign(raw.data().begin(), raw.data().end());
      return image;
    }
    default:
      return FieldError(field, "missing; send `encoded` or `rgb8`");
  }
}

absl::StatusOr<image::DepthImage> DecodeDepthField(
    const v1::DepthImage& proto, const image::DecodeLimits& limits,
    absl::string_view field) {
  switch (proto.data_case()) {
    case v1::DepthImage::kPng: {
      absl::StatusOr<image::DepthImage> image =
          image::DecodeDepthPng(proto.png(), proto.unit_m(), limits);
      if (!image.ok()) {
        return base::Annotate(image.status(), absl::StrCat(field, ".png"));
      }
      return image;
    }
    case v1::DepthImage::kRaw: {
      const v1::Uint16Image& raw = proto.raw();
      TL_RETURN_IF_ERROR(
          CheckRawImage(raw, 2, limits, absl::StrCat(field, ".raw")));
      image::DepthImage image{.width = raw.width_px(),
                              .height = raw.height_px(),
                              .values = {},
                              .unit_m = proto.unit_m()};
      image.values.resize(raw.data().size() / 2);
      const auto* bytes =
          reinterpret_cast<const unsigned char*>(raw.data().data());
      for (size_t i = 0; i < image.values.size(); ++i) {
        image.values[i] =
            static_cast<uint16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
      }
      return image;
    }
    default:
      return FieldError(field, "has no image; send `png` or `raw`");
  }
}

// What does not need the pixels: unit, registration, and what goes with it.
absl::Status CheckDepthStatement(const v1::DepthImage& proto,
                                 absl::string_view field) {
  // Written so that NaN fails.
  if (!(proto.unit_m() > 0 && proto.unit_m() <= kMaxDepthUnit_m)) {
    return FieldError(
        absl::StrCat(field, ".unit_m"),
        absl::StrCat("metres per unit must be given and lie in (0, 1], not ",
                     proto.unit_m(), "; 0.001 for millimetres"));
  }
  const v1::DepthRegistration registration = proto.registration();
  const bool is_explicit = registration == v1::DEPTH_REGISTRATION_EXPLICIT;
  if (!is_explicit &&
      registration != v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR &&
      registration != v1::DEPTH_REGISTRATION_SCENE_CALIBRATION) {
    return FieldError(absl::StrCat(field, ".registration"),
                      "must state how depth relates to colour: "
                      "REGISTERED_TO_COLOR, SCENE_CALIBRATION or EXPLICIT");
  }
  if (is_explicit != proto.has_calibration()) {
    return FieldError(absl::StrCat(field, ".calibration"),
                      is_explicit ? "missing; EXPLICIT registration needs it"
                                  : "goes with EXPLICIT registration only");
  }
  if (!proto.has_depth_scale()) return absl::OkStatus();
  if (registration == v1::DEPTH_REGISTRATION_SCENE_CALIBRATION) {
    return FieldError(absl::StrCat(field, ".depth_scale"),
                      "SCENE_CALIBRATION uses the scene's; leave it away");
  }
  return CheckDepthScale(proto.depth_scale(),
                         absl::StrCat(field, ".depth_scale"));
}

// The table in the header. The cameras are checked; images are not looked at.
absl::StatusOr<std::optional<camera::RgbdCalibration>> ResolveCalibration(
    const v1::Frame& proto, const camera::RgbdCalibration& scene,
    absl::string_view field) {
  camera::RgbdCalibration merged = scene;
  if (proto.has_camera()) {
    TL_ASSIGN_OR_RETURN(
        merged.color,
        FromProto(proto.camera(), absl::StrCat(field, ".camera")));
  }
  const v1::DepthRegistration registration =
      proto.has_depth() ? proto.depth().registration()
                        : v1::DEPTH_REGISTRATION_SCENE_CALIBRATION;
  if (registration == v1::DEPTH_REGISTRATION_SCENE_CALIBRATION) {
    if (!proto.has_camera()) return std::nullopt;
    return merged;
  }
  merged.depth_scale =
      proto.depth().has_depth_scale() ? proto.depth().depth_scale() : 1;
  if (registration == v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR) {
    merged.depth = merged.color;
    merged.color_from_depth = geometry::Rigid3{};
    return merged;
  }
  const v1::DepthCalibration& calibration = proto.depth().calibration();
  const std::string prefix = absl::StrCat(field, ".depth.calibration");
  TL_ASSIGN_OR_RETURN(merged.depth,
                      FromProto(calibration.depth_camera(),
                                absl::StrCat(prefix, ".depth_camera")));
  TL_ASSIGN_OR_RETURN(merged.color_from_depth,
                      FromProto(calibration.color_from_depth(),
                                absl::StrCat(prefix, ".color_from_depth")));
  return merged;
}

std::string SizeText(int width, int height) {
  return absl::StrCat(width, " x ", height);
}

bool HasSizeOf(const image::ColorImage& image, const camera::Camera& camera) {
  return image.width == camera.width() && image.height == camera.height();
}

absl::Status CheckColorSize(const image::ColorImage& image,
                            const camera::Camera& camera, bool camera_given,
                            absl::string_view field) {
  if (HasSizeOf(image, camera)) return absl::OkStatus();
  const std::string image_size = SizeText(image.width, image.height);
  const std::string camera_size = SizeText(camera.width(), camera.height());
  if (camera_given) {
    return FieldError(
        absl::StrCat(field, ".camera"),
        absl::StrCat("is for ", camera_size, " pixels, the image has ",
                     image_size, "; send the intrinsics of this image"));
  }
  return FieldError(
      absl::StrCat(field, ".camera"),
      absl::StrCat("missing, and the image of ", image_size,
                   " pixels is not from the scene's camera of ", camera_size,
                   "; with depth, send the intrinsics of the image"));
}

absl::Status CheckDepthSize(const image::DepthImage& image,
                            const camera::Camera& camera,
                            absl::string_view field) {
  if (image.width == camera.width() && image.height == camera.height()) {
    return absl::OkStatus();
  }
  return FieldError(
      absl::StrCat(field, ".depth"),
      absl::StrCat("the image has ", SizeText(image.width, image.height),
                   " pixels, the depth camera ",
                   SizeText(camera.width(), camera.height())));
}

camera::RgbdCalibration WithColor(camera::RgbdCalibration calibration,
                                  const camera::Camera& color) {
  calibration.color = color;
  return calibration;
}

// All that can be checked before decoding and without a scene.
absl::Status CheckStatements(const v1::Frame& proto, absl::string_view field) {
  TL_RETURN_IF_ERROR(OrientationFrom(proto, field).status());
  if (!proto.has_depth()) return absl::OkStatus();
  return CheckDepthStatement(proto.depth(), absl::StrCat(field, ".depth"));
}

absl::Status DecodeColorOf(const v1::Frame& proto,
                           const image::DecodeLimits& limits,
                           absl::string_view field, image::Frame& frame) {
  TL_ASSIGN_OR_RETURN(
      frame.color,
      DecodeColorField(proto.color(), limits, absl::StrCat(field, ".color")));
  TL_ASSIGN_OR_RETURN(frame.orientation, OrientationFrom(proto, field));
  return absl::OkStatus();
}

absl::Status DecodeDepthOf(const v1::Frame& proto,
                           const image::DecodeLimits& limits,
                           absl::string_view field, image::Frame& frame) {
  if (!proto.has_depth()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(
      frame.depth,
      DecodeDepthField(proto.depth(), limits, absl::StrCat(field, ".depth")));
  return absl::OkStatus();
}

}  // namespace

v1::Frame ToProto(const QueryFrame& frame) {
  v1::Frame proto;
  FillColor(frame, *proto.mutable_color());
  if (frame.camera) *proto.mutable_camera() = ToProto(*frame.camera);
  if (frame.depth) FillDepth(*frame.depth, *proto.mutable_depth());
  if (frame.orientation) {
    proto.set_orientation(OrientationToProto(frame.orientation->upright_turn));
    proto.set_orientation_is_guess(!frame.orientation->is_certain);
  }
  if (frame.gravity_in_camera_mps2) {
    *proto.mutable_gravity_in_camera_mps2() =
        ToProto(*frame.gravity_in_camera_mps2);
  }
  return proto;
}

std::optional<camera::Camera> AssumedCamera(
    const v1::Frame& proto, const image::Frame& pixels,
    const camera::RgbdCalibration& scene_calibration) {
  const camera::Camera& scene = scene_calibration.color;
  if (proto.has_camera() || proto.has_depth()) return std::nullopt;
  const std::optional<double> focal_35mm =
      image::ReadExifFocal35_mm(proto.color().encoded());
  if (HasSizeOf(pixels.color, scene) &&
      !camera::IsOfAnotherLens(focal_35mm, scene)) {
    return std::nullopt;
  }
  return camera::AssumedCamera(pixels.color.width, pixels.color.height,
                               focal_35mm, scene);
}

absl::StatusOr<image::Frame> FromProto(
    const v1::Frame& proto, const camera::RgbdCalibration& scene_calibration,
    const image::DecodeLimits& limits, absl::string_view field) {
  TL_RETURN_IF_ERROR(CheckStatements(proto, field));
  TL_ASSIGN_OR_RETURN(std::optional<camera::RgbdCalibration> calibration,
                      ResolveCalibration(proto, scene_calibration, field));
  image::Frame frame;
  TL_RETURN_IF_ERROR(DecodeColorOf(proto, limits, field, frame));
  if (const auto assumed = AssumedCamera(proto, frame, scene_calibration)) {
    frame.is_camera_assumed = true;
    calibration = WithColor(scene_calibration, *assumed);
  }
  const camera::RgbdCalibration& cameras =
      calibration ? *calibration : scene_calibration;
  TL_RETURN_IF_ERROR(
      CheckColorSize(frame.color, cameras.color, proto.has_camera(), field));
  TL_RETURN_IF_ERROR(DecodeDepthOf(proto, limits, field, frame));
  if (frame.depth) {
    TL_RETURN_IF_ERROR(CheckDepthSize(*frame.depth, cameras.depth, field));
  }
  frame.calibration = std::move(calibration);
  return frame;
}

absl::StatusOr<image::Frame> PixelsFromProto(const v1::Frame& proto,
                                             const image::DecodeLimits& limits,
                                             absl::string_view field) {
  TL_RETURN_IF_ERROR(CheckStatements(proto, field));
  image::Frame frame;
  TL_RETURN_IF_ERROR(DecodeColorOf(proto, limits, field, frame));
  TL_RETURN_IF_ERROR(DecodeDepthOf(proto, limits, field, frame));
  return frame;
}

absl::StatusOr<std::optional<camera::RgbdCalibration>> CalibrationFromProto(
    const v1::Frame& proto, const image::Frame& pixels,
    const camera::RgbdCalibration& scene_calibration, absl::string_view field) {
  TL_RETURN_IF_ERROR(CheckStatements(proto, field));
  if (const auto assumed = AssumedCamera(proto, pixels, scene_calibration)) {
    return WithColor(scene_calibration, *assumed);
  }
  TL_ASSIGN_OR_RETURN(std::optional<camera::RgbdCalibration> calibration,
                      ResolveCalibration(proto, scene_calibration, field));
  const camera::RgbdCalibration& cameras =
      calibration ? *calibration : scene_calibration;
  TL_RETURN_IF_ERROR(
      CheckColorSize(pixels.color, cameras.color, proto.has_camera(), field));
  if (pixels.depth) {
    TL_RETURN_IF_ERROR(CheckDepthSize(*pixels.depth, cameras.depth, field));
  }
  return calibration;
}

}  // namespace treeline::wire
