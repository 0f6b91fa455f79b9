#include "server/tools/run_info.h"

#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/base/parallel_for.h"
#include "common/base/processor_name.h"

namespace treeline::tools {

std::string ShellQuoted(absl::string_view argument) {
  const auto harmless = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
           absl::StrContains("_-./:=,+@%", c);
  };
  if (!argument.empty() && std::ranges::all_of(argument, harmless)) {
    return std::string(argument);
  }
  return absl::StrCat("'", absl::StrReplaceAll(argument, {{"'", R"('\'')"}}),
                      "'");
}

std::string CommandLine() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) {
    words.push_back(ShellQuoted(word));
  }
  return absl::StrJoin(words, " ");
}

std::string CpuDescription() {
  std::string name = base::ProcessorName();
  if (name.empty()) name = "unknown processor";
  const int processors = base::HardwareThreads();
  return absl::StrCat(name, ", ", processors,
                      processors == 1 ? " processor" : " processors");
}

uint64_t PeakMemoryBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

void ResetPeakMemory() { std::ofstream("/proc/self/clear_refs") << "5"; }

std::string UtcNow() {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::Now(),
                          absl::UTCTimeZone());
}

}  // namespace treeline::tools
