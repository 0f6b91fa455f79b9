// Reader of VisualSFM's .nvm models (http://ccwu.me/vsfm/doc.html#nvm).
#ifndef COMMON_DATASET_NVM_H_
#define COMMON_DATASET_NVM_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/dataset/sfm_model.h"
#include "common/geometry/rigid3.h"
#include "common/geometry/vector3.h"
#include "common/image/decode.h"

namespace treeline::dataset {

// A model as its file has it: sizes of images are not in it, and measurements
// are relative to the centre of their image, or to the principal point of
// FixedK.
struct NvmModel {
  struct Image {
    std::string name;  // with / between folders
    double focal_px = 0;
    geometry::Rigid3 camera_from_world;
    // The image is of the ray n (1 + radial |n|^2), where n is the measurement
    // over the focal length: VisualSFM's measurement distortion. Bundler's and
    // COLMAP's coefficients act the other way round, on the ray.
    double radial = 0;
  };
  struct Measurement {
    int32_t image = 0;
    int32_t point = 0;
    double x = 0;
    double y = 0;
  };
  // The shared intrinsics of FixedK (px): fx, cx, fy, cy.
  struct FixedK {
    double fx = 0, cx = 0, fy = 0, cy = 0;
  };

  std::optional<FixedK> fixed_k;
  std::vector<Image> images;
  std::vector<geometry::Vec3> points;
  std::vector<Measurement> measurements;  // in order of points
};

// Parses the first model of the file; others are parts that could not be
// joined to it, and are ignored. INVALID_ARGUMENT, with `file` and the line,
// for another version than NVM_V3, counts beyond the file's end, numbers that
// are not finite, quaternions that are not of unit length (to 1 %), focal
// lengths that are not positive, names that are there twice or lead out of the
// folder, measurements of images that do not exist. Safe on hostile input.
absl::StatusOr<NvmModel> ParseNvm(absl::string_view text,
                                  const std::string& file);

// The model with cameras and keypoints in pixels; sizes[i] is that of image i.
// Radial distortion becomes the first three terms of its inverse as a
// FULL_OPENCV camera: within 0.1 px where radial |n|^2 stays below 0.035.
// INVALID_ARGUMENT for cameras that Camera::Create refuses.
absl::StatusOr<SfmModel> ToSfmModel(const NvmModel& nvm,
                                    std::span<const image::ImageSize> sizes,
                                    const std::string& file);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_NVM_H_
