// What a model file says about itself.
#ifndef SERVER_CORE_FOREST_MODEL_INFO_H_
#define SERVER_CORE_FOREST_MODEL_INFO_H_

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/geometry/vector3.h"
#include "common/image/rolling_shutter.h"
#include "server/core/features/sift_features.h"
#include "server/core/forest/confidence_model.h"

namespace treeline::forest {

// Of a file that holds one tree of a scene whose trees are grown apart: which
// one, and what the other trees must have been grown from, too.
struct TreePartInfo {
  int tree = 0;   // in [0, trees)
  int trees = 0;  // of the whole scene, in [1, 64]
  // Of the frames' names and poses, 16 hexadecimal digits.
  std::string frames_checksum;

  friend bool operator==(const TreePartInfo&, const TreePartInfo&) = default;
};

// Provenance, calibration and summary of a trained scene.
struct ModelInfo {
  uint32_t format_version = 0;
  std::string method;            // "rgbd"
  std::string software_version;  // of the trainer
  std::string created_utc;       // "2026-11-21T09:30:00Z"
  std::string dataset;           // as given to the trainer
  uint64_t seed = 0;
  // Options of the trainer, name and value, in the order of its help.
  std::vector<std::pair<std::string, std::string>> options;
  camera::RgbdCalibration calibration;
  // Of the training frames' camera; absent where all rows are exposed at once,
  // or nothing tells (slow recordings, those without time stamps).
  std::optional<image::RollingShutter> shutter;
  // Axis-aligned box of the training points, world frame (m).
  geometry::Vec3 bounds_min_in_world;
  geometry::Vec3 bounds_max_in_world;
  // Absent in models of older versions.
  std::optional<ConfidenceModel> confidence;
  // How the keyframes' features were found. OpenCV's in models of older
  // versions.
  features::SiftKind keyframe_sift = features::SiftKind::kOpenCv;
  // Whether the world's unit of length is the metre. Where it is not (structure
  // from motion), all lengths above and in poses are in the scene's own unit.
  bool units_are_metres = true;
  // Median distance from a training camera to a point it observed (world
  // units): the scale of errors where units are arbitrary. 0: not known.
  double viewing_distance = 0;
  // Present in a part of a scene, which answers no queries: see
  // server/core/training/tree_part.h.
  std::optional<TreePartInfo> part;
  int training_frames = 0;
  int64_t training_samples = 0;
  double training_s = 0;
  int trees = 0;
  int64_t nodes = 0;
  int64_t leaves = 0;
  uint64_t file_bytes = 0;
  // What the sections of the file take in memory: more than file_bytes where
  // they are packed.
  uint64_t memory_bytes = 0;
  // Checksum of the whole file, 16 hexadecimal digits: the model's identity.
  std::string checksum;
};

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_MODEL_INFO_H_
