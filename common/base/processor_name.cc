#include "common/base/processor_name.h"

#include <fstream>
#include <iterator>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace treeline::base {
namespace {

// The value of the first line "KEY : VALUE"; empty if there is none.
absl::string_view ValueOf(absl::string_view key, absl::string_view cpuinfo) {
  for (const absl::string_view line : absl::StrSplit(cpuinfo, '\n')) {
    const std::pair<absl::string_view, absl::string_view> parts =
        absl::StrSplit(line, absl::MaxSplits(':', 1));
    if (absl::StripAsciiWhitespace(parts.first) == key) {
      return absl::StripAsciiWhitespace(parts.second);
    }
  }
  return {};
}

}  // namespace

std::string ProcessorNameIn(absl::string_view cpuinfo) {
  for (const absl::string_view key : {"model name", "Model"}) {
    const absl::string_view name = ValueOf(key, cpuinfo);
    if (!name.empty()) return {name.data(), name.size()};
  }
  const absl::string_view maker = ValueOf("CPU implementer", cpuinfo);
  if (maker.empty()) return "";
  return absl::StrCat("Arm ", maker, "-", ValueOf("CPU part", cpuinfo));
}

std::string ProcessorName() {
  std::ifstream file("/proc/cpuinfo");
  return ProcessorNameIn(std::string(std::istreambuf_iterator<char>(file), {}));
}

}  // namespace treeline::base
