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

// Lines as base::CheckedLinesText has them, one for each dock, and one after it
// with what is seen from it, if anything is, in the docked base:
//
//   treeline-docks 2
//   dock LEVEL X_M Y_M YAW_RAD forward|backward STAGING_M NAME
//   seen X_MM Y_MM X_MM Y_MM ...
std::string DockFileText(std::span<const Dock> docks);
// Docks as they were written, bit for bit but for views, which are in whole
// millimetres. Version 1 has no views. INVALID_ARGUMENT says which line is
// wrong, or that the file was cut off or changed. Safe on any bytes.
absl::StatusOr<std::vector<Dock>> ParseDockFile(absl::string_view text);

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_DOCK_FILE_H_
