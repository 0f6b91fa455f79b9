// Whether a query's focal length is another than the stated one, by what was
// seen.
#ifndef SERVER_CORE_LOCALIZER_FOCAL_DOUBT_H_
#define SERVER_CORE_LOCALIZER_FOCAL_DOUBT_H_

#include <optional>

#include "server/core/localizer/assumed_lens.h"
#include "server/core/pose/focal_estimate.h"

namespace treeline::localizer {

// What a query's candidates say of its focal length.
struct FocalEvidence {
  // The one that most matched features support.
  std::optional<pose::FocalEstimate> features = std::nullopt;
  // Points that the colour camera measured.
  std::optional<pose::FocalEstimate> points = std::nullopt;
  // The same features', where no camera is stated, or a guess.
  std::optional<AssumedLens> lens = std::nullopt;
};

struct OtherFocal {
  double scale = 1;  // of the stated one
  // How many times the odds of the answer with the stated one those with this
  // one have to be.
  double needed_odds = 1;
};

// How much it takes to give up the focal length that a query states.
class FocalDoubt {
 public:
  // One that may be a guess is given up for little. Features state standard
  // deviations that are `sigma_scale` times too small (ConfidenceModel); points
  // state what they are.
  FocalDoubt(bool may_be_guessed, double sigma_scale);

  // nullopt: it may well be the stated one.
  std::optional<OtherFocal> Other(const FocalEvidence& evidence) const;

 private:
  std::optional<OtherFocal> Other(const pose::FocalEstimate& focal,
                                  double min_known_sigmas,
                                  double sure_known_sigmas) const;

  const bool may_be_guessed_;
  const double sigma_scale_;
};

// Whether features say that a guess is right, with a standard deviation of the
// logarithm of at most `max_sigma`.
bool IsGuessConfirmed(const FocalEvidence& evidence, double max_sigma);

// By how many of its standard deviations the stated focal length is off.
double ErrorSigmas(const pose::FocalEstimate& focal);

// Whether points alone say that it is worth looking at features, too.
bool DoubtsFocal(const pose::FocalEstimate& points);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_FOCAL_DOUBT_H_
