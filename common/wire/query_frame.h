// A frame as a client has it: encoded or not, with what is known about it.
#ifndef COMMON_WIRE_QUERY_FRAME_H_
#define COMMON_WIRE_QUERY_FRAME_H_

#include <optional>
#include <string>
#include <variant>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"
#include "common/image/orientation.h"

namespace treeline::wire {

// The bytes of an image file: JPEG or PNG for colour, 16-bit PNG for depth.
struct EncodedImage {
  std::string bytes = {};
};

// How depth pixels relate to colour pixels.
enum class DepthRegistration {
  // Straight from the depth camera that the scene was recorded with.
  kSceneCalibration,
  // Depth pixel (x, y) sees what colour pixel (x, y) sees.
  kRegisteredToColor,
  // Straight from the depth camera described in QueryDepth::geometry.
  kExplicit,
};

struct QueryDepth {
  // A DepthImage's own unit_m is not looked at: the one below counts.
  std::variant<EncodedImage, image::DepthImage> image = EncodedImage{};
  // Metres per unit of a value, in (0, 1].
  double unit_m = 0.001;
  DepthRegistration registration = DepthRegistration::kSceneCalibration;
  // The depth camera; with kExplicit only.
  struct Geometry {
    camera::Camera depth_camera;
    geometry::Rigid3 color_from_depth;
  };
  std::optional<Geometry> geometry = std::nullopt;
  // World units per measured metre, in [0.5, 2]. nullopt: 1, or the scene's
  // with kSceneCalibration, which takes no other.
  std::optional<double> depth_scale = std::nullopt;
};

struct QueryFrame {
  std::variant<EncodedImage, image::ColorImage> color = EncodedImage{};
  // nullopt: the scene's.
  std::optional<camera::Camera> camera = std::nullopt;
  std::optional<QueryDepth> depth = std::nullopt;
  // Which way up the picture is. The answer is the pose of the picture as it
  // is. Other ways are tried only if this is no certainty. nullopt: not known
  // but for what gravity or EXIF say.
  std::optional<image::Orientation> orientation = std::nullopt;
  // Where things fall, in the frame of the camera that took the picture; the
  // negative of what an accelerometer at rest reads.
  std::optional<geometry::Vec3> gravity_in_camera_mps2 = std::nullopt;
};

}  // namespace treeline::wire

#endif  // COMMON_WIRE_QUERY_FRAME_H_
