// The style sheet of the evaluation's page.
#ifndef SERVER_TOOLS_REPORT_STYLE_H_
#define SERVER_TOOLS_REPORT_STYLE_H_

namespace treeline {

// CSS for both themes.
const char* ReportStyle();

}  // namespace treeline

#endif  // SERVER_TOOLS_REPORT_STYLE_H_
