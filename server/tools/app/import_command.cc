#include "server/tools/app/import_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "server/tools/app/capture_flags.h"
#include "server/tools/capture/open_capture.h"
#include "server/tools/capture/recording_writer.h"
#include "server/tools/learning/learn_source.h"
#include "server/tools/run_info.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
What is written, in the layout of 7-Scenes:
  DIR/seq-01/frame-000000.color.jpg  colour
  DIR/seq-01/frame-000000.depth.png  16 bit, mm, of frames with depth
  DIR/seq-01/frame-000000.pose.txt   4x4 world_from_camera, colour camera, m
  DIR/cameras.json                   both cameras
  DIR/train.txt, DIR/test.txt        frames for training, frames held out
  DIR/recording.txt                  what was converted, what was left out

Of photographs and videos, poses are found by structure from motion, with the
program COLMAP (apt install colmap); minutes for some hundred pictures:
  DIR/images/                        the pictures, upright
  DIR/model/                         COLMAP's model, z up; in metres only where
                                     --distance or --scale tells how large it is
  DIR/train.txt, DIR/test.txt, DIR/recording.txt

The world has z up. Frames without a pose, and frames whose files are missing or
broken, are left out and counted. After an error or Ctrl-C there is no DIR.

A phone that was held upright stores its pictures on their side: all of them are
turned upright, with their cameras and poses, unless --keep-turn is given. While
a phone focuses, its focal length changes: such pictures are resampled to one
camera.

Examples:
  treeline import 2fd1a8b0c3 --output office
  treeline import capture.r3d --output office --every 3 --max-side 960
  treeline import polycam-raw --output office --min-confidence 2
  treeline import nerf/transforms.json --output scan --up y
  treeline import walk.mcap --output office --every 6
  treeline import rtabmap.db --output office
  treeline import photographs --output square \
      --distance IMG_0012.jpg,IMG_0031.jpg,4.2
  treeline import walk.mp4 --output square
  treeline train --dataset 7scenes:office --frames office/train.txt \
      --calibration nominal --output office.treeline

What to tap in each app: docs/how-to/import-a-capture.md)";

struct ImportFlags : CaptureFlags {
  std::string capture;
  bool quiet = false;
};

void PrintResult(const ImportFlags& flags, const std::string& format,
                 const capture::WrittenRecording& written) {
  const std::string& folder = flags.write.folder;
  std::printf("Imported %d frames from %s (%s) to %s: %d with depth\n",
              written.frames, flags.capture.c_str(), format.c_str(),
              folder.c_str(), written.with_depth);
  std::printf("  colour %d x %d, %s\n", written.calibration.color.width(),
              written.calibration.color.height(),
              written.calibration.color.ToString().c_str());
  if (written.with_depth > 0) {
    std::printf("  depth  %d x %d, %s\n", written.calibration.depth.width(),
                written.calibration.depth.height(),
                written.calibration.depth.ToString().c_str());
  }
  std::printf("  %d frames in train.txt, %d in test.txt\n", written.train,
              written.test);
  for (const std::string& note : written.notes) {
    std::printf("  note: %s\n", note.c_str());
  }
  if (written.left_out.count() > 0) {
    std::printf("  left out:\n");
    for (const std::string& line : written.left_out.Lines()) {
      std::printf("    %s\n", line.c_str());
    }
  }
  if (written.with_depth == 0) {
    std::printf("No frame has depth. %s\n",
                PicturesAlone(flags.capture).c_str());
    return;
  }
  std::printf(
      "Next: treeline train --dataset %s --frames %s --calibration nominal "
      "--output %s\n",
      tools::ShellQuoted("7scenes:" + folder).c_str(),
      tools::ShellQuoted(folder + "/train.txt").c_str(),
      tools::ShellQuoted(folder + ".treeline").c_str());
}

absl::Status ImportPictures(const ImportFlags& flags,
                            const std::stop_token& stop) {
  const std::string& folder = flags.write.folder;
  TL_ASSIGN_OR_RETURN(
      const photographs::ImportedPhotographs imported,
      photographs::ImportPhotographs(
          flags.capture, PhotographOptionsOf(flags, folder, flags.quiet),
          stop));
  std::printf(
      "Imported %d of %d pictures from %s to %s: %d points\n"
      "  %d pictures in train.txt, %d in test.txt\n",
      imported.registered, imported.pictures, flags.capture.c_str(),
      folder.c_str(), imported.points, imported.train, imported.test);
  for (const std::string& note : imported.notes) {
    std::printf("  note: %s\n", note.c_str());
  }
  std::printf(
      "Next: treeline train --method sift --dataset %s --frames %s --output "
      "%s\n",
      tools::ShellQuoted(imported.uri).c_str(),
      tools::ShellQuoted(folder + "/train.txt").c_str(),
      tools::ShellQuoted(folder + ".treeline").c_str());
  return absl::OkStatus();
}

// The capture; of a recording, that it can be learnt as it is.
absl::StatusOr<capture::Capture> Open(const ImportFlags& flags) {
  absl::StatusOr<capture::Capture> opened =
      capture::OpenCapture(flags.capture, flags.format, flags.open);
  if (opened.ok() || flags.format != "auto") return opened;
  const auto source = learning::FindLearnSource(flags.capture);
  if (!source.ok() || source->kind == learning::SourceKind::kCapture) {
    return opened;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      flags.capture,
      ": is a recording, which needs no import:\n  treeline "
      "learn ",
      tools::ShellQuoted(flags.capture), "\n  treeline train --dataset ",
      tools::ShellQuoted(source->uri), " ..."));
}

absl::Status Import(ImportFlags& flags, const std::stop_token& stop) {
  if (IsPictures(flags.capture, flags.format)) {
    return ImportPictures(flags, stop);
  }
  flags.write.source = flags.capture;
  flags.write.upright = !flags.keep_turn;
  TL_RETURN_IF_ERROR(flags.write.Validate());
  TL_ASSIGN_OR_RETURN(capture::Capture capture, Open(flags));
  const std::string format = capture.format;
  absl::StatusOr<capture::WrittenRecording> written;
  {
    base::Progress progress(
        "importing", std::max(1, capture::FramesToWrite(capture, flags.write)),
        flags.quiet);
    written = capture::WriteRecording(
        std::move(capture), flags.write, [&progress] { progress.Add(1); },
        stop);
  }
  TL_RETURN_IF_ERROR(written.status());
  PrintResult(flags, format, *written);
  return absl::OkStatus();
}

}  // namespace

cli::Command AddImportCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("import", "Make a recording of what a phone captured");
  command->footer(
      absl::StrCat("\nFormats, found out by themselves unless --format is "
                   "given:\n",
                   CaptureFormatsHelp(), kFooter));
  auto flags = std::make_shared<ImportFlags>();
  command
      ->add_option("capture", flags->capture,
                   "What the app exported: a folder or a file")
      ->type_name("CAPTURE")
      ->required();
  command
      ->add_option("--output", flags->write.folder,
                   "Folder to write; it must not be there, or be empty")
      ->type_name("DIR")
      ->required();
  AddCaptureFlags(*command, *flags);
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command, [flags](const std::stop_token& stop) {
            return Import(*flags, stop);
          }};
}

}  // namespace treeline::tools_app
