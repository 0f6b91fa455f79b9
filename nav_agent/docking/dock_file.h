// Docks as bytes that outlive the program.
#ifndef NAV_AGENT_DOCKING_DOCK_FILE_H_
#define NAV_AGENT_DOCKING_DOCK_FILE_H_

#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/docking/dock.h"

namespace treeline::docking {

// Lines as base::CheckedLinesText has them, one for each dock:
//
//   treeline-docks 1
//   dock LEVEL X_M Y_M YAW_RAD forward|backward STAGING_M NAME
std::string DockFileText(std::span<const Dock> docks);
// Docks as they were written, bit for bit. INVALID_ARGUMENT says which line is
// wrong, or that the file was cut off or changed. Safe on any bytes.
absl::StatusOr<std::vector<Dock>> ParseDockFile(absl::string_view text);

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_DOCK_FILE_H_
