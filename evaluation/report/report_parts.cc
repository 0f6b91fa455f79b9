#include "evaluation/report/report_parts.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "evaluation/report/report_svg.h"

namespace treeline::report {

std::string FormatOrDash(const char* format,
                         const std::optional<double>& value) {
  return value ? tools::FormatNumber(format, *value) : "–";
}

std::string PercentText(const std::optional<double>& fraction) {
  if (!fraction) return "–";
  if (*fraction == 0 || *fraction == 1) {
    return absl::StrFormat("%.0f %%", 100 * *fraction);
  }
  // One lost frame in a thousand is not none.
  return absl::StrFormat("%.1f %%", std::clamp(100 * *fraction, 0.1, 99.9));
}

std::string Tile(absl::string_view value, absl::string_view caption) {
  return absl::StrCat("<div class=\"tile\"><b>", value, "</b><span>", caption,
                      "</span></div>\n");
}

std::string Heading(absl::string_view title, absl::string_view about) {
  return absl::StrCat("<h2>", title, "</h2>\n<p class=\"about\">", about,
                      "</p>\n");
}

std::string Card(absl::string_view title, absl::string_view content) {
  return absl::StrCat("<div class=\"card\">",
                      title.empty() ? "" : absl::StrCat("<h3>", title, "</h3>"),
                      content, "</div>\n");
}

std::string DatasetName(const std::string& uri) {
  std::string name = uri;
  while (!name.empty() && name.back() == '/') name.pop_back();
  const size_t cut = name.find_last_of("/:");
  std::string last = cut == std::string::npos ? name : name.substr(cut + 1);
  // "tum-fr1-rpy/test" says more than "test".
  if (cut != std::string::npos && name[cut] == '/' && last.size() < 6) {
    const size_t before = name.find_last_of("/:", cut - 1);
    if (before != std::string::npos) last = name.substr(before + 1);
  }
  return last;
}

std::string RowsTable(const std::vector<tools::DescriptionRow>& rows) {
  std::string html = "<div class=\"scroll\"><table><tbody>";
  for (const auto& [name, value] : rows) {
    absl::StrAppend(&html, "<tr><th>", EscapeHtml(name), "</th><td>",
                    EscapeHtml(value), "</td></tr>\n");
  }
  return html + "</tbody></table></div>";
}

}  // namespace treeline::report
