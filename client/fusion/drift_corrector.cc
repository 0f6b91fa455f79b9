#include "client/fusion/drift_corrector.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/fusion/gaussian_pose.h"
#include "client/fusion/hypothesis.h"
#include "client/fusion/radians.h"
#include "client/fusion/shown_world.h"
#include "client/fusion/track_history.h"

namespace treeline::drift {
namespace {

using geometry::Rigid3;
using std::chrono::nanoseconds;

// Differences of such times fit in 64 bits.
constexpr int64_t kLargestTime_ns = int64_t{1} << 62;
constexpr double kMaxNormError = 0.01;

absl::Status CheckTime(nanoseconds time) {
  if (time.count() >= -kLargestTime_ns && time.count() <= kLargestTime_ns) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("time: ", time.count(), " ns is further than 146 years"));
}

absl::Status CheckPose(absl::string_view name, const Rigid3& pose) {
  if (!IsFinite(pose)) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": has a NaN or an infinity"));
  }
  const auto& [w, x, y, z] = pose.rotation;
  const double norm = std::sqrt(w * w + x * x + y * y + z * z);
  if (!(std::abs(norm - 1) <= kMaxNormError)) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": its rotation has norm ", norm, ", not 1"));
  }
  return absl::OkStatus();
}

absl::Status CheckFix(const Fix& fix) {
  if (absl::Status status = CheckTime(fix.capture_time); !status.ok()) {
    return status;
  }
  if (absl::Status status =
          CheckPose("world_from_camera", fix.world_from_camera);
      !status.ok()) {
    return status;
  }
  if (!IsCovariance(fix.covariance)) {
    return absl::InvalidArgumentError(
        "covariance: is not finite, symmetric and positive semidefinite");
  }
  if (!(fix.confidence >= 0 && fix.confidence <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("confidence: ", fix.confidence, " is not in [0, 1]"));
  }
  return absl::OkStatus();
}

}  // namespace

std::string_view NameOf(DriftState state) {
  switch (state) {
    case DriftState::kSearching:
      return "searching";
    case DriftState::kTentative:
      return "tentative";
    case DriftState::kLocked:
      return "locked";
    case DriftState::kLost:
      return "lost";
  }
  return "";
}

std::string_view NameOf(FixVerdict verdict) {
  switch (verdict) {
    case FixVerdict::kApplied:
      return "applied";
    case FixVerdict::kLocked:
      return "locked";
    case FixVerdict::kJumped:
      return "jumped";
    case FixVerdict::kHeld:
      return "held";
    case FixVerdict::kIgnoredConfidence:
      return "ignored_confidence";
    case FixVerdict::kIgnoredUncertain:
      return "ignored_uncertain";
    case FixVerdict::kIgnoredUntracked:
      return "ignored_untracked";
    case FixVerdict::kIgnoredRepeated:
      return "ignored_repeated";
  }
  return "";
}

// The algorithm, on input that was checked.
class DriftCorrector::Core {
 public:
  explicit Core(const DriftOptions& options)
      : options_(options), history_(options_), shown_(options_) {}
  // Its members refer to its options.
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;

  const TrackHistory& history() const { return history_; }
  const ShownWorld& shown() const { return shown_; }
  DriftState state() const;
  DriftEstimate Track(nanoseconds time, const Rigid3& device_from_camera);
  FixVerdict AddFix(const Fix& fix);
  void Reset();

 private:
  // The fix where the camera is now; nullopt: nothing was tracked then.
  std::optional<CarriedFix> Carry(const Fix& fix) const;
  // Whether a fix is close enough to be believed alone.
  bool IsBelievedAlone(const CarriedFix& fix) const;
  // The hypothesis that the fix agrees with best, or a new one.
  const Hypothesis& HypothesisOf(const CarriedFix& fix);
  // Whether a hypothesis is to be the world: it has enough support, more than
  // any other.
  bool Wins(const Hypothesis& hypothesis) const;
  // The world has a fix: what contradicted it must begin again.
  void NoteGoodFix(const CarriedFix& fix);
  // What is too old to count.
  void Forget(nanoseconds now);
  void NoticeLoss(nanoseconds now);
  DriftEstimate EstimateAt(const TrackedPose& now) const;

  const DriftOptions options_;
  TrackHistory history_;
  ShownWorld shown_;
  std::optional<Hypothesis> world_;
  bool is_lost_ = false;
  std::vector<Hypothesis> others_;
  std::optional<nanoseconds> good_fix_;
  // Capture times, within the history, of the fixes that have counted.
  std::set<nanoseconds> counted_;
};

