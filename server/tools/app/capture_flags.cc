#include "server/tools/app/capture_flags.h"

#include <algorithm>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/tools/capture/open_capture.h"
#include "server/tools/capture/picture_files.h"
#include "server/tools/run_info.h"

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
               "the format has it: y for phones, z for most others)"))
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
  constexpr const char* kRos = "Recordings of ROS (topics are guessed)";
  struct RosFlag {
    const char* name;
    std::string* value;
    const char* help;
    const char* type;
  };
  capture::RosOptions& ros = flags.open.ros;
  for (const RosFlag& flag :
       {RosFlag{"--color-topic", &ros.color_topic, "Colour pictures", "TOPIC"},
        RosFlag{"--depth-topic", &ros.depth_topic, "Depth maps", "TOPIC|none"},
        RosFlag{"--camera-info", &ros.camera_info,
                "Calibration of the colour camera", "TOPIC"},
        RosFlag{"--depth-camera-info", &ros.depth_camera_info,
                "Calibration of the depth camera", "TOPIC"},
        RosFlag{"--pose-topic", &ros.pose_topic,
                "Where poses come from: /tf, or a topic of Odometry, "
                "PoseStamped or PoseWithCovarianceStamped",
                "tf|TOPIC"},
        RosFlag{"--pose-frame", &ros.pose_frame,
                "Which frame that topic tells of (default: what it says, "
                "or the camera's)",
                "FRAME"},
        RosFlag{"--world-frame", &ros.world_frame,
                "The frame of /tf that poses are in (default: map, world, "
                "odom or the topmost)",
                "FRAME"}}) {
    command.add_option(flag.name, *flag.value, flag.help)
        ->type_name(flag.type)
        ->group(kRos);
  }
  constexpr const char* kPictures = "Photographs and videos";
  command
      .add_option("--distance", flags.photographs.distance,
                  "How far apart two pictures were taken (m): the scale, which "
                  "pictures alone do not tell")
      ->type_name("A.jpg,B.jpg,METRES")
      ->group(kPictures);
  command
      .add_option("--scale", flags.photographs.scale,
                  "Or: metres per unit of the structure")
      ->type_name("M")
      ->group(kPictures);
  command
      .add_option("--colmap", flags.photographs.colmap,
                  "COLMAP's program, 3.8 or like it")
      ->type_name("PROGRAM")
      ->capture_default_str()
      ->group(kPictures);
}

bool IsPictures(const std::string& path, const std::string& format) {
  if (format == "photographs" || format == "video") return true;
  if (format != "auto") return false;
  return (photographs::IsPhotographs(path) || photographs::IsVideo(path)) &&
         std::ranges::none_of(capture::CaptureFormats(),
                              [&](const auto& f) { return f.is_it(path); });
}

std::string PicturesAlone(const std::string& path) {
  const std::string folder = capture::PhotographFolderIn(path);
  return absl::StrCat(
      "Pictures alone are learnt through structure from motion, which finds "
      "poses of its own",
      folder.empty()
          ? std::string()
          : absl::StrCat(":\n  treeline learn ", tools::ShellQuoted(folder)),
      "\ndocs/how-to/learn-from-photographs.md says more");
}

photographs::PhotographOptions PhotographOptionsOf(const CaptureFlags& flags,
                                                   const std::string& folder,
                                                   bool quiet) {
  photographs::PhotographOptions options = flags.photographs;
  options.folder = folder;
  // Without these flags, what suits structure from motion.
  if (flags.write.every > 1) options.pictures.every = flags.write.every;
  if (flags.write.max_side_px > 0) {
    options.pictures.max_side_px = flags.write.max_side_px;
  }
  options.quiet = quiet;
  return options;
}

std::string CaptureFormatsHelp() {
  std::string help;
  for (const capture::CaptureFormat& format : capture::CaptureFormats()) {
    absl::StrAppendFormat(&help, "  %-12s%s\n", format.name, format.summary);
  }
  help +=
      "  photographs a folder of JPEG, PNG or HEIC files, without poses: needs "
      "COLMAP\n"
      "  video       .mp4, .mov or .m4v, without poses: needs COLMAP\n";
  return help;
}

}  // namespace treeline::tools_app
