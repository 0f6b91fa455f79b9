// A picture's features and the map's landmarks: which are the same.
#ifndef NAV_AGENT_RGBD_SLAM_FEATURE_MATCHING_H_
#define NAV_AGENT_RGBD_SLAM_FEATURE_MATCHING_H_

#include <span>
#include <vector>

#include "nav_agent/rgbd_slam/slam_map.h"

namespace treeline::rgbd_slam {

// Where a landmark should be seen, if the camera has it in view at a scale and
// from a side that it can be known from.
struct ExpectedSighting {
  camera::Pixel pixel;
  double depth_m = 0;
  int octave = 0;
};
bool Expect(const Landmark& landmark, const Pinhole& pinhole,
            const FeatureSet& features, const geometry::Rigid3& camera_from_map,
            geometry::Vec3 camera_in_map, ExpectedSighting* expected);

struct FeatureMatch {
  int feature = 0;
  int landmark = 0;
};

struct ProjectionSearch {
  // At octave 0; grows with the scale.
  double radius_px = 8;
  int max_distance = 80;
  // The best must be this much better than the second of the same octave.
  double ratio = 0.85;
};

// Landmarks found where they should be, each feature and landmark once.
// Counts what is visible in `visible` (landmark indices), if not null.
std::vector<FeatureMatch> MatchByProjection(
    const SlamMap& map, std::span<const int> landmarks,
    const FeatureSet& features, const geometry::Rigid3& camera_from_map,
    const ProjectionSearch& search, std::vector<int>* visible);

// Features of a picture and landmarks of a keyframe with like descriptors,
// wherever they are.
std::vector<FeatureMatch> MatchByDescriptor(const SlamMap& map, int keyframe,
                                            const FeatureSet& features);

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_FEATURE_MATCHING_H_
