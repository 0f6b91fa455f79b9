// Pieces of HTML that the sections of the evaluation's page are made of. Titles
// and contents are HTML already; values of tables are not.
#ifndef EVALUATION_REPORT_REPORT_PARTS_H_
#define EVALUATION_REPORT_REPORT_PARTS_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "server/tools/model_description.h"

namespace treeline::report {

// A number in printf's format; a dash if there is none.
std::string FormatOrDash(const char* format,
                         const std::optional<double>& value);

// "98.9 %" of a fraction. Only all is 100 %, and only none is 0 %.
std::string PercentText(const std::optional<double>& fraction);

// A figure with its caption.
std::string Tile(absl::string_view value, absl::string_view caption);

// A section's heading, and what it is about.
std::string Heading(absl::string_view title, absl::string_view about);

// A framed box; an empty title is left out.
std::string Card(absl::string_view title, absl::string_view content);

// A table of names and values.
std::string RowsTable(const std::vector<tools::DescriptionRow>& rows);

// The dataset's last path component: "7scenes-redkitchen".
std::string DatasetName(const std::string& uri);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_PARTS_H_
