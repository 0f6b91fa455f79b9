// treeline synth: recordings of worlds that exist only here.
#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/synthetic/recorder.h"
#include "server/tools/commands.h"

namespace treeline {
namespace {

constexpr const char* kFooter = R"(
treeline synth COMMAND --help explains a command and gives examples.)";

constexpr const char* kRecordFooter = R"(
Worlds:
  room    a furnished living room with a desk
  room:N  a room of the same kind, with other measures, furniture and pictures
          for each whole number N

What is written, in the layout of 7-Scenes:
  DIR/seq-01/frame-000000.color.jpg  640 x 480, PINHOLE,525,525,320,240
  DIR/seq-01/frame-000000.depth.png  16 bit, mm, PINHOLE,585,585,320,240
  DIR/seq-01/frame-000000.pose.txt   4x4 world_from_camera, depth camera, m
  DIR/train.txt, DIR/test.txt        frames for training, frames held out
  DIR/recording.txt                  what this is, and the true calibration

Depth is noisy like a Kinect's and is not registered to colour: the colour
camera is 2.5 cm to the right of the depth camera. Frames are 1/30 s apart; a
round through the room takes about 450 of them.

Example:
  treeline synth record --world room --output room --frames 1000
  treeline train --dataset 7scenes:room --frames room/train.txt \
      --output room.treeline
  treeline evaluate --model room.treeline --dataset 7scenes:room \
      --frames room/test.txt)";

struct RecordFlags {
  RecordOptions options;
  std::string format = "7scenes";
  bool quiet = false;
};

absl::Status Record(const RecordFlags& flags, const std::stop_token& stop) {
  const RecordOptions& options = flags.options;
  TL_RETURN_IF_ERROR(options.Validate());
  {
    Progress progress("recording", options.frames, flags.quiet);
    TL_RETURN_IF_ERROR(RecordSevenScenes(
        options, [&progress] { progress.Add(1); }, stop));
  }
  std::printf("Recorded %d frames of '%s' in %s\n", options.frames,
              options.world.c_str(), options.folder.c_str());
  return absl::OkStatus();
}

Command AddRecord(CLI::App& synth) {
  CLI::App* command = synth.add_subcommand(
      "record", "Walk through a world with an RGB-D camera");
  command->footer(kRecordFooter);
  auto flags = std::make_shared<RecordFlags>();
  command->add_option("--world", flags->options.world, "What to walk through")
      ->type_name("NAME|room:N")
      ->capture_default_str();
  command
      ->add_option("--output", flags->options.folder,
                   "Folder to record into; made if it is not there")
      ->type_name("DIR")
      ->required();
  command->add_option("--frames", flags->options.frames, "Length of the walk")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--seed", flags->options.seed,
                   "Another seed is another walk and other noise, in the same "
                   "world")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--format", flags->format, "Layout of the recording")
      ->check(CLI::IsMember({"7scenes"}))
      ->capture_default_str();
  command
      ->add_option("--threads", flags->options.threads,
                   "Threads; 0: one a processor")
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command, [flags](const std::stop_token& stop) {
            return Record(*flags, stop);
          }};
}

}  // namespace

Command AddSynthCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("synth", "Record walks through synthetic worlds");
  command->footer(kFooter);
  command->require_subcommand(1);
  return {command, AddRecord(*command).run};
}

}  // namespace treeline
