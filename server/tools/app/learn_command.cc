#include "server/tools/app/learn_command.h"

#include <memory>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "server/tools/app/capture_flags.h"
#include "server/tools/app/learn_live.h"
#include "server/tools/app/learn_run.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kHeader = R"(
CAPTURE is one of
  what a phone or another program captured, as `treeline import` reads it:
)";

constexpr const char* kFooter =
    R"(  a recording: its folder, or 7scenes:DIR, 12scenes:DIR, tum:DIR,
              colmap:MODEL_DIR,IMAGES_DIR, nvm:FILE
  a map bundle of `treeline-agent map`: its folder

What is done, each step of which can be done alone, too:
  1 Import     a recording of the capture, in OUTPUT/recording (treeline import)
  2 Calibrate  how depth and colour fit together, where the recording does not
               say it (treeline calibrate)
  3 Train      from 60 % of the frames, in blocks (treeline train)
  4 Test       on blocks that were held out, with depth and without, and on
               pictures of nothing (treeline evaluate)
  5 Learn all  anew from all frames: this is the model that serves. With
               --only-tested, the tested one serves, in half the time
  6 Coverage   where it will work (treeline inspect --coverage)
  7 Publish    as the next version of the scene in the repository

OUTPUT/page.html then says in plain words how good it will be, where it will
work, and where to record more. After an error or Ctrl-C, neither OUTPUT nor the
new version is there.

Poses are needed. A recording with depth and without poses gets them from
  treeline-agent map --rgbd tum:DIR --output map
  treeline learn map

Learning while frames arrive (--live): a recording is played at its pace, or
another program names frames on standard input, a line each,
  COLOR DEPTH tx ty tz qx qy qz qw
two picture files and the pose, world from camera (m, quaternion). With
--corrections a line may also correct the pose of a frame that came before, or
say that no more frames will come:
  pose COLOR tx ty tz qx qy qz qw
  end
Trees are
those of a base, their leaves are filled, views and features are added: steps 1,
4, 5 and 6 and the page fall away. The version in the repository has the model so
far, renewed as it grows (a server with --poll-s 1 takes it), and the complete
one about a second after the last frame. Ctrl-C ends the frames and keeps the
model. Where frames come faster than they are learnt, some are skipped and
counted. How sure the model may be of its answers it learns from blocks of frames
that it is asked about before it learns them.

Examples:
  treeline learn --live 7scenes:recording --calibration kinect.json
  my-slam | treeline learn --live - --scene office --calibration kinect.json
  treeline learn 2fd1a8b0c3 --scene office --every 6
  treeline learn office.r3d --repository /srv/models
  treeline learn 7scenes:recording --scene office --output office-2
  treeline-server --models models)";

void AddRecordingFlags(CLI::App& command, dataset::DatasetOptions& options) {
  constexpr const char* kGroup = "If it is a recording already";
  command
      .add_option(
          "--frames", options.frame_list,
          "File with the frames to learn and test, one a line (default: "
          "all)")
      ->type_name("FILE")
      ->group(kGroup);
  command
      .add_option("--poses", options.pose_file,
                  "File with poses instead of the recording's own; see "
                  "`treeline train --help`")
      ->type_name("FILE")
      ->group(kGroup);
  command
      .add_option("--color-camera", options.color_camera,
                  "Colour camera, as MODEL,p1,p2,...")
      ->type_name("CAMERA")
      ->group(kGroup);
  command
      .add_option("--depth-camera", options.depth_camera,
                  "Depth camera, in the same form (7scenes)")
      ->type_name("CAMERA")
      ->group(kGroup);
}

void AddTrainingFlags(CLI::App& command, LearnOptions& options) {
  constexpr const char* kGroup = "Training";
  command
      .add_option("--method", options.method,
                  "Method; see `treeline train --help` (default: universal, "
                  "or sift for structure from motion)")
      ->type_name("NAME")
      ->group(kGroup);
  command
      .add_option("--calibration", options.calibration,
                  "auto, nominal or a file of `treeline calibrate`; what was "
                  "imported has its own cameras")
      ->type_name("auto|nominal|FILE")
      ->capture_default_str()
      ->group(kGroup);
  command
      .add_flag("--only-tested", options.only_tested,
                "Publish the model that was tested, without the held-out "
                "frames: half the time")
      ->group(kGroup);
  command.add_option("--trees", options.training.trees, "Trees")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  command
      .add_option("--seed", options.training.seed,
                  "The same seed gives the same model, whatever the threads")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  command
      .add_option("--threads", options.training.threads,
                  "Threads of the training; 0: one a processor")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
}

void AddLiveFlags(CLI::App& command, LiveFlags& live) {
  constexpr const char* kGroup = "Learning while frames arrive";
  CLI::Option* is_live =
      command
          .add_flag("--live", live.is_live,
                    "Learn CAPTURE, a recording or - for standard input, frame "
                    "by frame as it arrives; see below")
          ->group(kGroup);
  for (const char* other :
       {"--output", "--method", "--only-tested", "--trees"}) {
    is_live->excludes(command.get_option(other));
  }
  const auto add = [&](const char* name, auto& value, const char* help,
                       const char* type) {
    return command.add_option(name, value, help)
        ->type_name(type)
        ->group(kGroup)
        ->needs(is_live);
  };
  add("--rate", live.rate_hz,
      "Frames a second at which a recording is played; 0: as fast as they are "
      "learnt, and none is skipped",
      "HZ")
      ->capture_default_str();
  add("--publish-every", live.publish_every_s,
      "Seconds after which the model so far is written again", "S")
      ->capture_default_str();
  add("--base", live.base_model,
      "Model whose trees are kept, of method universal or rgbd and of any "
      "scene (default: the one that comes with Treeline)",
      "MODEL");
  command
      .add_flag("--corrections", live.takes_corrections,
                "Standard input may correct poses of frames that came before; "
                "takes 0.4 MB of disk a frame meanwhile")
      ->group(kGroup)
      ->needs(is_live);
}

absl::Status Learn(LearnOptions options, const std::stop_token& stop) {
  options.dataset.depth_unit_m = options.capture.open.depth_unit_m;
  if (options.live.is_live) return LearnLive(options, stop);
  return LearnPlace(options, stop);
}

}  // namespace

cli::Command AddLearnCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "learn", "From a capture to a scene that serves, and a page about it");
  command->footer(absl::StrCat(kHeader, CaptureFormatsHelp(), kFooter));
  auto flags = std::make_shared<LearnOptions>();
  LearnOptions& options = *flags;
  command
      ->add_option("capture", options.source,
                   "What to learn from: a capture, a recording or a map bundle")
      ->type_name("CAPTURE")
      ->required();
  command
      ->add_option("--repository", options.repository,
                   "The server's folder of models; made where missing")
      ->type_name("DIR")
      ->capture_default_str();
  command
      ->add_option("--scene", options.scene,
                   "The scene's name there (default: from the capture's)")
      ->type_name("NAME");
  command
      ->add_option("--output", options.output,
                   "Folder for the page and the imported recording; it must "
                   "not be there, or be empty (default: SCENE-learnt)")
      ->type_name("OUTPUT");
  AddCaptureFlags(*command, options.capture, "If it is a capture");
  AddRecordingFlags(*command, options.dataset);
  AddTrainingFlags(*command, options);
  AddLiveFlags(*command, options.live);
  command->add_flag("--quiet", options.quiet, "Show no progress");
  return {command,
          [flags](const std::stop_token& stop) { return Learn(*flags, stop); }};
}

}  // namespace treeline::tools_app
