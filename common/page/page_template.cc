#include "common/page/page_template.h"

#include <cstddef>
#include <cstdint>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::page {
namespace {

// A JSON text, so that the template's data is valid before it is filled in.
constexpr absl::string_view kPlace = "\"@REPORT_DATA@\"";

constexpr uint64_t kMaxTemplateBytes = uint64_t{64} << 20;

}  // namespace

absl::StatusOr<std::string> FillPageTemplate(absl::string_view page,
                                             absl::string_view json) {
  const size_t place = page.find(kPlace);
  if (place == absl::string_view::npos ||
      page.find(kPlace, place + 1) != absl::string_view::npos) {
    return absl::InvalidArgumentError(
        "no template of a page: it must have one place for the data");
  }
  // In JSON, < stands in strings alone: neither "</script" nor "<!--" is left.
  return absl::StrCat(page.substr(0, place),
                      absl::StrReplaceAll(json, {{"<", "\\u003c"}}),
                      page.substr(place + kPlace.size()));
}

std::string PageDataPath(const std::string& path) {
  const absl::string_view ending = ".html";
  const size_t size =
      absl::EndsWith(path, ending) ? path.size() - ending.size() : path.size();
  return path.substr(0, size) + ".data.json";
}

std::string NoPageTemplateNotice(const std::string& path,
                                 const std::string& script) {
  return absl::StrCat("There is no template of report pages here, so that ",
                      path, " is not written: the report's data goes to ",
                      PageDataPath(path), ".\n", script,
                      " makes the template (with node 18 and npm). Then run "
                      "this again, or open "
                      "the template and choose that file.\n");
}

absl::Status WritePage(const std::string& path, absl::string_view json,
                       const std::string& template_path) {
  if (template_path.empty()) {
    return base::WriteFileAtomically(PageDataPath(path), json);
  }
  TL_ASSIGN_OR_RETURN(const std::string page,
                      base::ReadFile(template_path, kMaxTemplateBytes));
  TL_ASSIGN_OR_RETURN(const std::string filled, FillPageTemplate(page, json));
  return base::WriteFileAtomically(path, filled);
}

}  // namespace treeline::page
