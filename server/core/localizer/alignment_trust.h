// Which of two to believe where they differ: matched features, or the alignment
// with keyframes that began with their pose.
#ifndef SERVER_CORE_LOCALIZER_ALIGNMENT_TRUST_H_
#define SERVER_CORE_LOCALIZER_ALIGNMENT_TRUST_H_

#include "server/core/localizer/candidate.h"

namespace treeline::localizer {

// Whether alignment, which moved a candidate with a pose by moved_m, was drawn
// away from it: many features leave so little doubt of the pose that it cannot
// be so far off. Alignment compares brightness with one gain and offset a
// keyframe, so what covers a part of the picture, or lights it, draws it aside;
// features match where they are seen, or not at all.
bool IsDrawnAway(const Candidate& candidate, double moved_m);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_ALIGNMENT_TRUST_H_
