// Pictures of cameras that read their rows one after the other, taken while the
// camera turned.
#ifndef SERVER_CORE_LOCALIZER_SHUTTER_CORRECTION_H_
#define SERVER_CORE_LOCALIZER_SHUTTER_CORRECTION_H_

#include <optional>

#include "common/geometry/rigid3.h"
#include "common/image/rolling_shutter.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/localizer/query.h"
#include "server/core/pose/turn_estimate.h"

namespace treeline::localizer {

// How the query's colour camera turned, by features of the keyframes about the
// pose that was found. nullopt: it is not to be told, or so little that rows
// are where they would be anyway.
std::optional<pose::TurnEstimate> MeasureTurn(
    Query& query, const keyframes::KeyframeMap& map,
    const image::RollingShutter& shutter,
    const geometry::Rigid3& world_from_color);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_SHUTTER_CORRECTION_H_
