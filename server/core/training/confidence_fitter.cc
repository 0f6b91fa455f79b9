#include "server/core/training/confidence_fitter.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"

namespace treeline::training {
namespace {

constexpr size_t kFeatures = forest::ConfidenceModel::kFeatures;
using Vector = Eigen::Matrix<double, kFeatures, 1>;
using Matrix = Eigen::Matrix<double, kFeatures, kFeatures>;

constexpr uint64_t kTrialStream = 0x636f6e6600000000;
// The prior's weights count as if known with this standard deviation.
constexpr double kPriorSigma = 3;
constexpr double kTargetPrecision = 0.99;

// One period of the split: frames to learn from, a gap, frames held out, and a
// gap again.
constexpr size_t kLearnt = 40;
constexpr size_t kGap = 8;
constexpr size_t kHeldOut = 20;
constexpr size_t kPeriod = kLearnt + 2 * kGap + kHeldOut;
constexpr size_t kMinFrames = 60;

// Windows that are left of a frame, as shares of its width and height.
constexpr double kWindows[] = {0.85, 0.7, 0.55, 0.4};
constexpr int kBlurRadius_px = 12;

double Sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

image::ColorImage Mirrored(const image::ColorImage& image) {
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

image::DepthImage Mirrored(const image::DepthImage& image) {
  image::DepthImage out = image;
  const size_t width = static_cast<size_t>(image.width);
  for (size_t y = 0; y < static_cast<size_t>(image.height); ++y) {
    std::reverse(
        out.values.begin() + static_cast<std::ptrdiff_t>(y * width),
        out.values.begin() + static_cast<std::ptrdiff_t>((y + 1) * width));
  }
  return out;
}

image::Frame Mirrored(const image::Frame& frame) {
  image::Frame out;
  out.calibration = frame.calibration;
  out.color = Mirrored(frame.color);
  if (frame.depth) out.depth = Mirrored(*frame.depth);
  return out;
}

// A window given as shares of an image's size.
struct Window {
  double left, top, right, bottom;
  bool Contains(double x, double y) const {
    return x >= left && x < right && y >= top && y < bottom;
  }
};

// `cover` but for a window of `frame`. Both have the same sizes.
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

// Smeared sideways, as by a moving camera.
image::Frame Blurred(const image::Frame& frame) {
  image::Frame out = frame;
  const int width = frame.color.width;
  for (int y = 0; y < frame.color.height; ++y) {
    for (int c = 0; c < 3; ++c) {
      const auto at = [&](int x) {
        return static_cast<size_t>(3 * (y * width + x) + c);
      };
      int sum = 0;
      int count = 0;
      for (int x = -kBlurRadius_px; x < width; ++x) {
        const int enters = x + kBlurRadius_px;
        if (enters < width) {
          sum += frame.color.rgb[at(enters)];
          ++count;
        }
        const int leaves = x - kBlurRadius_px - 1;
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

// Removes a file when it goes out of scope.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::string path) : path_(std::move(path)) {}
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  const std::string path_;
};

bool HaveSameSizes(const image::Frame& a, const image::Frame& b) {
  return a.color.width == b.color.width && a.color.height == b.color.height &&
         a.depth.has_value() == b.depth.has_value() &&
         (!a.depth || (a.depth->width == b.depth->width &&
                       a.depth->height == b.depth->height));
}

// The trials of one frame; `other` covers it.
class FrameTrials {
 public:
  FrameTrials(const localizer::Localizer& localizer,
              const geometry::Rigid3& truth, const ConfidenceOptions& options,
              uint64_t seed)
      : localizer_(localizer),
        truth_(truth),
        options_(options),
        random_(options.seed, kTrialStream + seed) {}

  absl::Status Run(const image::Frame& frame, const image::Frame& other) {
    // Pictures of other sizes do not fit over it.
    const image::Frame cover =
        Mirrored(HaveSameSizes(frame, other) ? other : frame);
    TL_RETURN_IF_ERROR(Try(frame, true));
    for (const double size : kWindows) {
      const double left = random_.NextUniform(0, 1 - size);
      const double top = random_.NextUniform(0, 1 - size);
      TL_RETURN_IF_ERROR(Try(
          Covered(frame, cover, {left, top, left + size, top + size}), true));
    }
    TL_RETURN_IF_ERROR(Try(Blurred(frame), true));
    TL_RETURN_IF_ERROR(Try(Mirrored(frame), false));
    return Try(cover, false);
  }

  std::vector<ConfidenceTrial>& trials() { return trials_; }

 private:
  absl::Status Try(const image::Frame& frame, bool can_be_right) {
    localizer::LocalizeOptions query;
    query.seed = random_.NextBits();
    TL_ASSIGN_OR_RETURN(const localizer::PoseEstimate estimate,
                        localizer_.Localize(frame, query));
    if (estimate.inliers == 0) return absl::OkStatus();
    const geometry::PoseError error =
        geometry::ErrorBetween(estimate.world_from_camera, truth_);
    trials_.push_back(
        {estimate.evidence, can_be_right &&
                                error.translation_m < options_.translation_m &&
                                error.rotation_rad < options_.rotation_rad});
    return absl::OkStatus();
  }

  const localizer::Localizer& localizer_;
  const geometry::Rigid3 truth_;
  const ConfidenceOptions& options_;
  base::Random random_;
  std::vector<ConfidenceTrial> trials_;
};

}  // namespace

HeldOutSplit SplitForConfidence(std::span<const int> frames) {
  HeldOutSplit split;
  for (size_t i = 0; i < frames.size(); ++i) {
    const size_t phase = i % kPeriod;
    if (frames.size() < kMinFrames || phase < kLearnt) {
      split.train.push_back(frames[i]);
    } else if (phase >= kLearnt + kGap && phase < kPeriod - kGap) {
      split.held_out.push_back(frames[i]);
    }
  }
  return split;
}

forest::ConfidenceModel FitConfidence(std::span<const ConfidenceTrial> trials,
                                      const forest::ConfidenceModel& prior) {
  Vector weights;
  Vector centre;
  for (size_t i = 0; i < kFeatures; ++i) {
    centre[static_cast<Eigen::Index>(i)] = prior.weights[i];
  }
  weights = centre;
  const double precision = 1 / (kPriorSigma * kPriorSigma);
  std::vector<Vector> features;
  for (const ConfidenceTrial& trial : trials) {
    const forest::ConfidenceModel::Features f =
        forest::ConfidenceModel::FeaturesOf(trial.evidence);
    features.push_back(Eigen::Map<const Vector>(f.data()));
  }
  const auto loss = [&](const Vector& w) {
    double sum = 0.5 * precision * (w - centre).squaredNorm();
    for (size_t i = 0; i < trials.size(); ++i) {
      const double z = w.dot(features[i]);
      sum += std::log1p(std::exp(-std::abs(z))) +
             (trials[i].is_right ? std::max(-z, 0.0) : std::max(z, 0.0));
    }
    return sum;
  };
  // Newton's method, projected on weights that are not negative, with steps
  // halved until they help.
  double best = loss(weights);
  for (int iteration = 0; iteration < 100; ++iteration) {
    Vector gradient = precision * (weights - centre);
    Matrix hessian = precision * Matrix::Identity();
    for (size_t i = 0; i < trials.size(); ++i) {
      const double p = Sigmoid(weights.dot(features[i]));
      gradient += (p - (trials[i].is_right ? 1 : 0)) * features[i];
      hessian += p * (1 - p) * features[i] * features[i].transpose();
    }
    // A weight that rests on its bound and is pushed against it stays there.
    for (Eigen::Index k = 1; k < gradient.size(); ++k) {
      if (weights[k] > 0 || gradient[k] < 0) continue;
      hessian.row(k).setZero();
      hessian.col(k).setZero();
      hessian(k, k) = 1;
      gradient[k] = 0;
    }
    const Vector step = -hessian.ldlt().solve(gradient);
    double scale = 1;
    double reached = best;
    Vector candidate = weights;
    for (; scale > 1e-4; scale /= 2) {
      candidate = weights + scale * step;
      for (Eigen::Index k = 1; k < candidate.size(); ++k) {
        candidate[k] = std::max(candidate[k], 0.0);
      }
      reached = loss(candidate);
      if (reached < best) break;
    }
    if (!(reached < best - 1e-9)) break;
    best = reached;
    weights = candidate;
  }
  forest::ConfidenceModel model;
  std::copy(weights.begin(), weights.end(), model.weights.begin());

  std::vector<std::pair<double, bool>> answers;
  for (const ConfidenceTrial& trial : trials) {
    answers.emplace_back(model.Probability(trial.evidence), trial.is_right);
  }
  std::ranges::sort(answers, std::greater<>());
  // The longest run of the surest answers that is precise enough.
  double wrong = 0;
  double highest_left = answers.empty() ? 0 : answers.front().first;
  for (size_t i = 0; i < answers.size(); ++i) {
    wrong += !answers[i].second;
    if (wrong <= (1 - kTargetPrecision) * static_cast<double>(i + 1)) {
      highest_left = i + 1 < answers.size() ? answers[i + 1].first : 0;
    }
  }
  model.threshold = std::clamp(highest_left + 1e-6, 0.5, 0.99);
  return model;
}

absl::StatusOr<std::vector<ConfidenceTrial>> RunConfidenceTrials(
    const localizer::Localizer& localizer, const dataset::Dataset& held_out,
    const ConfidenceOptions& options, bool quiet, const std::stop_token& stop) {
  std::vector<int> frames;
  for (int i = 0; i < held_out.size(); ++i) {
    if (held_out.frame(i).world_from_camera) frames.push_back(i);
  }
  const size_t count =
      std::min(frames.size(), static_cast<size_t>(options.frames));
  std::vector<int> chosen;
  for (size_t k = 0; k < count; ++k) {
    chosen.push_back(frames[k * frames.size() / count]);
  }
  std::vector<absl::StatusOr<std::vector<ConfidenceTrial>>> results(
      count, std::vector<ConfidenceTrial>());
  const auto run =
      [&](size_t k) -> absl::StatusOr<std::vector<ConfidenceTrial>> {
    const int i = chosen[k];
    TL_ASSIGN_OR_RETURN(const image::Frame frame, held_out.Load(i));
    // What covers it comes from elsewhere in the recording.
    TL_ASSIGN_OR_RETURN(const image::Frame other,
                        held_out.Load(chosen[(k + count / 2) % count]));
    const camera::RgbdCalibration& calibration = localizer.info().calibration;
    FrameTrials trials(
        localizer,
        camera::PoseOfSensor(*held_out.frame(i).world_from_camera,
                             held_out.calibration().pose_sensor,
                             calibration.pose_sensor, calibration),
        options, static_cast<uint64_t>(i));
    TL_RETURN_IF_ERROR(trials.Run(frame, other));
    return std::move(trials.trials());
  };
  {
    base::Progress progress("calibrating confidence",
                            static_cast<int64_t>(count), quiet);
    base::ParallelFor(
        static_cast<int64_t>(count), options.threads, [&](int64_t k) {
          if (stop.stop_requested()) return;
          results[static_cast<size_t>(k)] = run(static_cast<size_t>(k));
          progress.Add(1);
        });
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("training was interrupted");
  }
  std::vector<ConfidenceTrial> trials;
  for (const auto& result : results) {
    TL_RETURN_IF_ERROR(result.status());
    trials.insert(trials.end(), result->begin(), result->end());
  }
  return trials;
}

absl::StatusOr<forest::ConfidenceModel> LearnConfidence(
    const std::function<absl::Status(const std::string&)>& write_model,
    const std::string& path, const dataset::Dataset& held_out,
    const ConfidenceOptions& options, bool quiet, const std::stop_token& stop) {
  const TemporaryFile file(absl::StrCat(path, ".trial-", getpid()));
  TL_RETURN_IF_ERROR(write_model(file.path()));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<localizer::Localizer> localizer,
                      localizer::OpenLocalizer(file.path()));
  TL_ASSIGN_OR_RETURN(
      const std::vector<ConfidenceTrial> trials,
      RunConfidenceTrials(*localizer, held_out, options, quiet, stop));
  return FitConfidence(trials, forest::ConfidenceModel::Typical());
}

}  // namespace treeline::training
