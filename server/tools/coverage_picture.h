// The picture of where a scene will work.
#ifndef SERVER_TOOLS_COVERAGE_PICTURE_H_
#define SERVER_TOOLS_COVERAGE_PICTURE_H_

#include <optional>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "server/core/keyframes/coverage.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::tools {

// What else is drawn on the plan, in its coordinates (m, rad).
struct CoverageMarks {
  // A letter in a circle, with an arrow where there is a direction.
  struct Letter {
    std::string text{};
    double x_m = 0;
    double y_m = 0;
    std::optional<double> towards_rad{};
  };
  struct Cross {
    double x_m = 0;
    double y_m = 0;
  };
  std::vector<Letter> letters{};
  std::vector<Cross> crosses{};
};

// The plan from above, to scale: open places coloured by the share of headings
// from which queries will be answered, a fan of those headings where there is
// room for it; the scene's points in grey, walls and edges darker; the training
// cameras; `marks`. Around it `title`, what the colours mean, a scale and the
// figures.
image::ColorImage DrawCoverage(const keyframes::KeyframeMap& map,
                               const keyframes::CoverageMap& coverage,
                               const std::string& title,
                               const CoverageMarks& marks = {});

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_COVERAGE_PICTURE_H_
