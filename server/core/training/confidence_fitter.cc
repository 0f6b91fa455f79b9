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
#include "server/core/training/trial_views.h"

namespace treeline::training {
namespace {

constexpr size_t kFeatures = forest::ConfidenceModel::kFeatures;
using Vector = Eigen::Matrix<double, kFeatures, 1>;
using Matrix = Eigen::Matrix<double, kFeatures, kFeatures>;

constexpr uint64_t kTrialStream = 0x636f6e6600000000;
// Of the answers that trials give, so many may be far off, and one more.
constexpr double kMaxGrossShare = 0.005;

// The split repeats: frames to learn from, a gap, frames held out, a gap; and
// again with more of them held out, of which those in the middle look where
// nothing was learnt.
constexpr size_t kLearnt = 40;
constexpr size_t kGap = 8;
constexpr size_t kNearHeldOut = 20;
constexpr size_t kFarHeldOut = 60;
constexpr size_t kNearPeriod = kLearnt + 2 * kGap + kNearHeldOut;
constexpr size_t kPeriod = kNearPeriod + kLearnt + 2 * kGap + kFarHeldOut;
constexpr size_t kMinFrames = 60;
// Of photographs, which are never that many twins: one in so many.
constexpr size_t kPhotographPeriod = 4;
constexpr size_t kMinPhotographs = 20;

bool IsLearnt(size_t phase) {
  return phase < kLearnt ||
         (phase >= kNearPeriod && phase < kNearPeriod + kLearnt);
}
bool IsHeldOut(size_t phase) {
  const auto in_gap = [phase](size_t learnt, size_t period_end) {
    return phase >= learnt &&
           (phase < learnt + kGap || phase >= period_end - kGap);
  };
  return !IsLearnt(phase) &&
         !(phase < kNearPeriod ? in_gap(kLearnt, kNearPeriod)
                               : in_gap(kNearPeriod + kLearnt, kPeriod));
}

// Windows that are left of a frame, as shares of its width and height.
constexpr double kWindows[] = {0.8, 0.6};
constexpr int kBlurRadius_px = 8;
// Light: factors of a channel, and exponents of its brightness.
constexpr double kMinGain = 0.35;
constexpr double kMaxGamma = 2;

// Of 95 of 100 values of a normal distribution, in standard deviations.
constexpr double kFocalShare = 0.95;
constexpr double kFocalShareSigmas = 1.96;

double Sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

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

  // `without_depth`: also as frames of colour alone.
  absl::Status Run(const image::Frame& frame, const image::Frame& other,
                   bool without_depth) {
    // Pictures of other sizes do not fit over it.
    const image::Frame cover =
        Mirrored(HaveSameSizes(frame, other) ? other : frame);
    TL_RETURN_IF_ERROR(Try("whole", frame, true));
    if (without_depth) {
      TL_RETURN_IF_ERROR(Try("whole", WithoutDepth(frame), true));
    }
    const auto try_either = [&](const char* name, const image::Frame& view,
                                bool can_be_right) {
      const bool drops_depth = without_depth && random_.NextUnit() < 0.5;
      return Try(name, drops_depth ? WithoutDepth(view) : view, can_be_right);
    };
    for (const double size : kWindows) {
      const double left = random_.NextUniform(0, 1 - size);
      const double top = random_.NextUniform(0, 1 - size);
      TL_RETURN_IF_ERROR(try_either(
          "covered",
          Covered(frame, cover, {left, top, left + size, top + size}), true));
    }
    TL_RETURN_IF_ERROR(
        try_either("blurred", Blurred(frame, kBlurRadius_px), true));
    TL_RETURN_IF_ERROR(try_either("relit", Relit(frame, RandomLight()), true));
    TL_RETURN_IF_ERROR(try_either("mirrored", Mirrored(frame), false));
    return try_either("mirrored", cover, false);
  }

  std::vector<ConfidenceTrial>& trials() { return trials_; }

