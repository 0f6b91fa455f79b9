// XML that comes from anywhere: tinyxml2 behind bounds, and errors that name
// file and line.
#ifndef COMMON_XML_XML_FILE_H_
#define COMMON_XML_XML_FILE_H_

#include <tinyxml2.h>

#include <cstddef>
#include <span>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace treeline::xml {

// What a file is said to be.
struct XmlKind {
  absl::string_view name;  // "URDF"
  size_t max_bytes = 0;
};

// Parses the text. INVALID_ARGUMENT, "NAME: reason" or "NAME:LINE: reason": it
// is too long, has a document type or entities (which are never expanded), is
// deeper than 100 elements, or is no XML.
absl::Status ParseXml(absl::string_view text, absl::string_view name,
                      const XmlKind& kind, tinyxml2::XMLDocument& document);

// INVALID_ARGUMENT, "NAME:LINE: reason".
absl::Status ErrorAt(const tinyxml2::XMLElement& at, absl::string_view name,
                     absl::string_view reason);

// Fills `values` from text of as many numbers with white space between them.
// False: there are more or fewer, or one is none in [min, max].
bool ParseNumbers(absl::string_view text, double min, double max,
                  std::span<double> values);

}  // namespace treeline::xml

#endif  // COMMON_XML_XML_FILE_H_
