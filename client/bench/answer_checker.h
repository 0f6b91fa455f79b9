// Whether a server under load still says what is right.
#ifndef CLIENT_BENCH_ANSWER_CHECKER_H_
#define CLIENT_BENCH_ANSWER_CHECKER_H_

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/geometry/rigid3.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::bench {

// An answer is compared, bit for bit and in everything but its timings, with
// the answer that the same query had from the same model version before the
// load; if there was none, with the first one under load. Where the true pose
// is known, it is compared with that too. Thread-safe.
class AnswerChecker {
 public:
  struct Tolerance {
    double position_m = 0.05;
    double rotation_rad = 0.0872664625997165;  // 5 degrees
  };

  enum class Bits {
    kAsBeforeLoad,
    kAsFirstUnderLoad,
    // The first answer of this version to this query.
    kNew,
    kDifferent,
  };
  struct Verdict {
    Bits bits = Bits::kNew;
    // nullopt: no true pose is known. What is not localized is not within.
    std::optional<bool> within_tolerance = std::nullopt;
    // Localized, and not within tolerance.
    bool wrong_pose = false;
  };

  // truths[i]: of query i, where it is known.
  AnswerChecker(std::vector<std::optional<geometry::Rigid3>> truths,
                const Tolerance& tolerance);

  // From here on answers are compared with those seen so far as "before load".
  void LoadBegins();

  Verdict Check(size_t query, const v1::LocalizeResponse& response);

 private:
  struct Reference {
    std::string bytes;
    bool before_load = false;
  };

  const std::vector<std::optional<geometry::Rigid3>> truths_;
  const Tolerance tolerance_;
  absl::Mutex mutex_;
  bool load_ ABSL_GUARDED_BY(mutex_) = false;
  // By query, scene and model version.
  std::map<std::pair<size_t, std::string>, Reference> references_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_ANSWER_CHECKER_H_
