#include "evaluation/accuracy/report_pictures.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/image/decode.h"

namespace treeline::accuracy {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr int kJpegQuality = 82;
constexpr int kMaxPictureWidth = 960;
// Frames of a list nearer than this look alike.
constexpr int kPictureSpacing = 4;

// Larger is worse; frames that were not localized are worst of all.
double Badness(const FrameResult& result) {
  if (!result.localized()) return std::numeric_limits<double>::infinity();
  // One degree weighs as much as one centimetre, as in the thresholds.
  return result.error->translation_m +
         result.error->rotation_rad * kDegreesPerRadian / 100;
}

bool CanBePictured(const FrameResult& result) {
  return result.status.ok() &&
         (!result.localized() || result.error.has_value());
}

// The mean of factor x factor pixels for each pixel.
image::ColorImage Shrunk(const image::ColorImage& image, int factor) {
  image::ColorImage small{image.width / factor, image.height / factor, {}};
  small.rgb.resize(3 * static_cast<size_t>(small.width) *
                   static_cast<size_t>(small.height));
  size_t out = 0;
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int dy = 0; dy < factor; ++dy) {
          for (int dx = 0; dx < factor; ++dx) {
            sum += image.rgb[static_cast<size_t>(
                3 * ((y * factor + dy) * image.width + x * factor + dx) + c)];
          }
        }
        small.rgb[out++] = static_cast<uint8_t>(sum / (factor * factor));
      }
    }
  }
  return small;
}

}  // namespace

std::vector<PictureChoice> ChoosePictures(
    const std::vector<FrameResult>& results, int worst, int median, int best) {
  std::vector<int> order;
  for (size_t i = 0; i < results.size(); ++i) {
    if (CanBePictured(results[i])) order.push_back(static_cast<int>(i));
  }
  std::ranges::stable_sort(order, [&](int a, int b) {
    return Badness(results[static_cast<size_t>(a)]) >
           Badness(results[static_cast<size_t>(b)]);
  });
  std::vector<PictureChoice> choices;
  const int count = static_cast<int>(order.size());
  // Takes up to `wanted` frames from rank `first` on, towards the other end.
  const auto take = [&](int first, int step, int wanted, PictureKind kind) {
    for (int spacing : {kPictureSpacing, 1}) {
      for (int rank = first; rank >= 0 && rank < count && wanted > 0;
           rank += step) {
        const int frame = order[static_cast<size_t>(rank)];
        const bool close = std::ranges::any_of(choices, [&](const auto& c) {
          return std::abs(c.frame - frame) < spacing;
        });
        if (close) continue;
        choices.push_back({frame, kind});
        --wanted;
      }
    }
  };
  take(0, 1, worst, PictureKind::kWorst);
  take(count / 2, 1, median, PictureKind::kMedian);
  take(count - 1, -1, best, PictureKind::kBest);
  return choices;
}

std::vector<ReportPicture> TakePictures(
    const localizer::Localizer& localizer, const dataset::Dataset& dataset,
    const std::vector<PictureChoice>& choices,
    const EvaluationOptions& options) {
  std::vector<ReportPicture> pictures;
  for (const PictureChoice& choice : choices) {
    absl::StatusOr<image::Frame> frame = dataset.Load(choice.frame);
    if (!frame.ok()) continue;
    if (options.calibration) frame->calibration = options.calibration;
    localizer::LocalizeOptions query = options.Query();
    query.keep_correspondences = true;
    absl::StatusOr<localizer::PoseEstimate> estimate =
        localizer.Localize(*frame, query);
    if (!estimate.ok()) continue;
    const int factor =
        (frame->color.width + kMaxPictureWidth - 1) / kMaxPictureWidth;
    absl::StatusOr<std::string> jpeg = image::EncodeJpeg(
        factor > 1 ? Shrunk(frame->color, factor) : frame->color, kJpegQuality);
    if (!jpeg.ok()) continue;
    pictures.push_back({choice, *std::move(jpeg), frame->color.width,
                        frame->color.height,
                        std::move(estimate->correspondences)});
  }
  return pictures;
}

}  // namespace treeline::accuracy
