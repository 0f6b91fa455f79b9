// What a query may look like that was not taken as the scene was recorded: one
// small function a change of the picture, its depth or its calibration.
//
// Colour, depth and calibration change together, so that what a frame says of
// itself stays true (but for WrongFocalLength, DepthScaled, DepthOffset and
// DepthNoise, whose point is that it does not). A draw depends on `random`
// alone. Sizes in pixels are of the picture as it comes.
#ifndef EVALUATION_ACCURACY_PERTURBATION_EFFECTS_H_
#define EVALUATION_ACCURACY_PERTURBATION_EFFECTS_H_

#include "absl/status/status.h"
#include "common/base/random.h"
#include "common/geometry/rigid3.h"
#include "common/image/frame.h"

namespace treeline::accuracy {

// A frame on its way through perturbations.
struct PerturbedFrame {
  image::Frame frame;  // with its calibration
  // How the axes of either camera have turned about its optical axis:
  //   world_from_turned = world_from_sensor * turned_from_sensor.Inverse().
  geometry::Rigid3 turned_from_sensor;
};

// Light. Values are what the picture has, as its sRGB bytes.
// Mixed with its luma: 0 as it is, 1 grey.
absl::Status Grey(double share, base::Random& random, PerturbedFrame& view);
// Red times 1 + by, blue times 1 - by.
absl::Status WhiteBalance(double by, base::Random& random,
                          PerturbedFrame& view);
// 255 * (value / 255)^gamma: below 1 brighter.
absl::Status Gamma(double gamma, base::Random& random, PerturbedFrame& view);
// Times a factor; bright values saturate.
absl::Status Exposure(double factor, base::Random& random,
                      PerturbedFrame& view);
// A warm lamp on one side: 2^stops times as bright there and 2^-stops times at
// the other end, red more so and blue less.
absl::Status Light(double stops, base::Random& random, PerturbedFrame& view);

// Sharpness.
// Motion along a line of so many pixels, in a drawn direction.
absl::Status MotionBlur(double length_px, base::Random& random,
                        PerturbedFrame& view);
// A Gaussian of this standard deviation (px).
absl::Status Defocus(double sigma_px, base::Random& random,
                     PerturbedFrame& view);
// Gaussian, of this standard deviation (of 255), apart in each channel.
absl::Status Noise(double sigma, base::Random& random, PerturbedFrame& view);
absl::Status Jpeg(double quality, base::Random& random, PerturbedFrame& view);

// What is seen.
// A plain thing of one colour before a share of the picture: a rectangle of the
// picture's shape at a drawn place. It is 0.5 to 1 m away in every other frame
// and too near for the depth camera in the rest.
absl::Status Cover(double share, base::Random& random, PerturbedFrame& view);
// A window of this share of each side, at a drawn place, the same of colour and
// of depth.
absl::Status Crop(double side, base::Random& random, PerturbedFrame& view);
// Both pictures resized by this factor.
absl::Status Scale(double factor, base::Random& random, PerturbedFrame& view);
// Another lens: radial distortion k (OpenCV's k1) of the colour camera, its
// focal length such that the corners show what they showed.
absl::Status Distort(double k, base::Random& random, PerturbedFrame& view);
// The stated focal length is this factor of the true one, also that of depth
// which is registered to colour.
absl::Status WrongFocalLength(double factor, base::Random& random,
                              PerturbedFrame& view);
// No camera is stated: a pinhole with its centre in the middle is assumed,
// whose focal length is this factor of the true one.
absl::Status AssumedLens(double factor, base::Random& random,
                         PerturbedFrame& view);
// Such a pinhole is stated, as by who knows no better.
absl::Status GuessedLens(double factor, base::Random& random,
                         PerturbedFrame& view);

// Orientation.
// Both cameras clockwise about their optical axes, by a multiple of 90 degrees.
absl::Status Rotate(double degrees, base::Random& random, PerturbedFrame& view);
// The same by any angle; what comes in at the corners is black and without
// depth.
absl::Status Roll(double degrees, base::Random& random, PerturbedFrame& view);
// Left and right exchanged: a place that does not exist.
absl::Status Mirror(double unused, base::Random& random, PerturbedFrame& view);

// Depth; nothing happens to a frame without it.
// Cells of 24 pixels are not measured, each with this probability.
absl::Status DepthHoles(double share, base::Random& random,
                        PerturbedFrame& view);
// Gaussian, of standard deviation sigma * depth^2 (m, sigma in 1/m).
absl::Status DepthNoise(double sigma, base::Random& random,
                        PerturbedFrame& view);
absl::Status DepthScaled(double factor, base::Random& random,
                         PerturbedFrame& view);
// All that is measured is further away by this (m).
absl::Status DepthOffset(double offset_m, base::Random& random,
                         PerturbedFrame& view);
absl::Status NoDepth(double unused, base::Random& random, PerturbedFrame& view);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_PERTURBATION_EFFECTS_H_