 private:
  absl::Status Try(const char* view, const image::Frame& frame,
                   bool can_be_right) {
    localizer::LocalizeOptions query;
    query.seed = random_.NextBits();
    TL_ASSIGN_OR_RETURN(const localizer::PoseEstimate estimate,
                        localizer_.Localize(frame, query));
    // Refused whatever the confidence.
    if (estimate.inliers == 0 ||
        estimate.reason == localizer::NotLocalizedReason::kContradictsDepth) {
      return absl::OkStatus();
    }
    const geometry::PoseError error =
        geometry::ErrorBetween(estimate.world_from_camera, truth_);
    trials_.push_back(
        {.evidence = estimate.evidence,
         .is_right = can_be_right &&
                     error.translation_m < options_.translation_m &&
                     error.rotation_rad < options_.rotation_rad,
         .is_gross = !can_be_right ||
                     error.translation_m > 2 * options_.translation_m ||
                     error.rotation_rad > 2 * options_.rotation_rad,
         .view = view,
         .error = error,
         .focal_error_sigmas = estimate.focal_error_sigmas});
    return absl::OkStatus();
  }

  Light RandomLight() {
    Light light;
    const double exposure = random_.NextUniform(kMinGain, 1.2);
    for (double& gain : light.gain) {
      gain = exposure * random_.NextUniform(0.8, 1.2);
    }
    light.gamma = std::pow(kMaxGamma, random_.NextUniform(-1, 1));
    light.is_gray = random_.NextUnit() < 0.25;
    return light;
  }

  const localizer::Localizer& localizer_;
  const geometry::Rigid3 truth_;
  const ConfidenceOptions& options_;
  base::Random random_;
  std::vector<ConfidenceTrial> trials_;
};

double FocalSigmaScale(std::span<const ConfidenceTrial> trials,
                       const ConfidenceFit& fit) {
  std::vector<double> sigmas;
  for (const ConfidenceTrial& trial : trials) {
    if (!trial.is_right || !(trial.focal_error_sigmas > 0)) continue;
    sigmas.push_back(trial.focal_error_sigmas);
  }
  if (sigmas.size() < fit.min_focal_trials) return 1;
  const auto at =
      sigmas.begin() + static_cast<std::ptrdiff_t>(
                           kFocalShare * static_cast<double>(sigmas.size()));
  std::nth_element(sigmas.begin(), at, sigmas.end());
  return std::max(1.0, *at / kFocalShareSigmas);
}

}  // namespace

FrameRole RoleOf(size_t i) {
  const size_t phase = i % kPeriod;
  if (IsLearnt(phase)) return FrameRole::kLearnt;
  return IsHeldOut(phase) ? FrameRole::kHeldOut : FrameRole::kGap;
}

HeldOutSplit SplitForConfidence(std::span<const int> frames) {
  HeldOutSplit split;
  for (size_t i = 0; i < frames.size(); ++i) {
    const FrameRole role = RoleOf(i);
    if (frames.size() < kMinFrames || role == FrameRole::kLearnt) {
      split.train.push_back(frames[i]);
    } else if (role == FrameRole::kHeldOut) {
      split.held_out.push_back(frames[i]);
    }
  }
  return split;
}

HeldOutSplit SplitPhotographsForConfidence(std::span<const int> frames) {
  if (frames.size() < kMinPhotographs || frames.size() >= kMinFrames) {
    return SplitForConfidence(frames);
  }
  HeldOutSplit split;
  for (size_t i = 0; i < frames.size(); ++i) {
    (i % kPhotographPeriod == kPhotographPeriod - 1 ? split.held_out
                                                    : split.train)
        .push_back(frames[i]);
  }
  return split;
}

