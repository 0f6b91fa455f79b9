#include "nav_agent/drivers/camera/calibration_file.h"

#include <cstdint>
#include <vector>

#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"

namespace treeline::camera_driver {
namespace {

constexpr int kMaxSide_px = 16384;

absl::StatusOr<camera::Camera> CameraOf(const yaml::YamlNode& root,
                                        absl::string_view key, int width,
                                        int height) {
  TL_ASSIGN_OR_RETURN(const std::string text, root.Text(key));
  absl::StatusOr<camera::Camera> camera =
      camera::Camera::Parse(text, width, height);
  if (camera.ok()) return camera;
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode node, root.Get(key));
  return node.Error(camera.status().message());
}

absl::StatusOr<geometry::Rigid3> ColorFromDepth(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(node.CheckKeys({"translation_m", "rotation_wxyz"}));
  TL_ASSIGN_OR_RETURN(const std::vector<double> t,
                      node.Numbers("translation_m", 3, -10, 10));
  const geometry::Vec3 translation = {t[0], t[1], t[2]};
  if (!node.Has("rotation_wxyz")) {
    return geometry::Rigid3{.rotation = {}, .translation = translation};
  }
  TL_ASSIGN_OR_RETURN(const std::vector<double> q,
                      node.Numbers("rotation_wxyz", 4, -1.01, 1.01));
  const absl::StatusOr<geometry::Rigid3> color_from_depth =
      geometry::RigidFromQuaternion(q[0], q[1], q[2], q[3], translation);
  if (color_from_depth.ok()) return color_from_depth;
  return node.Error(color_from_depth.status().message());
}

absl::StatusOr<camera::RgbdCalibration> FromYaml(const yaml::YamlNode& root) {
  TL_RETURN_IF_ERROR(root.CheckKeys({"width", "height", "color", "depth",
                                     "color_from_depth", "depth_scale"}));
  TL_ASSIGN_OR_RETURN(const int64_t width,
                      root.Integer("width", 1, kMaxSide_px));
  TL_ASSIGN_OR_RETURN(const int64_t height,
                      root.Integer("height", 1, kMaxSide_px));
  camera::RgbdCalibration calibration;
  TL_ASSIGN_OR_RETURN(calibration.color,
                      CameraOf(root, "color", static_cast<int>(width),
                               static_cast<int>(height)));
  calibration.depth = calibration.color;
  if (root.Has("depth")) {
    TL_ASSIGN_OR_RETURN(calibration.depth,
                        CameraOf(root, "depth", static_cast<int>(width),
                                 static_cast<int>(height)));
  }
  if (root.Has("color_from_depth")) {
    TL_ASSIGN_OR_RETURN(const yaml::YamlNode node,
                        root.Get("color_from_depth"));
    TL_ASSIGN_OR_RETURN(calibration.color_from_depth, ColorFromDepth(node));
  }
  TL_ASSIGN_OR_RETURN(calibration.depth_scale,
                      root.NumberOr("depth_scale", 1, 0.5, 2));
  return calibration;
}

}  // namespace

absl::StatusOr<camera::RgbdCalibration> ParseCalibration(
    absl::string_view text, absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root,
                      yaml::YamlNode::Parse(text, name));
  return FromYaml(root);
}

absl::StatusOr<camera::RgbdCalibration> ReadCalibration(
    const std::string& path) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root, yaml::YamlNode::Read(path));
  return FromYaml(root);
}

}  // namespace treeline::camera_driver
