// How well keyframes show what a camera would see.
#ifndef SERVER_CORE_KEYFRAMES_VIEW_SUPPORT_H_
#define SERVER_CORE_KEYFRAMES_VIEW_SUPPORT_H_

#include <cstddef>
#include <vector>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::keyframes {

// Some points of every keyframe, in a frame whose z is up (the plan). Immutable
// and thread-safe.
class ViewSupport {
 public:
  // Of each direction around a place, in [0, 1]; directions are the cells of a
  // grid over azimuth and angle from up.
  using Panorama = std::vector<float>;
  // A direction inside a picture, and its share of the picture.
  struct SeenDirection {
    size_t direction = 0;
    double share = 0;
  };

  ViewSupport(const KeyframeMap& map,
              const geometry::Rotation3& plan_from_world);

  // What a camera there can count on: the sum of
  //   exp(-(1 - cos a) / kSupportAngle^2 - (ln r / ln kSupportRatio)^2 / 2)
  // over points that face it and that nothing hides, where a is the angle at
  // the point between the camera and the keyframe that has it, and r the ratio
  // of their distances to it. kFullSupport is all that a direction needs.
  Panorama PanoramaAt(geometry::Vec3 place_in_plan) const;

 private:
  struct Point {
    float x, y, z;                 // in the plan (m)
    float nx, ny, nz;              // unit normal; zero: not known
    float from_x, from_y, from_z;  // unit, from its keyframe to it
    float log_distance;            // ln of that distance (m)
  };
  std::vector<Point> points_;
};

// The directions of a panorama that are in the picture of a camera.
std::vector<ViewSupport::SeenDirection> DirectionsInPicture(
    const camera::Camera& camera, const geometry::Rotation3& plan_from_camera);

// The mean over the picture, in [0, 1]. 0 if it has no direction.
double SupportOf(const ViewSupport::Panorama& panorama,
                 const std::vector<ViewSupport::SeenDirection>& picture);

// Up to `count` points of a keyframe, evenly spread over those that it has.
std::vector<KeyframePoint> SomePoints(const KeyframeMap& map, size_t keyframe,
                                      size_t count);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_VIEW_SUPPORT_H_