DriftState DriftCorrector::Core::state() const {
  if (world_.has_value()) {
    return is_lost_ ? DriftState::kLost : DriftState::kLocked;
  }
  return others_.empty() ? DriftState::kSearching : DriftState::kTentative;
}

DriftEstimate DriftCorrector::Core::Track(nanoseconds time,
                                          const Rigid3& device_from_camera) {
  const bool tracking_broke = history_.IsBroken(time, device_from_camera);
  if (tracking_broke) Reset();
  std::optional<TrackedPose> last;
  if (history_.newest() != nullptr) last = *history_.newest();
  const TrackedPose& now = history_.Add(time, device_from_camera);
  if (last.has_value()) {
    const geometry::PoseCovariance drift = history_.Drift(*last, now);
    if (world_.has_value()) world_->Follow(*last, now, drift);
    for (Hypothesis& other : others_) other.Follow(*last, now, drift);
  }
  Forget(time);
  NoticeLoss(time);
  bool snapped = false;
  if (world_.has_value()) {
    // There is no world without an earlier pose.
    snapped = shown_.Step(world_->pose().world_from_camera, device_from_camera,
                          SecondsBetween(last->time, time));
  }
  DriftEstimate estimate = EstimateAt(now);
  estimate.snapped = snapped;
  estimate.tracking_broke = tracking_broke;
  return estimate;
}

FixVerdict DriftCorrector::Core::AddFix(const Fix& fix) {
  if (fix.confidence < options_.min_confidence) {
    return FixVerdict::kIgnoredConfidence;
  }
  if (PositionSigma_m(fix.covariance) > options_.max_fix_sigma_m ||
      RotationSigma_rad(fix.covariance) > Radians(options_.max_fix_sigma_deg)) {
    return FixVerdict::kIgnoredUncertain;
  }
  const std::optional<CarriedFix> carried = Carry(fix);
  if (!carried.has_value()) return FixVerdict::kIgnoredUntracked;
  if (!counted_.insert(fix.capture_time).second) {
    return FixVerdict::kIgnoredRepeated;
  }
  if (world_.has_value() && IsBelievedAlone(*carried)) {
    world_->Support(*carried);
    NoteGoodFix(*carried);
    return FixVerdict::kApplied;
  }
  const Hypothesis& hypothesis = HypothesisOf(*carried);
  if (!Wins(hypothesis)) return FixVerdict::kHeld;
  const FixVerdict verdict =
      world_.has_value() ? FixVerdict::kJumped : FixVerdict::kLocked;
  // What was lost is not moved: it begins anew.
  if (is_lost_) shown_.Clear();
  world_ = hypothesis;
  NoteGoodFix(*carried);
  return verdict;
}

void DriftCorrector::Core::Reset() {
  history_.Clear();
  shown_.Clear();
  world_.reset();
  is_lost_ = false;
  others_.clear();
  counted_.clear();
}

std::optional<CarriedFix> DriftCorrector::Core::Carry(const Fix& fix) const {
  const std::optional<TrackedPose> captured = history_.At(fix.capture_time);
  if (!captured.has_value()) return std::nullopt;
  const TrackedPose& newest = *history_.newest();
  const double floor_m = options_.fix_sigma_floor_m;
  const double floor_rad = Radians(options_.fix_sigma_floor_deg);
  const geometry::PoseCovariance covariance = Scaled(
      Sum(fix.covariance, Diagonal(floor_m * floor_m, floor_rad * floor_rad)),
      1 / fix.confidence);
  const Rigid3 world_from_camera = fix.world_from_camera *
                                   captured->device_from_camera.Inverse() *
                                   newest.device_from_camera;
  const geometry::Vec3 moved_in_world =
      world_from_camera.translation - fix.world_from_camera.translation;
  return CarriedFix{
      .now = {world_from_camera, Sum(Transported(covariance, moved_in_world),
                                     history_.Drift(*captured, newest))},
      .confidence = fix.confidence,
      .captured = *captured};
}

bool DriftCorrector::Core::IsBelievedAlone(const CarriedFix& fix) const {
  const PoseDelta delta =
      Difference(world_->pose().world_from_camera, fix.now.world_from_camera);
  return Norm(delta.translation_m) <= options_.max_single_fix_m &&
         Norm(delta.rotation_rad) <= Radians(options_.max_single_fix_deg) &&
         SquaredDistance(world_->pose(), fix.now) <= options_.world_gate;
}

const Hypothesis& DriftCorrector::Core::HypothesisOf(const CarriedFix& fix) {
  Hypothesis* best = nullptr;
  double least = options_.agreement_gate;
  for (Hypothesis& other : others_) {
    const double distance = SquaredDistance(other.pose(), fix.now);
    if (distance <= least) {
      best = &other;
      least = distance;
    }
  }
  if (best != nullptr) {
    best->Support(fix);
    return *best;
  }
  if (std::ssize(others_) == options_.max_hypotheses) {
    others_.erase(
        std::ranges::min_element(others_, {}, &Hypothesis::supported));
  }
  return others_.emplace_back(fix, options_);
}

