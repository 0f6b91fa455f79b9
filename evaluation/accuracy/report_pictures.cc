#include "evaluation/accuracy/report_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/image/decode.h"
#include "evaluation/report/report_svg.h"

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

std::string Dots(const std::vector<localizer::Correspondence>& correspondences,
                 bool inlier) {
  std::string path;
  for (const localizer::Correspondence& c : correspondences) {
    if (c.inlier != inlier) continue;
    absl::StrAppendFormat(&path, "M%.0f %.0fh0", c.color_pixel.x,
                          c.color_pixel.y);
  }
  return path;
}

const char* KindName(PictureKind kind) {
  switch (kind) {
    case PictureKind::kWorst:
      return "among the worst";
    case PictureKind::kMedian:
      return "about the median";
    case PictureKind::kBest:
      return "among the best";
  }
  return "";
}

// "8.3 cm and 1.20°".
std::string ErrorText(const geometry::PoseError& error) {
  return absl::StrFormat("%.1f cm and %.2f°", 100 * error.translation_m,
                         error.rotation_rad * kDegreesPerRadian);
}

double MedianInlierRatio(const std::vector<FrameResult>& results) {
  std::vector<double> ratios;
  for (const FrameResult& result : results) {
    if (result.status.ok()) ratios.push_back(result.estimate.inlier_ratio);
  }
  return Percentile(std::move(ratios), 50).value_or(0);
}

// Along which axis of the camera a position error lies, where one stands out.
std::string DirectionText(const FrameResult& result) {
  const geometry::Rigid3& truth = *result.true_world_from_camera;
  const geometry::Vec3 error =
      truth.rotation.Inverse() *
      (result.estimate.world_from_camera.translation - truth.translation);
  const double share_of_depth = std::abs(error.z) / geometry::Norm(error);
  if (share_of_depth > 0.85) return ", mostly along the viewing direction";
  if (share_of_depth < 0.4) return ", mostly sideways";
  return "";
}

std::string Explanation(const FrameResult& result,
                        const std::vector<FrameResult>& results,
                        const std::vector<geometry::Rigid3>& training_poses) {
  const localizer::PoseEstimate& estimate = result.estimate;
  std::string text;
  if (!result.localized()) {
    text = absl::StrCat("Not localized: ", ReasonText(estimate.reason), ". ");
  } else if (result.error) {
    text = absl::StrCat("Off by ", ErrorText(*result.error),
                        DirectionText(result), ". ");
  }
  absl::StrAppendFormat(
      &text,
      "%d of %d predictions agree (%.0f %%; the median frame has %.0f "
      "%%).",
      estimate.inliers, estimate.samples, 100 * estimate.inlier_ratio,
      100 * MedianInlierRatio(results));
  if (result.localized()) {
    const geometry::PoseCovariance& c = estimate.covariance;
    const double sigma_m = std::sqrt(c[0] + c[7] + c[14]);
    if (sigma_m > 0) {
      absl::StrAppendFormat(&text, " It claims a deviation of %.1f cm.",
                            100 * sigma_m);
    }
  }
  if (result.true_world_from_camera) {
    const auto nearest =
        DistanceToTraining(*result.true_world_from_camera, training_poses);
    if (nearest) {
      absl::StrAppendFormat(
          &text, " The nearest training camera is %.0f cm and %.0f° away.",
          100 * nearest->translation_m, nearest->rotation_deg);
    }
  }
  return text;
}

}  // namespace

const char* ReasonText(localizer::NotLocalizedReason reason) {
  switch (reason) {
    case localizer::NotLocalizedReason::kNone:
      return "no reason given";
    case localizer::NotLocalizedReason::kTooFewSamples:
      return "too few samples";
    case localizer::NotLocalizedReason::kTooFewInliers:
      return "too few inliers";
    case localizer::NotLocalizedReason::kPoorlyConstrained:
      return "poorly constrained";
    case localizer::NotLocalizedReason::kLowConfidence:
      return "low confidence";
    case localizer::NotLocalizedReason::kContradictsPrior:
      return "contradicts the prior";
  }
  return "unknown";
}

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
    const localizer::LocalizeOptions query{.seed = options.seed,
                                           .keep_correspondences = true,
                                           .stop = options.stop};
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

std::optional<TrainingDistance> DistanceToTraining(
    const geometry::Rigid3& world_from_camera,
    const std::vector<geometry::Rigid3>& training_poses) {
  std::optional<TrainingDistance> nearest;
  for (const geometry::Rigid3& pose : training_poses) {
    const geometry::PoseError error =
        geometry::ErrorBetween(world_from_camera, pose);
    const double combined_m =
        std::hypot(error.translation_m, kViewDistance_m * error.rotation_rad);
    if (nearest && nearest->combined_m <= combined_m) continue;
    nearest = {error.translation_m, error.rotation_rad * kDegreesPerRadian,
               combined_m};
  }
  return nearest;
}

std::string PictureHtml(const ReportPicture& picture,
                        const std::vector<FrameResult>& results,
                        const std::vector<geometry::Rigid3>& training_poses) {
  const FrameResult& result =
      results[static_cast<size_t>(picture.choice.frame)];
  const double radius = picture.width / 640.0;
  return absl::StrFormat(
      "<figure><svg viewBox=\"0 0 %d %d\" class=\"photo\" role=\"img\" "
      "aria-label=\"%s\" style=\"--dot:%.2f\">"
      "<image width=\"%d\" height=\"%d\" "
      "href=\"data:image/jpeg;base64,%s\"/>"
      "<path d=\"%s\" class=\"outlier\"/><path d=\"%s\" class=\"inlier\"/>"
      "</svg>\n<figcaption><b>%s</b> <span>%s</span><br>%s</figcaption>"
      "</figure>\n",
      picture.width, picture.height, report::EscapeHtml(result.stem), radius,
      picture.width, picture.height, absl::Base64Escape(picture.jpeg),
      Dots(picture.correspondences, false), Dots(picture.correspondences, true),
      report::EscapeHtml(result.stem), KindName(picture.choice.kind),
      report::EscapeHtml(Explanation(result, results, training_poses)));
}

}  // namespace treeline::accuracy
