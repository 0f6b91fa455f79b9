// Numbers put into a YAML file that people have written.
#ifndef NAV_AGENT_CALIBRATION_ROBOT_FILE_EDIT_H_
#define NAV_AGENT_CALIBRATION_ROBOT_FILE_EDIT_H_

#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/calibration/calibration_text.h"

namespace treeline::calibration {

// `text` with the entries: values that are there are replaced, keys that are
// missing are added; comments and everything else stay as they are. Sections
// may be written over lines or in braces. INVALID_ARGUMENT if `text` is no
// YAML map; FAILED_PRECONDITION if what comes out does not say what it is to
// say, as where an alias or a tag stands: the message tells which key to change
// by hand.
absl::StatusOr<std::string> WithEntries(absl::string_view text,
                                        absl::string_view name,
                                        std::span<const FileEntry> entries);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_ROBOT_FILE_EDIT_H_
