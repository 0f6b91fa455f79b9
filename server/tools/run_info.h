// What a result must state to be reproducible: machine, command, memory.
#ifndef SERVER_TOOLS_RUN_INFO_H_
#define SERVER_TOOLS_RUN_INFO_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::tools {

// This process's command line, quoted where a shell would need it. Empty if
// the system does not tell.
std::string CommandLine();

// `argument` as a shell takes it: unchanged if harmless, else in quotes.
std::string ShellQuoted(absl::string_view argument);

// The processor's name and the number of its processors this process may use:
// "AMD EPYC 7763, 2 processors".
std::string CpuDescription();

// The largest resident memory this process has had (bytes), shared pages of
// mapped files included.
uint64_t PeakMemoryBytes();

// Makes PeakMemoryBytes start again from what is resident now, where the system
// allows it (Linux).
void ResetPeakMemory();

// The time now, "2026-11-21T09:30:00Z".
std::string UtcNow();

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_RUN_INFO_H_
