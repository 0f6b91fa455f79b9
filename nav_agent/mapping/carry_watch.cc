#include "nav_agent/mapping/carry_watch.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::mapping {
namespace {

// So many keyscans are asked.
constexpr size_t kAsked = 4;

double Tilt_rad(const geometry::Rotation3& level_from_base) {
  const geometry::Vec3 up = level_from_base * geometry::Vec3{0, 0, 1};
  return std::atan2(std::hypot(up.x, up.y), up.z);
}

}  // namespace

bool CarryWatchOptions::IsValid() const {
  return poor_response > 0 && very_poor_response >= poor_response &&
         max_contradicted >= 0 && max_contradicted_standing >= 0 &&
         min_told > 0 && lifted_rad > 0 && min_scans > 0 && min_s >= 0 &&
         changed_share > 0 && changed_m > 0;
}

bool CarryWatch::IsDoubtful(const Evidence& evidence) const {
  if (Tilt_rad(evidence.level_from_base) > options_.lifted_rad) return true;
  const double poorer = evidence.usual_response - evidence.response;
  const bool is_poor = poorer > options_.poor_response;
  if (!evidence.stands &&
      (in_doubt() ? evidence.is_found_widely || is_poor
                  : evidence.is_found_widely &&
                        poorer > options_.very_poor_response)) {
    return true;
  }
  if (!is_poor) return false;
  const Contradictions found = ContradictionsWith(
      evidence.keyscans.last(std::min(kAsked, evidence.keyscans.size())),
      *evidence.scan, evidence.map_from_base);
  return found.told >= options_.min_told &&
         found.Share() > (evidence.stands ? options_.max_contradicted_standing
                                          : options_.max_contradicted);
}

bool CarryWatch::Add(bool is_doubtful, recording::RecordingTime stamp) {
  if (!is_doubtful) {
    scans_ = 0;
    return false;
  }
  if (scans_++ == 0) since_ = stamp;
  return scans_ >= options_.min_scans &&
         recording::SecondsBetween(since_, stamp) >= options_.min_s;
}

bool CarryWatch::HasChanged(std::span<const float> ranges_m) const {
  if (ranges_m.size() != noted_m_.size()) return false;
  int told = 0;
  int changed = 0;
  for (size_t i = 0; i < ranges_m.size(); ++i) {
    if (!std::isfinite(ranges_m[i]) || !std::isfinite(noted_m_[i])) continue;
    ++told;
    changed += std::abs(ranges_m[i] - noted_m_[i]) > options_.changed_m ? 1 : 0;
  }
  return told >= options_.min_told &&
         changed > options_.changed_share * static_cast<double>(told);
}

}  // namespace treeline::mapping
