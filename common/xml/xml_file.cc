#include "common/xml/xml_file.h"

#include <cmath>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace treeline::xml {

absl::Status ParseXml(absl::string_view text, absl::string_view name,
                      const XmlKind& kind, tinyxml2::XMLDocument& document) {
  if (text.size() > kind.max_bytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": longer than ", kind.max_bytes >> 20,
                     " MiB; is it ", kind.name, "?"));
  }
  if (absl::StrContains(text, "<!DOCTYPE") ||
      absl::StrContains(text, "<!ENTITY")) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": document types and entities are not read; ",
                     kind.name, " needs none"));
  }
  // The parser bounds the depth of elements, and knows no entities but those
  // of XML itself.
  if (document.Parse(text.data(), text.size()) == tinyxml2::XML_SUCCESS) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      name, ":", document.ErrorLineNum(), ": ",
      document.ErrorID() == tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED
          ? absl::StrCat("elements within elements, deeper than any ",
                         kind.name)
          : absl::StrCat(
                "this is no XML (",
                tinyxml2::XMLDocument::ErrorIDToName(document.ErrorID()),
                ")")));
}

absl::Status ErrorAt(const tinyxml2::XMLElement& at, absl::string_view name,
                     absl::string_view reason) {
  return absl::InvalidArgumentError(
      absl::StrCat(name, ":", at.GetLineNum(), ": ", reason));
}

bool ParseNumbers(absl::string_view text, double min, double max,
                  std::span<double> values) {
  const std::vector<absl::string_view> parts =
      absl::StrSplit(text, absl::ByAnyChar(" \t\r\n"), absl::SkipEmpty());
  if (parts.size() != values.size()) return false;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (!absl::SimpleAtod(parts[i], &values[i]) || !std::isfinite(values[i]) ||
        values[i] < min || values[i] > max) {
      return false;
    }
  }
  return true;
}

}  // namespace treeline::xml