forest::ConfidenceModel FitConfidence(std::span<const ConfidenceTrial> trials,
                                      const forest::ConfidenceModel& prior,
                                      const ConfidenceFit& fit) {
  Vector weights;
  Vector centre;
  for (size_t i = 0; i < kFeatures; ++i) {
    centre[static_cast<Eigen::Index>(i)] = prior.weights[i];
  }
  weights = centre;
  Vector precision =
      Vector::Constant(1 / (fit.weight_sigma * fit.weight_sigma));
  precision[0] = 1 / (fit.constant_sigma * fit.constant_sigma);
  const double weight = std::min(
      1.0, fit.independent_trials /
               std::max<double>(1, static_cast<double>(trials.size())));
  std::vector<Vector> features;
  std::vector<bool> is_right;
  for (const ConfidenceTrial& trial : trials) {
    // Settled whatever the weights.
    if (forest::MayBeElsewhere(trial.evidence)) continue;
    is_right.push_back(trial.is_right);
    const forest::ConfidenceModel::Features f =
        forest::ConfidenceModel::FeaturesOf(trial.evidence);
    features.push_back(Eigen::Map<const Vector>(f.data()));
  }
  const auto loss = [&](const Vector& w) {
    double sum = 0.5 * (w - centre).cwiseAbs2().dot(precision);
    for (size_t i = 0; i < features.size(); ++i) {
      const double z = w.dot(features[i]);
      sum += weight * (std::log1p(std::exp(-std::abs(z))) +
                       (is_right[i] ? std::max(-z, 0.0) : std::max(z, 0.0)));
    }
    return sum;
  };
  // Newton's method, projected on weights that are not negative, with steps
  // halved until they help.
  double best = loss(weights);
  for (int iteration = 0; iteration < 100; ++iteration) {
    Vector gradient = precision.cwiseProduct(weights - centre);
    Matrix hessian = precision.asDiagonal();
    for (size_t i = 0; i < features.size(); ++i) {
      const double p = Sigmoid(weights.dot(features[i]));
      gradient += weight * (p - (is_right[i] ? 1 : 0)) * features[i];
      hessian += weight * p * (1 - p) * features[i] * features[i].transpose();
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
  model.focal_sigma_scale = FocalSigmaScale(trials, fit);

  std::vector<std::pair<double, bool>> answers;  // probability, harmless
  for (const ConfidenceTrial& trial : trials) {
    answers.emplace_back(model.Probability(trial.evidence), !trial.is_gross);
  }
  std::ranges::sort(answers, std::greater<>());
  // The longest run of the surest answers that is harmless enough.
  double gross = 0;
  double highest_left = answers.empty() ? 0 : answers.front().first;
  for (size_t i = 0; i < answers.size(); ++i) {
    gross += !answers[i].second;
    if (gross <= 1 + kMaxGrossShare * static_cast<double>(i + 1)) {
      highest_left = i + 1 < answers.size() ? answers[i + 1].first : 0;
    }
  }
  model.threshold =
      std::clamp(highest_left + 1e-6, fit.min_threshold, fit.max_threshold);
  return model;
}

localizer::QueryOptions TrialOptions() {
  localizer::QueryOptions options;
  options.other_turns = false;
  options.corrects_focal = false;
  return options;
}

absl::StatusOr<std::vector<ConfidenceTrial>> RunTrialsOfFrame(
    const localizer::Localizer& localizer, const image::Frame& frame,
    const image::Frame& other, const geometry::Rigid3& world_from_sensor,
    const ConfidenceOptions& options, uint64_t number) {
  FrameTrials trials(localizer, world_from_sensor, options, number);
  TL_RETURN_IF_ERROR(trials.Run(
      frame, other, localizer.depth_use() == localizer::DepthUse::kWhereGiven));
  return std::move(trials.trials());
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
    return RunTrialsOfFrame(
        localizer, frame, other,
        camera::PoseOfSensor(*held_out.frame(i).world_from_camera,
                             held_out.calibration().pose_sensor,
                             calibration.pose_sensor, calibration),
        options, static_cast<uint64_t>(i));
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
                      localizer::OpenLocalizer(file.path(), TrialOptions()));
  TL_ASSIGN_OR_RETURN(
      const std::vector<ConfidenceTrial> trials,
      RunConfidenceTrials(*localizer, held_out, options, quiet, stop));
  if (options.on_trials) options.on_trials(trials);
  return FitConfidence(trials, options.prior);
}

}  // namespace treeline::training
