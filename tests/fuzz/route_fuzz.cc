// Routes and progress as arbitrary bytes: read or refused, and what is read is
// written as it was. An input is the text of a file; or, after a byte 1 or 2,
// lines that get the first and last one of a file of routes, or of progress.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "absl/strings/str_split.h"
#include "common/base/checked_lines.h"
#include "nav_agent/routes/route_file.h"

namespace treeline {
namespace {

std::string WithEnds(const char* first_line, const std::string& lines) {
  return base::CheckedLinesText(first_line, absl::StrSplit(lines, '\n'));
}

// Not compared: NaN is not itself.
void CheckRoutes(const std::string& text) {
  const auto read = routes::ParseRouteFile(text);
  if (!read.ok()) return;
  const std::string written = routes::RouteFileText(*read);
  const auto again = routes::ParseRouteFile(written);
  if (!again.ok() || routes::RouteFileText(*again) != written) std::abort();
  (void)routes::CheckRoutes(*read, 2);
}

void CheckProgress(const std::string& text) {
  const auto read = routes::ParseProgressFile(text);
  if (!read.ok() || !read->has_value()) return;
  const routes::RouteProgress& progress = **read;
  if (progress.waypoint >= progress.route->waypoints.size()) std::abort();
  const auto again =
      routes::ParseProgressFile(routes::ProgressFileText(progress));
  if (!again.ok() || !again->has_value()) std::abort();
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (size > 0 && (data[0] == 1 || data[0] == 2)) {
    const std::string lines = text.substr(1);
    if (data[0] == 1) {
      treeline::CheckRoutes(treeline::WithEnds("treeline-routes 1", lines));
    } else {
      treeline::CheckProgress(
          treeline::WithEnds("treeline-route-progress 1", lines));
    }
    return 0;
  }
  treeline::CheckRoutes(text);
  treeline::CheckProgress(text);
  return 0;
}
