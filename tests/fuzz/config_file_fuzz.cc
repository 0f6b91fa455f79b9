// Configuration files, as arbitrary bytes: no crash, no exception, and what is
// accepted is within the settings' bounds and can be printed and read again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/config/config_file.h"
#include "common/config/testing_settings.h"

namespace treeline {
namespace {

void Parse(absl::string_view text) {
  static const auto* const settings =
      new std::vector<config::Setting>(config::TestTable().settings());
  const auto values = config::ParseConfigFile(text, "fuzz", *settings);
  if (!values.ok()) return;
  std::string printed;
  for (const auto& [name, entry] : *values) {
    const config::Setting* setting = config::FindSetting(*settings, name);
    if (setting == nullptr || entry.line < 1) std::abort();
    if (!config::CheckValue(*setting, entry.value).ok()) std::abort();
    absl::StrAppend(&printed, name, ": ", config::ToYaml(entry.value), "\n");
  }
  const auto again = config::ParseConfigFile(printed, "printed", *settings);
  if (!again.ok() || again->size() != values->size()) std::abort();
  for (const auto& [name, entry] : *values) {
    if (again->at(name).value != entry.value) std::abort();
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Parse(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
