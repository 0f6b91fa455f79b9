#include "nav_agent/mapping/loop_closer_options.h"

namespace treeline::mapping {

absl::Status LoopCloserOptions::Validate() const {
  if (recent < 1 || min_chain < 1 || max_chain < min_chain || max_chains < 1 ||
      query_scans < 1 || threads < 1 || !(overlap_m > 0) ||
      !(search_sigmas > 0) || !(search_of_way >= 0) || !(min_search_m > 0) ||
      !(max_search_m >= min_search_m) || !(max_search_m <= 20) ||
      !(min_search_rad > 0) || !(max_search_rad >= min_search_rad) ||
      !(max_search_rad <= 3.2) || !(max_squared_error > 0) ||
      !(max_gap_m > 0) || !(max_gap_m_per_m >= 0) ||
      !(largest_gap_m >= max_gap_m) || !(max_tilt > 0) ||
      !(same_ground_m >= 0) || !suspects.IsValid() || !bundle.IsValid()) {
    return absl::InvalidArgumentError(
        "loop closer: counts and lengths must be above 0, and the largest "
        "search at least the smallest, at most 20 m and 3.2 rad");
  }
  return absl::OkStatus();
}

}  // namespace treeline::mapping
