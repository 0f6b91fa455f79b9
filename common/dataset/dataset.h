// Recorded sequences with poses, behind one streaming interface.
#ifndef COMMON_DATASET_DATASET_H_
#define COMMON_DATASET_DATASET_H_

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/sfm_model.h"
#include "common/image/frame.h"
#include "common/image/rolling_shutter.h"

namespace treeline::dataset {

// What to read, from the command line. Empty strings: the format's default.
// (The braces let designated initialisers leave members out without a warning.)
struct DatasetOptions {
  // "7scenes:DIR", "12scenes:DIR" or "tum:DIR"; "colmap:MODEL_DIR,IMAGES_DIR"
  // or "nvm:FILE" (docs/explanation/structure-from-motion.md).
  std::string uri{};
  // File with one frame stem a line ('#' starts a comment). Empty: all frames.
  std::string frame_list{};
  // Replaces the sequence's own poses: lines "stem qw qx qy qz tx ty tz [f]",
  // camera_from_world of the colour camera (the pseudo ground truth format of
  // Brachmann et al. 2021). f, where given, is the colour focal length (px).
  std::string pose_file{};
  // "MODEL,p1,p2,..." (COLMAP names). color_camera wins over the pose file's
  // focal length and the cameras of a structure from motion. TUM has no depth
  // camera of its own, unless a cameras.json beside its lists says so: depth is
  // registered.
  std::string color_camera{};
  std::string depth_camera{};
  // Metres per depth unit; 0: 0.001 for 7-Scenes, 1/5000 for TUM, the
  // recording's own for 4-Scenes.
  double depth_unit_m = 0;
  // TUM: two entries less than this apart belong together (s), in (0, 1].
  double max_time_difference_s = 0.02;
};

// One frame's entry in the index: small, so that a sequence of any length
// costs memory only for its names and poses.
struct DatasetFrame {
  // "seq-01/frame-000123", TUM's colour time stamp, or the name of an image of
  // a structure from motion.
  std::string stem;
  std::string color_path;
  std::string depth_path;  // empty: the frame has no depth
  // Pose of calibration().pose_sensor; nullopt: not known at this moment.
  std::optional<geometry::Rigid3> world_from_camera;
  // The colour camera, where each frame has its own; else calibration().color.
  std::optional<camera::Camera> color_camera;
  // This frame among structure()->images; -1: none.
  int structure_image = -1;
  // How the camera turned; nullopt: not known (only TUM has time stamps).
  std::optional<image::FrameMotion> motion;
};

// An opened sequence. Immutable and thread-safe after Open.
class Dataset {
 public:
  // Reads the index, and of the first images the size. Errors name the file,
  // and the line where there is one: NOT_FOUND for missing files or stems,
  // INVALID_ARGUMENT for malformed ones, an empty frame list, poses that are
  // not rigid or have NaN, structures from motion that contradict themselves.
  static absl::StatusOr<Dataset> Open(const DatasetOptions& options);

  int size() const { return static_cast<int>(frames_.size()); }
  const DatasetFrame& frame(int i) const {
    return frames_[static_cast<size_t>(i)];
  }
  // Images of a structure from motion whose pictures are not there: of those
  // that were asked for, they alone are no frames.
  struct MissingPictures {
    int count = 0;
    std::string first;
  };
  const MissingPictures& missing_pictures() const { return missing_pictures_; }
  // The same recording with these of its frames alone.
  Dataset Subset(std::span<const int> frames) const;
  // The same recording, of whose frames Load makes AtTimeStamp's, where their
  // motion is known.
  Dataset WithShutter(const image::RollingShutter& shutter,
                      const camera::RgbdCalibration& calibration) const;
  const std::string& uri() const { return uri_; }
  // As given by the options or the format's default; color_from_depth is the
  // identity where the format leaves it unknown (7-Scenes).
  const camera::RgbdCalibration& calibration() const { return calibration_; }
  // Whether the recording itself says which cameras took it, rather than the
  // format's default or the options alone.
  bool states_its_cameras() const { return states_its_cameras_; }
  // Whether depth pixel (x, y) already sees what colour pixel (x, y) sees
  // (TUM without cameras.json); false for 7-Scenes.
  bool depth_is_registered() const { return depth_is_registered_; }
  // Metres per unit of the depth files.
  double depth_unit_m() const { return depth_unit_m_; }

  // Whether the world's unit of length is the metre; what structure from
  // motion finds has none.
  bool units_are_metres() const { return units_are_metres_; }
  // The structure that the frames belong to; null but for colmap: and nvm:.
  const SfmModel* structure() const { return structure_.get(); }

  // The encoded files of frame i: what a client would send.
  struct Encoded {
    std::string color;
    std::string depth;                           // empty: none
    std::optional<camera::Camera> color_camera;  // DatasetFrame::color_camera
  };
  absl::StatusOr<Encoded> ReadEncoded(int i) const;

  // Reads and decodes frame i. Its Frame::calibration is left empty unless
  // the frame has a camera of its own.
  // INVALID_ARGUMENT, with the file, for images that do not decode or whose
  // size is not that of the calibration.
  absl::StatusOr<image::Frame> Load(int i) const;
  absl::StatusOr<image::Frame> Decode(const Encoded& encoded) const;

 private:
  // A rolling shutter that is undone, and with which cameras.
  struct UndoneShutter {
    image::RollingShutter shutter;
    camera::RgbdCalibration calibration;
  };
  std::optional<camera::RgbdCalibration> CalibrationOf(
      const Encoded& encoded) const;

  std::string uri_;
  std::vector<DatasetFrame> frames_;
  MissingPictures missing_pictures_;
  camera::RgbdCalibration calibration_;
  bool states_its_cameras_ = false;
  bool depth_is_registered_ = false;
  double depth_unit_m_ = 0.001;
  bool units_are_metres_ = true;
  std::shared_ptr<const SfmModel> structure_;
  std::optional<UndoneShutter> undone_shutter_;
};

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_DATASET_H_
