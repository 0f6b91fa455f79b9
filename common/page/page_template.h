// Pages of results: a template, one HTML file that scripts made with node and
// npm, with a program's data in its place.
#ifndef COMMON_PAGE_PAGE_TEMPLATE_H_
#define COMMON_PAGE_PAGE_TEMPLATE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::page {

// The template with `json` as its data, escaped so that no text in it can end
// the element that holds it. INVALID_ARGUMENT: `page` has not just one place
// for the data.
absl::StatusOr<std::string> FillPageTemplate(absl::string_view page,
                                             absl::string_view json);

// Where the data of a page goes that is to be at `path`, where there is no
// template: "kitchen.data.json" of "kitchen.html".
std::string PageDataPath(const std::string& path);

// For people: that there is no template, where the data goes, and how a page is
// made of it. `script`: what makes the template, like "scripts/build-report".
std::string NoPageTemplateNotice(const std::string& path,
                                 const std::string& script);

// Writes the page to `path`, or the data to PageDataPath(path) if
// template_path is empty.
absl::Status WritePage(const std::string& path, absl::string_view json,
                       const std::string& template_path);

}  // namespace treeline::page

#endif  // COMMON_PAGE_PAGE_TEMPLATE_H_
