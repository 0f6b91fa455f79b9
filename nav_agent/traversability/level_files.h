// Traversable maps on disk.
#ifndef NAV_AGENT_TRAVERSABILITY_LEVEL_FILES_H_
#define NAV_AGENT_TRAVERSABILITY_LEVEL_FILES_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/image/image.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::traversability {

// A picture for people, rows from the top: free cells are white and, with
// growing slope up to max_slope_rad, green to yellow; occupied ones black,
// the edges of drops red, unknown ones grey; joins to other levels blue.
image::ColorImage PictureOfLevel(const TraversableMap& map, int level,
                                 double max_slope_rad);

// Writes into `folder`, which is made, for each level N from 0:
//   level-N.yaml, level-N.pgm   the map (map_server)
//   level-N-height.pgm, -slope.pgm, -clearance.pgm   16-bit layers
//   level-N.png                 PictureOfLevel
// and layers.yaml, which says what the layers' values mean and names the joins.
// Each file is replaced atomically.
absl::Status WriteTraversableMap(const TraversableMap& map,
                                 double max_slope_rad,
                                 const std::string& folder);

// What `treeline-agent traversability` does.
struct TraversabilityCommand {
  std::string octomap_path;  // .bt or .ot
  std::string output_folder;
  TraversabilityOptions options;
  double occupied_threshold = 0.7;  // of .ot files, in (0, 1)

  absl::Status Validate() const;
};

struct TraversabilitySummary {
  int levels = 0;
  int joins = 0;
  int64_t free_cells = 0;
  int64_t occupied_cells = 0;
  double extraction_ms = 0;
};

// Reads, extracts, writes.
absl::StatusOr<TraversabilitySummary> RunTraversability(
    const TraversabilityCommand& command);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_LEVEL_FILES_H_
