#include "simulation/emulators/fault_plan.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace treeline::emulators {
namespace {

struct Kind {
  absl::string_view name;
  bool has_value = false;
  double low = 0;
  double high = 0;
};

constexpr std::array<Kind, 9> kKinds = {{
    {"corrupt", true, 0, 1},
    {"drop", true, 0, 1},
    {"split", true, 1, 100'000},
    {"merge", true, 0, 60},
    {"stuck"},
    {"unplug"},
    {"garbage"},
    {"error", true, 1, 99},
    {"skew", true, -100'000, 100'000},
}};

absl::Status Wrong(absl::string_view text, absl::string_view why) {
  return absl::InvalidArgumentError(absl::StrCat(
      "fault \"", text, "\": ", why,
      "; it is KIND[:VALUE][@START[+DURATION]], such as corrupt:0.001, "
      "unplug@10+3 or error:52@5+2"));
}

}  // namespace

absl::Status DeviceFaultPlan::Add(absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits('@', 1));
  const std::pair<absl::string_view, absl::string_view> what =
      absl::StrSplit(parts.first, absl::MaxSplits(':', 1));
  const auto* const kind =
      std::find_if(kKinds.begin(), kKinds.end(),
                   [&](const Kind& k) { return k.name == what.first; });
  if (kind == kKinds.end()) return Wrong(text, "there is no such kind");
  Fault fault = {.kind = std::string(kind->name),
                 .end_s = std::numeric_limits<double>::infinity()};
  if (kind->has_value != !what.second.empty()) {
    return Wrong(text,
                 kind->has_value ? "it needs a value" : "it takes no value");
  }
  if (kind->has_value &&
      !(absl::SimpleAtod(what.second, &fault.value) &&
        fault.value >= kind->low && fault.value <= kind->high)) {
    return Wrong(text, absl::StrCat("its value must be a number from ",
                                    kind->low, " to ", kind->high));
  }
  if (!parts.second.empty()) {
    const std::pair<absl::string_view, absl::string_view> times =
        absl::StrSplit(parts.second, absl::MaxSplits('+', 1));
    double duration_s = std::numeric_limits<double>::infinity();
    if (!absl::SimpleAtod(times.first, &fault.start_s) ||
        !(fault.start_s >= 0) ||
        (!times.second.empty() &&
         (!absl::SimpleAtod(times.second, &duration_s) || !(duration_s > 0)))) {
      return Wrong(text, "its times must be numbers of seconds");
    }
    fault.end_s = fault.start_s + duration_s;
  }
  faults_.push_back(std::move(fault));
  return absl::OkStatus();
}

ActiveFaults DeviceFaultPlan::At(double elapsed_s) const {
  ActiveFaults active;
  for (const Fault& fault : faults_) {
    if (elapsed_s < fault.start_s || elapsed_s >= fault.end_s) continue;
    if (fault.kind == "corrupt") active.corrupt = fault.value;
    if (fault.kind == "drop") active.drop = fault.value;
    if (fault.kind == "split")
      active.split_bytes = static_cast<int>(fault.value);
    if (fault.kind == "merge") active.merge_s = fault.value;
    if (fault.kind == "stuck") active.stuck = true;
    if (fault.kind == "unplug") active.unplugged = true;
    if (fault.kind == "garbage") active.garbage = true;
    if (fault.kind == "error")
      active.error_status = static_cast<int>(fault.value);
    if (fault.kind == "skew") active.skew_ppm = fault.value;
  }
  return active;
}

}  // namespace treeline::emulators
