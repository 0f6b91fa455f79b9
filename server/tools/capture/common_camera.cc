#include "server/tools/capture/common_camera.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/tools/capture/conventions.h"

namespace treeline::capture {
namespace {

// Where the pixel of `to` is in the picture of `from`.
std::optional<camera::Pixel> SourceOf(const camera::Camera& from,
                                      const camera::Camera& to, int x, int y) {
  const std::optional<camera::Pixel> ray =
      to.Unproject({static_cast<double>(x), static_cast<double>(y)});
  if (!ray) return std::nullopt;
  const camera::Pixel pixel = from.Project({ray->x, ray->y, 1});
  if (!std::isfinite(pixel.x) || !std::isfinite(pixel.y)) return std::nullopt;
  return pixel;
}

image::ColorImage FromMat(const cv::Mat& mat) {
  return {mat.cols, mat.rows,
          std::vector<uint8_t>(mat.data, mat.data + mat.total() * 3)};
}

cv::Mat Remapped(const cv::Mat& source, const camera::Camera& from,
                 const camera::Camera& to) {
  cv::Mat x(to.height(), to.width(), CV_32F);
  cv::Mat y(to.height(), to.width(), CV_32F);
  for (int row = 0; row < to.height(); ++row) {
    for (int column = 0; column < to.width(); ++column) {
      const camera::Pixel pixel =
          SourceOf(from, to, column, row).value_or(camera::Pixel{-1e4, -1e4});
      x.at<float>(row, column) = static_cast<float>(pixel.x);
      y.at<float>(row, column) = static_cast<float>(pixel.y);
    }
  }
  cv::Mat result;
  cv::remap(source, result, x, y, cv::INTER_LINEAR);
  return result;
}

}  // namespace

camera::Camera MedianCamera(const std::vector<CaptureFrame>& frames) {
  std::map<std::pair<int, int>, std::vector<const CaptureFrame*>> by_size;
  for (const CaptureFrame& frame : frames) {
    by_size[{frame.color.width(), frame.color.height()}].push_back(&frame);
  }
  auto& most = std::ranges::max_element(by_size, {}, [](const auto& entry) {
                 return entry.second.size();
               })->second;
  const auto middle = most.begin() + static_cast<ptrdiff_t>(most.size() / 2);
  std::ranges::nth_element(most, middle, {}, [](const CaptureFrame* frame) {
    return camera::MeanFocal_px(frame->color);
  });
  return (*middle)->color;
}

double LargestDifference_px(const camera::Camera& a, const camera::Camera& b) {
  if (a == b) return 0;
  constexpr int kSteps = 8;
  double largest_px = 0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const int x = i * (a.width() - 1) / kSteps;
      const int y = j * (a.height() - 1) / kSteps;
      const std::optional<camera::Pixel> pixel = SourceOf(a, b, x, y);
      if (!pixel) continue;
      largest_px = std::max(largest_px, std::hypot(pixel->x - x, pixel->y - y));
    }
  }
  return largest_px;
}

absl::StatusOr<image::ColorImage> Resampled(const image::ColorImage& image,
                                            const camera::Camera& from,
                                            const camera::Camera& to) {
  try {
    cv::Mat mat(image.height, image.width, CV_8UC3,
                const_cast<uint8_t*>(image.rgb.data()));
    camera::Camera source = from;
    if (to.width() != from.width() || to.height() != from.height()) {
      cv::Mat smaller;
      // With the centres of pixels as ScaledTo has them.
      cv::resize(mat, smaller, cv::Size(to.width(), to.height()), 0, 0,
                 cv::INTER_AREA);
      mat = smaller;
      TL_ASSIGN_OR_RETURN(source, ScaledTo(from, {to.width(), to.height()}));
    }
    // Where only the size differs the picture is done.
    constexpr double kSame_px = 1e-6;
    if (LargestDifference_px(source, to) > kSame_px) {
      mat = Remapped(mat, source, to);
    }
    return FromMat(mat);
  } catch (const cv::Exception& error) {
    return absl::InternalError(
        absl::StrCat("resampling a picture: ", error.what()));
  }
}

image::DepthImage Resampled(const image::DepthImage& image,
                            const camera::Camera& from,
                            const camera::Camera& to) {
  image::DepthImage result = image;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      uint16_t value = 0;
      if (const auto pixel = SourceOf(from, to, x, y)) {
        const double column = std::round(pixel->x);
        const double row = std::round(pixel->y);
        if (column >= 0 && row >= 0 && column < image.width &&
            row < image.height) {
          value = image.values[static_cast<size_t>(row) *
                                   static_cast<size_t>(image.width) +
                               static_cast<size_t>(column)];
        }
      }
      result.values[static_cast<size_t>(y) * static_cast<size_t>(image.width) +
                    static_cast<size_t>(x)] = value;
    }
  }
  return result;
}

}  // namespace treeline::capture
