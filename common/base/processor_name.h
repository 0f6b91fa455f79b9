// What a machine's processor is called, for figures that name it.
#ifndef COMMON_BASE_PROCESSOR_NAME_H_
#define COMMON_BASE_PROCESSOR_NAME_H_

#include <string>

#include "absl/strings/string_view.h"

namespace treeline::base {

// In the text of Linux's /proc/cpuinfo: the model on x86; on Arm the board
// where the kernel names it ("Raspberry Pi 5 Model B Rev 1.0"), else the
// maker's and the core's numbers ("Arm 0x41-0xd0b": Arm's Cortex-A76). Empty if
// it says nothing of the kind.
std::string ProcessorNameIn(absl::string_view cpuinfo);

// This machine's; empty if it is not known.
std::string ProcessorName();

}  // namespace treeline::base

#endif  // COMMON_BASE_PROCESSOR_NAME_H_