bool DriftCorrector::Core::Wins(const Hypothesis& hypothesis) const {
  if (std::ranges::any_of(others_, [&hypothesis](const Hypothesis& other) {
        return &other != &hypothesis && other.fixes() >= hypothesis.fixes();
      })) {
    return false;
  }
  const bool is_explained =
      !world_.has_value() || is_lost_ ||
      SquaredDistance(world_->pose(), hypothesis.pose()) <= options_.world_gate;
  return is_explained ? hypothesis.MayLock() : hypothesis.MayContradict();
}

void DriftCorrector::Core::NoteGoodFix(const CarriedFix& fix) {
  good_fix_ =
      std::max(good_fix_.value_or(fix.captured.time), fix.captured.time);
  others_.clear();
  is_lost_ = false;
}

void DriftCorrector::Core::Forget(nanoseconds now) {
  std::erase_if(others_, [&](const Hypothesis& other) {
    return SecondsBetween(other.supported(), now) >
           options_.hypothesis_lifetime_s;
  });
  counted_.erase(counted_.begin(),
                 counted_.lower_bound(history_.oldest()->time));
}

void DriftCorrector::Core::NoticeLoss(nanoseconds now) {
  if (!world_.has_value()) return;
  const geometry::PoseCovariance& covariance = world_->pose().covariance;
  if (SecondsBetween(*good_fix_, now) > options_.lost_after_s ||
      PositionSigma_m(covariance) > options_.lost_sigma_m ||
      RotationSigma_rad(covariance) > Radians(options_.lost_sigma_deg)) {
    is_lost_ = true;
  }
}

DriftEstimate DriftCorrector::Core::EstimateAt(const TrackedPose& now) const {
  DriftEstimate estimate;
  estimate.state = state();
  if (good_fix_.has_value()) {
    estimate.since_good_fix_s = SecondsBetween(*good_fix_, now.time);
  }
  if (!world_.has_value()) return estimate;
  estimate.world_from_device = shown_.world_from_device();
  estimate.world_from_camera =
      *shown_.world_from_device() * now.device_from_camera;
  const geometry::PoseCovariance& covariance = world_->pose().covariance;
  estimate.position_sigma_m = PositionSigma_m(covariance);
  estimate.rotation_sigma_deg = Degrees(RotationSigma_rad(covariance));
  for (const Hypothesis& other : others_) {
    estimate.contradicting_views =
        std::max(estimate.contradicting_views, other.contradiction_views());
  }
  return estimate;
}

absl::StatusOr<DriftCorrector> DriftCorrector::Create(
    const DriftOptions& options) {
  if (absl::Status status = options.Validate(); !status.ok()) return status;
  return DriftCorrector(std::make_unique<Core>(options));
}

DriftCorrector::DriftCorrector(std::unique_ptr<Core> core)
    : core_(std::move(core)) {}
DriftCorrector::DriftCorrector(DriftCorrector&&) noexcept = default;
DriftCorrector& DriftCorrector::operator=(DriftCorrector&&) noexcept = default;
DriftCorrector::~DriftCorrector() = default;

absl::StatusOr<DriftEstimate> DriftCorrector::Track(
    nanoseconds time, const Rigid3& device_from_camera) {
  if (absl::Status status = CheckTime(time); !status.ok()) return status;
  if (absl::Status status = CheckPose("device_from_camera", device_from_camera);
      !status.ok()) {
    return status;
  }
  const TrackedPose* last = core_->history().newest();
  if (last != nullptr && time <= last->time) {
    return absl::InvalidArgumentError(absl::StrCat("time: ", time.count(),
                                                   " ns is not later than ",
                                                   last->time.count(), " ns"));
  }
  return core_->Track(time, {Normalized(device_from_camera.rotation),
                             device_from_camera.translation});
}

absl::StatusOr<FixVerdict> DriftCorrector::AddFix(const Fix& fix) {
  if (absl::Status status = CheckFix(fix); !status.ok()) return status;
  Fix normalized = fix;
  normalized.world_from_camera.rotation =
      Normalized(fix.world_from_camera.rotation);
  return core_->AddFix(normalized);
}

void DriftCorrector::Reset() { core_->Reset(); }

DriftState DriftCorrector::state() const { return core_->state(); }

const std::optional<Rigid3>& DriftCorrector::world_from_device() const {
  return core_->shown().world_from_device();
}

}  // namespace treeline::drift
