#include "server/core/training/trial_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace treeline::training {
namespace {

image::ColorImage MirroredImage(const image::ColorImage& image) {
  image::ColorImage out = image;
  const size_t width = static_cast<size_t>(image.width);
  for (size_t y = 0; y < static_cast<size_t>(image.height); ++y) {
    for (size_t x = 0; x < width; ++x) {
      for (size_t c = 0; c < 3; ++c) {
        out.rgb[3 * (y * width + x) + c] =
            image.rgb[3 * (y * width + width - 1 - x) + c];
      }
    }
  }
  return out;
}

image::DepthImage MirroredImage(const image::DepthImage& image) {
  image::DepthImage out = image;
  const size_t width = static_cast<size_t>(image.width);
  for (size_t y = 0; y < static_cast<size_t>(image.height); ++y) {
    std::reverse(
        out.values.begin() + static_cast<std::ptrdiff_t>(y * width),
        out.values.begin() + static_cast<std::ptrdiff_t>((y + 1) * width));
  }
  return out;
}

uint8_t ByteOf(double value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

bool HaveSameSizes(const image::Frame& a, const image::Frame& b) {
  return a.color.width == b.color.width && a.color.height == b.color.height &&
         a.depth.has_value() == b.depth.has_value() &&
         (!a.depth || (a.depth->width == b.depth->width &&
                       a.depth->height == b.depth->height));
}

image::Frame Mirrored(const image::Frame& frame) {
  image::Frame out;
  out.calibration = frame.calibration;
  out.color = MirroredImage(frame.color);
  if (frame.depth) out.depth = MirroredImage(*frame.depth);
  return out;
}

image::Frame Covered(const image::Frame& frame, const image::Frame& cover,
                     const Window& window) {
  image::Frame out = cover;
  const auto copy = [&](int width, int height, const auto& copy_pixel) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (window.Contains((x + 0.5) / width, (y + 0.5) / height)) {
          copy_pixel(static_cast<size_t>(y * width + x));
        }
      }
    }
  };
  copy(frame.color.width, frame.color.height, [&](size_t i) {
    for (size_t c = 0; c < 3; ++c) {
      out.color.rgb[3 * i + c] = frame.color.rgb[3 * i + c];
    }
  });
  if (frame.depth && out.depth) {
    copy(frame.depth->width, frame.depth->height,
         [&](size_t i) { out.depth->values[i] = frame.depth->values[i]; });
  }
  return out;
}

image::Frame Blurred(const image::Frame& frame, int radius_px) {
  image::Frame out = frame;
  const int width = frame.color.width;
  for (int y = 0; y < frame.color.height; ++y) {
    for (int c = 0; c < 3; ++c) {
      const auto at = [&](int x) {
        return static_cast<size_t>(3 * (y * width + x) + c);
      };
      int sum = 0;
      int count = 0;
      for (int x = -radius_px; x < width; ++x) {
        const int enters = x + radius_px;
        if (enters < width) {
          sum += frame.color.rgb[at(enters)];
          ++count;
        }
        const int leaves = x - radius_px - 1;
        if (leaves >= 0) {
          sum -= frame.color.rgb[at(leaves)];
          --count;
        }
        if (x >= 0) out.color.rgb[at(x)] = static_cast<uint8_t>(sum / count);
      }
    }
  }
  return out;
}

image::Frame Relit(const image::Frame& frame, const Light& light) {
  std::array<std::array<uint8_t, 256>, 3> curves{};
  for (size_t c = 0; c < 3; ++c) {
    for (size_t v = 0; v < 256; ++v) {
      curves[c][v] =
          ByteOf(255 * light.gain[c] *
                 std::pow(static_cast<double>(v) / 255, light.gamma));
    }
  }
  image::Frame out = frame;
  for (size_t i = 0; i < out.color.rgb.size(); i += 3) {
    for (size_t c = 0; c < 3; ++c) {
      out.color.rgb[i + c] = curves[c][frame.color.rgb[i + c]];
    }
    if (!light.is_gray) continue;
    const uint8_t gray =
        ByteOf(0.299 * out.color.rgb[i] + 0.587 * out.color.rgb[i + 1] +
               0.114 * out.color.rgb[i + 2]);
    std::fill_n(out.color.rgb.begin() + static_cast<std::ptrdiff_t>(i), 3,
                gray);
  }
  return out;
}

image::Frame WithoutDepth(const image::Frame& frame) {
  image::Frame out;
  out.color = frame.color;
  out.calibration = frame.calibration;
  return out;
}

}  // namespace treeline::training
