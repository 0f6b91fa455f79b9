// For tests: a recording of the inside of a patterned box, by arithmetic.
#ifndef SERVER_CORE_TRAINING_BOX_ROOM_RECORDING_H_
#define SERVER_CORE_TRAINING_BOX_ROOM_RECORDING_H_

#include <string>
#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"

namespace treeline::training {

// Small pinhole cameras: 200 x 150 pixels, 145 px focal length.
camera::RgbdCalibration BoxRoomCalibration();

// What is painted on the walls: a smooth random pattern, or tiles of 60 cm,
// each lighter or darker than the pattern.
enum class BoxRoomWalls { kSmooth, kTiled };

// What an RGB-D pair with `calibration` sees at a pose of its pose sensor in a
// 4 x 3 x 2.5 m room whose middle is the world's origin. Depth is in
// millimetres, exact but for rounding.
image::Frame RenderBoxRoom(const camera::RgbdCalibration& calibration,
                           const geometry::Rigid3& world_from_sensor,
                           BoxRoomWalls walls = BoxRoomWalls::kSmooth);

// `count` poses along a loop that looks at all walls.
std::vector<geometry::Rigid3> BoxRoomPoses(int count);

// Writes DIR/seq-01/frame-000000.* and so on in 7-Scenes layout. Poses are of
// calibration.pose_sensor: in .pose.txt files for the depth camera, in
// DIR/poses.txt (camera from world) for the colour camera.
void WriteBoxRoomRecording(
    const std::string& folder, const camera::RgbdCalibration& calibration,
    const std::vector<geometry::Rigid3>& world_from_sensor,
    BoxRoomWalls walls = BoxRoomWalls::kSmooth);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_BOX_ROOM_RECORDING_H_
