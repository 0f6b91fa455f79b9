#include "common/yaml/first_document.h"

#include <yaml-cpp/eventhandler.h>

#include <sstream>

namespace treeline::yaml {
namespace {

// Where the last document begins that it was told of.
class DocumentStart final : public YAML::EventHandler {
 public:
  const YAML::Mark& mark() const { return mark_; }

  void OnDocumentStart(const YAML::Mark& mark) override { mark_ = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {
  }
  void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/,
                YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {}
  void OnSequenceStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/,
                       YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/,
                  YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {}
  void OnMapEnd() override {}

 private:
  YAML::Mark mark_;
};

}  // namespace

FirstDocument LoadFirstDocument(const std::string& text) {
  FirstDocument first;
  std::istringstream input(text);
  YAML::Parser parser(input);
  DocumentStart start;
  if (!parser.HandleNextDocument(start)) return first;
  first.node = YAML::Load(text);
  if (parser.HandleNextDocument(start)) first.second = start.mark();
  return first;
}

}  // namespace treeline::yaml
