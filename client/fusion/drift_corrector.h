// Fixes of a server and the device's own tracking become one world.
//
// A device tracks itself at every frame, smoothly, in a frame of its own that
// drifts: device_from_camera. A server says where single pictures were taken,
// late and sometimes wrongly: world_from_camera. DriftCorrector keeps
// world_from_device between them, so that
//   world_from_camera = world_from_device * device_from_camera.
// docs/explanation/device-fusion.md has the algorithm, step by step. The
// TypeScript and Java clients have their own implementations; all reproduce
// client/fusion_vectors.
#ifndef CLIENT_FUSION_DRIFT_CORRECTOR_H_
#define CLIENT_FUSION_DRIFT_CORRECTOR_H_

#include <chrono>
#include <memory>
#include <optional>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/fusion/drift_options.h"
#include "common/geometry/rigid3.h"

namespace treeline::drift {

// What the server says of one picture.
struct Fix {
  // When the picture was taken, on the clock of Track.
  std::chrono::nanoseconds capture_time{0};
  geometry::Rigid3 world_from_camera;
  // As relocalizer::LocalizeAnswer has it.
  geometry::PoseCovariance covariance{};
  double confidence = 0;  // in [0, 1]
};

enum class DriftState {
  kSearching,  // nothing is known
  kTentative,  // fixes wait for others that agree
  kLocked,     // world_from_device holds
  kLost,       // it is the last that was known, and may be wrong
};

// "searching", ...: as client/fusion_vectors has them.
std::string_view NameOf(DriftState state);

// What became of a fix.
enum class FixVerdict {
  kApplied,            // it corrected the world
  kLocked,             // with it the world began
  kJumped,             // with it others won over the world that was
  kHeld,               // it waits for others that agree
  kIgnoredConfidence,  // too little confidence
  kIgnoredUncertain,   // too uncertain
  kIgnoredUntracked,   // captured when nothing was tracked
  kIgnoredRepeated,    // of a picture that has counted already
};

// "applied", ..., "ignored_confidence", ...
std::string_view NameOf(FixVerdict verdict);

// What is known at the time of a tracked pose.
struct DriftEstimate {
  DriftState state = DriftState::kSearching;
  // For drawing: smooth. nullopt while searching or tentative.
  std::optional<geometry::Rigid3> world_from_device;
  // The same for the tracked pose.
  std::optional<geometry::Rigid3> world_from_camera;
  // Of world_from_camera as it is known, to which the drawn one moves: largest
  // standard deviations along and about an axis of the world. nullopt: there is
  // no world.
  std::optional<double> position_sigma_m;
  std::optional<double> rotation_sigma_deg;
  // Since the last fix that the world was built on was captured. nullopt: there
  // was none yet.
  std::optional<double> since_good_fix_s;
  // Distinct views of the fixes that speak most against the world; counted up
  // to contradiction_views.
  int contradicting_views = 0;
  // Whether world_from_device was set at once, not moved.
  bool snapped = false;
  // Whether tracking began anew with this pose, by a gap or a jump.
  bool tracking_broke = false;
};

// Pure: it has no clock, no threads and draws no random numbers. The same calls
// give the same results. Not thread-safe. A moved-from one can only be assigned
// to or destroyed.
//
// Times are nanoseconds on any clock that never goes back, within 146 years of
// its epoch. What is refused, with INVALID_ARGUMENT, changes nothing.
class DriftCorrector {
 public:
  // INVALID_ARGUMENT names the first option that makes no sense.
  static absl::StatusOr<DriftCorrector> Create(
      const DriftOptions& options = {});

  DriftCorrector(DriftCorrector&&) noexcept;
  DriftCorrector& operator=(DriftCorrector&&) noexcept;
  ~DriftCorrector();

  // The device's tracking, each frame, in the order of time.
  // INVALID_ARGUMENT: a time that is not later than the last one, a number that
  // is not finite, or a rotation whose norm is further than 0.01 from 1.
  absl::StatusOr<DriftEstimate> Track(
      std::chrono::nanoseconds time,
      const geometry::Rigid3& device_from_camera);

  // A fix, as soon as the server has answered: late and out of order is fine
  // within history_s. Of several fixes of one capture time the first counts.
  // INVALID_ARGUMENT: a number that is not finite, a rotation whose norm is
  // further than 0.01 from 1, a covariance that is not symmetric and positive
  // semidefinite (it may be singular), a confidence outside of [0, 1].
  absl::StatusOr<FixVerdict> AddFix(const Fix& fix);

  // Tracking began anew: poses from now on are in another device frame. All is
  // forgotten but the time of the last good fix.
  void Reset();

  DriftState state() const;

  // As the last estimate has it; nullopt too if the next one will set it at
  // once.
  const std::optional<geometry::Rigid3>& world_from_device() const;

 private:
  class Core;
  explicit DriftCorrector(std::unique_ptr<Core> core);

  std::unique_ptr<Core> core_;
};

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_DRIFT_CORRECTOR_H_
