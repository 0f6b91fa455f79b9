// Pictures turned by quarters, with the cameras that took them: every pixel of
// a turned frame sees what it saw before.
//
// A turned picture is what a camera would take that is turned about its optical
// axis the other way. Its frame is named `turned`; x and y of both lie in one
// plane, and
//   world_from_camera = world_from_turned * turned_from_camera.
#ifndef COMMON_IMAGE_QUARTER_TURN_H_
#define COMMON_IMAGE_QUARTER_TURN_H_

#include "common/camera/camera.h"
#include "common/camera/rgbd_calibration.h"
#include "common/geometry/rigid3.h"
#include "common/image/frame.h"
#include "common/image/image.h"
#include "common/image/orientation.h"

namespace treeline::image {

// Clockwise, x of the camera becomes y of the turned one, and y becomes -x.
geometry::Rotation3 TurnedFromCamera(QuarterTurn turn);

// Where a pixel of an image of width x height comes to lie.
camera::Pixel Turned(camera::Pixel pixel, int width, int height,
                     QuarterTurn turn);

ColorImage Turned(const ColorImage& image, QuarterTurn turn);
DepthImage Turned(const DepthImage& image, QuarterTurn turn);

// With Project(p) == Turned(camera.Project(q)) for p = TurnedFromCamera(turn)
// * q, whatever the model and its distortion.
camera::Camera Turned(const camera::Camera& camera, QuarterTurn turn);

// Of a pair whose pictures are both turned.
camera::RgbdCalibration Turned(const camera::RgbdCalibration& calibration,
                               QuarterTurn turn);

// Colour and depth, and the calibration and orientation of the frame.
Frame Turned(const Frame& frame, QuarterTurn turn);

}  // namespace treeline::image

#endif  // COMMON_IMAGE_QUARTER_TURN_H_
