#include "server/tools/app/capture_flags.h"

#include "CLI/CLI.hpp"
#include "absl/strings/str_format.h"
#include "server/tools/capture/open_capture.h"

namespace treeline::tools_app {

void AddCaptureFlags(CLI::App& command, CaptureFlags& flags,
                     const std::string& group) {
  const auto in_group = [&](CLI::Option* option) {
    if (!group.empty()) option->group(group);
    return option;
  };
  in_group(
      command.add_option("--format", flags.format, "Format of the capture"))
      ->type_name("auto|NAME")
      ->capture_default_str();
  in_group(command.add_option(
               "--depth-unit", flags.open.depth_unit_m,
               "Metres per unit of the depth files (default: as the format "
               "has it, mostly 0.001)"))
      ->type_name("M");
  in_group(command.add_option(
               "--min-confidence", flags.open.min_confidence,
               "Depth that is less certain is left out, where the capture "
               "says how certain it is: 0 keeps all, 1 drops low, 2 drops "
               "medium too"))
      ->type_name("0|1|2")
      ->capture_default_str();
  in_group(command.add_option(
               "--up", flags.open.up,
               "Which axis of the capture's world points up (default: as "
               "the format has it: y for phones, z for the others)"))
      ->type_name("x|-x|y|-y|z|-z");
  in_group(command.add_option(
               "--every", flags.write.every,
               "Take every N-th frame; phones record up to 60 a second"))
      ->type_name("N")
      ->capture_default_str();
  in_group(command.add_option(
               "--max-side", flags.write.max_side_px,
               "Make pictures smaller whose longer side is longer than "
               "this; 0: never"))
      ->type_name("PX")
      ->capture_default_str();
  in_group(command.add_flag(
      "--keep-turn", flags.keep_turn,
      "Leave pictures as they are stored, even on their side"));
}

std::string CaptureFormatsHelp() {
  std::string help;
  for (const capture::CaptureFormat& format : capture::CaptureFormats()) {
    absl::StrAppendFormat(&help, "  %-12s%s\n", format.name, format.summary);
  }
  return help;
}

}  // namespace treeline::tools_app
