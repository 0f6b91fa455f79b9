// SIFT features of an image, whoever found them.
#ifndef SERVER_CORE_FEATURES_SIFT_FEATURES_H_
#define SERVER_CORE_FEATURES_SIFT_FEATURES_H_

#include <cstddef>
#include <vector>

#include "common/camera/camera.h"
#include "server/core/features/sift_descriptor.h"

namespace treeline::features {

// Whose they are. Those of one kind are not to be matched with the other's.
enum class SiftKind {
  kOpenCv,  // ExtractSift
  kFast     // FastSift
};

struct SiftKeypoint {
  camera::Pixel pixel;
  float diameter_px = 0;  // of the region that the descriptor describes
  float angle_deg = 0;    // clockwise from x, in [0, 360)
  float response = 0;     // contrast; larger is stronger
};

// Keypoint i has descriptor i.
struct SiftFeatures {
  std::vector<SiftKeypoint> keypoints;
  std::vector<SiftDescriptor> descriptors;

  size_t size() const { return keypoints.size(); }
};

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SIFT_FEATURES_H_
