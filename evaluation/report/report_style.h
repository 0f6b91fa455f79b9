// The style sheet of the evaluation's page.
#ifndef EVALUATION_REPORT_REPORT_STYLE_H_
#define EVALUATION_REPORT_REPORT_STYLE_H_

namespace treeline::report {

// CSS for both themes.
const char* ReportStyle();

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_STYLE_H_
