// The picture of where a scene will work.
#ifndef SERVER_TOOLS_COVERAGE_PICTURE_H_
#define SERVER_TOOLS_COVERAGE_PICTURE_H_

#include <string>

#include "common/image/image.h"
#include "server/core/keyframes/coverage.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::tools {

// The plan from above, to scale: open places coloured by the share of headings
// from which queries will be answered, a fan of those headings where there is
// room for it; the scene's points in grey, walls and edges darker; the training
// cameras. Around it `title`, what the colours mean, a scale and the figures.
image::ColorImage DrawCoverage(const keyframes::KeyframeMap& map,
                               const keyframes::CoverageMap& coverage,
                               const std::string& title);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_COVERAGE_PICTURE_H_
