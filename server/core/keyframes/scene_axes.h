// Which way is up in a scene, and how a plan of it lies.
#ifndef SERVER_CORE_KEYFRAMES_SCENE_AXES_H_
#define SERVER_CORE_KEYFRAMES_SCENE_AXES_H_

#include "common/geometry/rigid3.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::keyframes {

// The rotation from the world to a plan of the scene: z up, x to the right and
// y away on a sheet of paper. The plan has the world's origin and unit.
//
// A model does not say which way is up. Up is first the mean of where the
// cameras' pictures have their upper edge, and then the mean normal of the
// surfaces near it: floors and tables. An axis of the world that is close is
// up itself. If that is the world's z, the plan has its x and y, too; else it
// is turned so that most walls are parallel to its edges.
//
// Wrong if most of the recording was taken with the camera on its side.
geometry::Rotation3 PlanFromWorld(const KeyframeMap& map);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_SCENE_AXES_H_
