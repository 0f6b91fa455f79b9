// A report's page: the template that scripts/build-report makes of
// evaluation/report, with the report's data in its place.
#ifndef EVALUATION_REPORT_REPORT_PAGE_H_
#define EVALUATION_REPORT_REPORT_PAGE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace treeline::report {

// The template's file: ../share/treeline/report.html beside this program or
// else where scripts/build-report puts it in the source tree. Empty: in neither
// place.
std::string FindReportTemplate();

// Where the data of a report goes that is to be at `path`, where there is no
// template: "kitchen.data.json" of "kitchen.html".
std::string ReportDataPath(const std::string& path);

// For people: that there is no template, where the data goes, and how a page is
// made of it.
std::string NoTemplateNotice(const std::string& path);

// Writes the page to `path`, or the data to ReportDataPath(path) if
// template_path is empty.
absl::Status WriteReport(const std::string& path, absl::string_view json,
                         const std::string& template_path);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_PAGE_H_
