#include "evaluation/yardsticks/opencv_sift.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <span>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "evaluation/yardsticks/opencv_threads.h"
#include "opencv2/core.hpp"
#include "opencv2/features2d.hpp"
#include "opencv2/imgproc.hpp"

namespace treeline::yardsticks {
namespace {

using features::SiftDescriptor;
using features::SiftFeatures;
using features::SiftOptions;

constexpr int kMinSize_px = 8;
// What OpenCV adds to both coordinates.
constexpr float kOpenCvShift_px = 0.25F;

cv::Mat GrayOf(const image::ColorImage& image) {
  // OpenCV reads the pixels only.
  const cv::Mat color(image.height, image.width, CV_8UC3,
                      const_cast<uint8_t*>(image.rgb.data()));
  cv::Mat gray;
  cv::cvtColor(color, gray, cv::COLOR_RGB2GRAY);
  return gray;
}

// RootSIFT of 128 histogram values, none negative.
SiftDescriptor RootSift(std::span<const float> histogram) {
  float sum = 0;
  for (const float value : histogram) sum += value;
  SiftDescriptor descriptor;
  if (!(sum > 0)) return descriptor;
  for (size_t i = 0; i < descriptor.values.size(); ++i) {
    const float root = SiftDescriptor::kScale * std::sqrt(histogram[i] / sum);
    descriptor.values[i] =
        static_cast<uint8_t>(std::lround(std::min(root, 255.0F)));
  }
  return descriptor;
}

SiftDescriptor DescriptorOf(const cv::Mat& rows, int row) {
  return RootSift(std::span(rows.ptr<float>(row), SiftDescriptor::kDimensions));
}

// One row a keypoint, in their order. OpenCV doubles the image only if some
// keypoint is of the lowest octave, and descriptors differ a little by that:
// one such keypoint is always there, so that they do not depend on the others.
void ComputeRows(cv::SIFT& sift, const cv::Mat& gray,
                 std::vector<cv::KeyPoint>& keypoints, cv::Mat& rows) {
  constexpr int kLowestOctave = 255 | 1 << 8;
  keypoints.emplace_back(0.5F * static_cast<float>(gray.cols),
                         0.5F * static_cast<float>(gray.rows), 2.0F, 0.0F, 0.0F,
                         kLowestOctave);
  sift.compute(gray, keypoints, rows);
  keypoints.pop_back();
}

// OpenCV fails on images too small for an octave.
bool IsTooSmall(const image::ColorImage& image) {
  return std::min(image.width, image.height) < kMinSize_px;
}

SiftFeatures ExtractOrThrow(const image::ColorImage& image,
                            const SiftOptions& options) {
  if (IsTooSmall(image)) return {};
  RunOpenCvOnCallingThread();
  std::vector<cv::KeyPoint> found;
  cv::Mat rows;
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(
      /*nfeatures=*/0, /*nOctaveLayers=*/3, options.contrast);
  const cv::Mat gray = GrayOf(image);
  sift->detect(gray, found);
  // A total order, so that equal sizes are not left to chance.
  std::ranges::sort(found, [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    return std::tie(b.size, b.response, a.pt.y, a.pt.x, a.angle) <
           std::tie(a.size, a.response, b.pt.y, b.pt.x, b.angle);
  });
  const size_t kept = static_cast<size_t>(options.max_features);
  if (kept > 0 && found.size() > kept) found.resize(kept);
  ComputeRows(*sift, gray, found, rows);
  SiftFeatures features;
  features.keypoints.reserve(found.size());
  features.descriptors.reserve(found.size());
  for (size_t i = 0; i < found.size(); ++i) {
    const cv::KeyPoint& k = found[i];
    features.keypoints.push_back(
        {{static_cast<double>(k.pt.x - kOpenCvShift_px),
          static_cast<double>(k.pt.y - kOpenCvShift_px)},
         k.size,
         k.angle,
         k.response});
    features.descriptors.push_back(DescriptorOf(rows, static_cast<int>(i)));
  }
  return features;
}

}  // namespace

absl::StatusOr<SiftFeatures> ExtractOpenCvSift(const image::ColorImage& image,
                                               const SiftOptions& options) {
  try {
    return ExtractOrThrow(image, options);
  } catch (const std::exception& error) {
    return absl::InternalError(absl::StrCat("OpenCV: ", error.what()));
  }
}

}  // namespace treeline::yardsticks
