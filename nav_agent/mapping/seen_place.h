// What a server has seen of a lost robot, as an event in the log of its drive:
// the log then maps as the drive did.
#ifndef NAV_AGENT_MAPPING_SEEN_PLACE_H_
#define NAV_AGENT_MAPPING_SEEN_PLACE_H_

#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "common/geometry/rigid3.h"

namespace treeline::mapping {

// "seen at X Y Z QX QY QZ QW": map_from_base (m), in the frame of the map as it
// was then.
std::string SeenPlaceText(const geometry::Rigid3& map_from_base);
// nullopt: another event, or numbers that are no pose.
std::optional<geometry::Rigid3> ParseSeenPlace(absl::string_view text);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SEEN_PLACE_H_
