// What structure from motion knows about a scene, whoever computed it.
#ifndef COMMON_DATASET_SFM_MODEL_H_
#define COMMON_DATASET_SFM_MODEL_H_

#include <cstdint>
#include <string>
#include <vector>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"

namespace treeline::dataset {

// Photographs with their cameras, poses and observed points. The unit of
// length is arbitrary. Cameras and pixels follow our convention (the centre of
// the top left pixel is (0, 0)), not that of the files.
struct SfmModel {
  struct Keypoint {
    camera::Pixel pixel;
    int32_t point = -1;  // index into points; -1: none
  };
  struct Image {
    std::string name;    // relative to the folder of the images
    int32_t camera = 0;  // index into cameras
    geometry::Rigid3 camera_from_world;
    std::vector<Keypoint> keypoints;
  };
  struct Point {
    geometry::Vec3 position_in_world;
    int32_t track_length = 0;  // observations, in images that may be absent
  };

  std::vector<camera::Camera> cameras;
  std::vector<Image> images;  // no two of one name
  std::vector<Point> points;
};

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_SFM_MODEL_H_
