#include "common/image/quarter_turn.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace treeline::image {
namespace {

bool SwapsSides(QuarterTurn turn) {
  return turn == QuarterTurn::kClockwise ||
         turn == QuarterTurn::kCounterclockwise;
}

// Where pixel (x, y) of an image goes: first + x * step_x + y * step_y, rows
// of the turned image one after the other.
struct PixelOrder {
  std::ptrdiff_t first = 0;
  std::ptrdiff_t step_x = 1;
  std::ptrdiff_t step_y = 1;
};

PixelOrder OrderOf(std::ptrdiff_t width, std::ptrdiff_t height,
                   QuarterTurn turn) {
  switch (turn) {
    case QuarterTurn::kClockwise:
      return {height - 1, height, -1};
    case QuarterTurn::kHalf:
      return {width * height - 1, -1, -width};
    case QuarterTurn::kCounterclockwise:
      return {(width - 1) * height, -height, 1};
    case QuarterTurn::kNone:
      break;
  }
  return {0, 1, width};
}

template <int kChannels, typename T>
std::vector<T> TurnedValues(const std::vector<T>& values, int width, int height,
                            QuarterTurn turn) {
  const PixelOrder order = OrderOf(width, height, turn);
  std::vector<T> turned(values.size());
  const T* in = values.data();
  for (std::ptrdiff_t y = 0; y < height; ++y) {
    for (std::ptrdiff_t x = 0; x < width; ++x) {
      T* const out =
          turned.data() +
          kChannels * (order.first + x * order.step_x + y * order.step_y);
      for (int c = 0; c < kChannels; ++c) out[c] = *in++;
    }
  }
  return turned;
}

// The image of a camera whose picture is turned once, clockwise.
camera::Camera TurnedClockwise(const camera::Camera& camera) {
  using camera::CameraModel;
  const CameraModel model = camera.model();
  auto parameters = camera.parameters();
  const int cx = camera::CameraPrincipalPointIndex(model);
  if (cx == 2) std::swap(parameters[0], parameters[1]);
  const auto at = static_cast<size_t>(cx);
  parameters[at] = camera.height() - 1 - camera.cy();
  parameters[at + 1] = camera.cx();
  // What bends rays along one direction is a vector in the image, (p2, p1) and
  // (sx1, sy1), and turns with it; all else is the same in every direction.
  if (model == CameraModel::kOpenCv || model == CameraModel::kFullOpenCv ||
      model == CameraModel::kThinPrismFisheye) {
    parameters[6] = std::exchange(parameters[7], -parameters[6]);
  }
  if (model == CameraModel::kThinPrismFisheye) {
    parameters[11] = std::exchange(parameters[10], -parameters[11]);
  }
  // Never refused: the parameters are those of a camera in another order.
  return camera::Camera::Create(model, camera.height(), camera.width(),
                                parameters.data(),
                                camera::CameraParameterCount(model))
      .value();
}

}  // namespace

geometry::Rotation3 TurnedFromCamera(QuarterTurn turn) {
  const double half_sqrt = std::sqrt(0.5);
  switch (turn) {
    case QuarterTurn::kClockwise:
      return {half_sqrt, 0, 0, half_sqrt};
    case QuarterTurn::kHalf:
      return {0, 0, 0, 1};
    case QuarterTurn::kCounterclockwise:
      return {half_sqrt, 0, 0, -half_sqrt};
    case QuarterTurn::kNone:
      break;
  }
  return {};
}

camera::Pixel Turned(camera::Pixel pixel, int width, int height,
                     QuarterTurn turn) {
  switch (turn) {
    case QuarterTurn::kClockwise:
      return {height - 1 - pixel.y, pixel.x};
    case QuarterTurn::kHalf:
      return {width - 1 - pixel.x, height - 1 - pixel.y};
    case QuarterTurn::kCounterclockwise:
      return {pixel.y, width - 1 - pixel.x};
    case QuarterTurn::kNone:
      break;
  }
  return pixel;
}

ColorImage Turned(const ColorImage& image, QuarterTurn turn) {
  ColorImage turned{.width = image.width, .height = image.height, .rgb = {}};
  if (SwapsSides(turn)) std::swap(turned.width, turned.height);
  turned.rgb = TurnedValues<3>(image.rgb, image.width, image.height, turn);
  return turned;
}

DepthImage Turned(const DepthImage& image, QuarterTurn turn) {
  DepthImage turned{.width = image.width,
                    .height = image.height,
                    .values = {},
                    .unit_m = image.unit_m};
  if (SwapsSides(turn)) std::swap(turned.width, turned.height);
  turned.values =
      TurnedValues<1>(image.values, image.width, image.height, turn);
  return turned;
}

camera::Camera Turned(const camera::Camera& camera, QuarterTurn turn) {
  camera::Camera turned = camera;
  for (int i = 0; i < static_cast<int>(turn); ++i) {
    turned = TurnedClockwise(turned);
  }
  return turned;
}

camera::RgbdCalibration Turned(const camera::RgbdCalibration& calibration,
                               QuarterTurn turn) {
  if (turn == QuarterTurn::kNone) return calibration;
  const geometry::Rigid3 turned_from_camera{TurnedFromCamera(turn), {}};
  camera::RgbdCalibration turned = calibration;
  turned.color = Turned(calibration.color, turn);
  turned.depth = Turned(calibration.depth, turn);
  // Registered depth stays so to the last bit.
  if (calibration.color_from_depth != geometry::Rigid3{}) {
    turned.color_from_depth = turned_from_camera *
                              calibration.color_from_depth *
                              turned_from_camera.Inverse();
  }
  return turned;
}

Frame Turned(const Frame& frame, QuarterTurn turn) {
  Frame turned;
  turned.color = Turned(frame.color, turn);
  if (frame.depth) turned.depth = Turned(*frame.depth, turn);
  if (frame.calibration) turned.calibration = Turned(*frame.calibration, turn);
  turned.is_camera_assumed = frame.is_camera_assumed;
  turned.orientation = {Remaining(frame.orientation.upright_turn, turn),
                        frame.orientation.is_certain};
  return turned;
}

}  // namespace treeline::image
