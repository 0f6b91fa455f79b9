// Puts the parts of a COLMAP model together; its readers' common half.
#ifndef COMMON_DATASET_COLMAP_BUILDER_H_
#define COMMON_DATASET_COLMAP_BUILDER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/dataset/colmap.h"

namespace treeline::dataset {

// A line of a text file, or a byte of a binary one.
struct ColmapPlace {
  const ColmapFile* file;
  uint64_t at = 0;

  // INVALID_ARGUMENT, "FILE:LINE: what" or "FILE: byte N: what".
  absl::Status Error(absl::string_view what) const;
};

// Records in COLMAP's terms, checked as they come. Cameras and points have to
// be added before images.
class ColmapBuilder {
 public:
  struct Observation {
    double x = 0;
    double y = 0;
    uint64_t point_id = 0;
  };
  struct TrackElement {
    uint32_t image_id = 0;
    uint32_t keypoint = 0;
  };
  static constexpr uint64_t kNoPoint = ~uint64_t{0};

  // `camera`: every image's, whatever its camera id. has_points: whether
  // there is a points file; if not, point ids mean nothing.
  ColmapBuilder(const std::optional<camera::Camera>& camera, bool has_points);

  absl::Status AddCamera(const ColmapPlace& place, uint32_t id,
                         camera::CameraModel model, uint64_t width,
                         uint64_t height, std::span<const double> parameters);
  absl::Status AddPoint(const ColmapPlace& place, uint64_t id,
                        geometry::Vec3 position,
                        std::span<const TrackElement> track);
  // pose: qw qx qy qz tx ty tz, camera_from_world.
  absl::Status AddImage(const ColmapPlace& place, uint32_t id,
                        std::span<const double, 7> pose, uint32_t camera_id,
                        absl::string_view name,
                        std::span<const Observation> observations);
  // Checks the tracks against the images.
  absl::StatusOr<SfmModel> Finish();

 private:
  struct Track {
    ColmapPlace place;
    std::vector<TrackElement> elements;
  };

  SfmModel model_;
  const bool one_camera_;
  const bool has_points_;
  std::unordered_map<uint32_t, int32_t> camera_of_id_;
  std::unordered_map<uint64_t, int32_t> point_of_id_;
  std::unordered_map<uint32_t, int32_t> image_of_id_;
  std::unordered_map<std::string, uint32_t> id_of_name_;
  std::vector<Track> tracks_;  // one a point
};

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_COLMAP_BUILDER_H_
