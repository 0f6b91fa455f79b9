// The one document that a text of YAML should have, by yaml-cpp.
#ifndef COMMON_YAML_FIRST_DOCUMENT_H_
#define COMMON_YAML_FIRST_DOCUMENT_H_

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>

namespace treeline::yaml {

struct FirstDocument {
  // nullopt: the text has none.
  std::optional<YAML::Node> node;
  // Where a second one begins.
  std::optional<YAML::Mark> second;
};

// Looks at no third document: of some texts that are not YAML (",") yaml-cpp
// finds documents without end, until YAML::LoadAll has taken all memory. Throws
// YAML::Exception for what is not YAML.
FirstDocument LoadFirstDocument(const std::string& text);

}  // namespace treeline::yaml

#endif  // COMMON_YAML_FIRST_DOCUMENT_H_
