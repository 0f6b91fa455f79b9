// Where a scene will work: for camera places on a plan and headings there,
// whether a query would be answered. Predicted from the keyframes alone.
#ifndef SERVER_CORE_KEYFRAMES_COVERAGE_H_
#define SERVER_CORE_KEYFRAMES_COVERAGE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "server/core/keyframes/keyframe_map.h"

namespace treeline::keyframes {

struct CoverageOptions {
  // Headings at each place, evenly spread from the plan's x axis to its y
  // axis, in [4, 32].
  int headings = 16;
  // Cells are as small as gives about so many in the scene's outline, in
  // [16, 1000000], ...
  int places = 2500;
  // ... and at least 0.1 m and at most this wide, in [0.1, 10] (m).
  double max_cell_m = 0.25;
  // 0: one a processor.
  int threads = 0;

  absl::Status Validate() const;
};

// What is predicted of a query there.
enum class Coverage { kNone, kWeak, kGood };
Coverage CoverageOf(double support);

// A place for a camera. Bit h of the masks is heading h.
struct CoveragePlace {
  // Whether a camera may well be there: a training camera was near, or some
  // looked through it. Elsewhere the masks are 0.
  bool is_open = false;
  uint32_t good = 0;
  uint32_t weak = 0;
};

struct CoverageMap {
  // See PlanFromWorld. Coordinates below are the plan's.
  geometry::Rotation3 plan_from_world = {};
  // Least corner of the grid (m); place (column, row) is row * columns + column
  // and its camera in the middle of the cell.
  double min_x_m = 0;
  double min_y_m = 0;
  double cell_m = 0;
  int columns = 0;
  int rows = 0;
  int headings = 0;
  // Of the predicted cameras: the medians of the training cameras'. The height
  // is z in the plan; ground_m is that of the lowest surfaces. Tilt is upwards.
  double height_m = 0;
  double ground_m = 0;
  double tilt_rad = 0;
  std::vector<CoveragePlace> places = {};

  // The azimuth of heading h (rad).
  double Heading_rad(int h) const;
};

struct CoverageSummary {
  // Of the open places (m^2).
  double open_m2 = 0;
  // Of the views from them: places times headings.
  double good_share = 0;
  double weak_share = 0;
  // Of the open places: with good coverage for any heading, and for all.
  double any_heading_share = 0;
  double all_headings_share = 0;
};

// FAILED_PRECONDITION: the model has no keyframes; INVALID_ARGUMENT: options.
// `camera` takes the queries, as if by a lens without distortion. The result
// does not depend on threads.
absl::StatusOr<CoverageMap> PredictCoverage(const KeyframeMap& map,
                                            const camera::Camera& camera,
                                            const CoverageOptions& options);

CoverageSummary Summarize(const CoverageMap& coverage);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_COVERAGE_H_
