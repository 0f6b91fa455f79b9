#include "evaluation/report/report_page.h"

#include "common/base/installed_file.h"
#include "common/page/page_template.h"

namespace treeline::report {

std::string FindReportTemplate() {
  return base::FindInstalledFile("report.html", TREELINE_SOURCE_REPORT);
}

std::string ReportDataPath(const std::string& path) {
  return page::PageDataPath(path);
}

std::string NoTemplateNotice(const std::string& path) {
  return page::NoPageTemplateNotice(path, "scripts/build-report");
}

absl::Status WriteReport(const std::string& path, absl::string_view json,
                         const std::string& template_path) {
  return page::WritePage(path, json, template_path);
}

}  // namespace treeline::report
