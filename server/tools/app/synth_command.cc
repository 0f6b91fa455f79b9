#include "server/tools/app/synth_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_formats.h"
#include "common/image/decode.h"
#include "simulation/recorder/recorder.h"
#include "simulation/recorder/tour_walk.h"
#include "simulation/sensors/picture.h"
#include "simulation/worlds/world_flags.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
treeline synth COMMAND --help explains a command and gives examples.)";

constexpr const char* kRecordFooter = R"(
Worlds:
  room          a furnished living room with a desk
  cafe          a hall on two levels with a slope and stairs, people about
  lab           a laboratory with a narrow slope and glass
  office-floor  twelve rooms along corridors
  two-storey    two floors, one above the other, with a ramp between them
  seed:N        a building made from the whole number N; room:N: a room
  office:M2     an office building of so many square metres, 100 to 1500
  FILE.yaml     a building of your own

What is written, in the layout of 7-Scenes:
  DIR/seq-01/frame-000000.color.jpg  640 x 480, PINHOLE,525,525,320,240
  DIR/seq-01/frame-000000.depth.png  16 bit, mm, PINHOLE,585,585,320,240
  DIR/seq-01/frame-000000.pose.txt   4x4 world_from_camera, depth camera, m
In the layout of TUM:
  DIR/rgb/TIME.jpg, rgb.txt          640 x 480, PINHOLE,525,525,319.5,239.5
  DIR/depth/TIME.png, depth.txt      16 bit, 5000 to the metre, registered
  DIR/groundtruth.txt                TIME tx ty tz qx qy qz qw, colour camera, m
In both:
  DIR/train.txt, DIR/test.txt        frames for training, frames held out
  DIR/recording.txt                  what this is, and the true calibration

Lights (docs/reference/worlds.md): day is an overcast sky and all lamps, seen
with a fixed exposure. In the others the camera exposes and balances each frame
by itself, and its noise grows in the dark.

Depth is noisy like a Kinect's. In 7-Scenes it is not registered to colour: the
colour camera is 2.5 cm to the right of the depth camera. Frames are 1/30 s
apart; a round through the room takes about 450 of them, and the tour of a
building is walked at 0.8 m/s. A trajectory is a text file with lines
  timestamp tx ty tz qx qy qz qw
(world_from_camera of 7-Scenes' depth or TUM's colour camera, s and m): one
frame for each, or with --frames or --rate evenly in time between them.

Examples:
  treeline synth record --world room --output room --frames 1000
  treeline train --dataset 7scenes:room --frames room/train.txt \
      --output room.treeline
  treeline evaluate --model room.treeline --dataset 7scenes:room \
      --frames room/test.txt

  treeline synth record --world cafe --format tum --output cafe --people \
      --blur 15 --auto-exposure --jpeg 40..92
  treeline synth record --world cafe --output dusk --light evening \
      --rearranged 1:0.4
  treeline synth record --world cafe --output path --trajectory path.txt)";

constexpr const char* kLightHelp =
    "Light of the world; otherwise that of its file, or day";

constexpr uint64_t kMaxTrajectoryBytes = 64u << 20;

struct RecordFlags {
  recorder::RecordOptions options;
  std::string format = "7scenes";
  std::string trajectory;
  std::string jpeg = "92";
  double blur_ms = 0;
  double readout_ms = 0;
  bool has_people = false;
  bool quiet = false;
};

// "92" or "40..92".
absl::Status ReadQualities(const std::string& text,
                           recorder::RecordOptions& options) {
  const std::vector<std::string> parts = absl::StrSplit(text, "..");
  int low = 0;
  int high = 0;
  if (parts.size() > 2 || !absl::SimpleAtoi(parts.front(), &low) ||
      !absl::SimpleAtoi(parts.back(), &high)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--jpeg takes N or LOW..HIGH, not '", text, "'"));
  }
  options.lowest_jpeg_quality = low;
  options.jpeg_quality = high;
  return absl::OkStatus();
}

// What flags say beyond what was parsed straight into the options.
absl::StatusOr<recorder::RecordOptions> OptionsOf(const RecordFlags& flags,
                                                  const CLI::App& command) {
  recorder::RecordOptions options = flags.options;
  options.format = flags.format == "tum" ? recorder::RecordFormat::kTum
                                         : recorder::RecordFormat::kSevenScenes;
  options.shutter_s = flags.blur_ms / 1000;
  options.readout_s = flags.readout_ms / 1000;
  options.world_options.with_people = flags.has_people;
  TL_RETURN_IF_ERROR(ReadQualities(flags.jpeg, options));
  if (flags.trajectory.empty()) return options;
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(flags.trajectory, kMaxTrajectoryBytes));
  TL_ASSIGN_OR_RETURN(options.trajectory,
                      dataset::ParseTimedPoses(text, flags.trajectory));
  if (options.trajectory.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(flags.trajectory, ": names no pose"));
  }
  const bool has_frames = command.count("--frames") > 0;
  options.is_resampled = has_frames || command.count("--rate") > 0;
  if (options.is_resampled && !has_frames) {
    const double length_s =
        1e-9 * static_cast<double>(options.trajectory.back().time -
                                   options.trajectory.front().time);
    options.frames = 1 + static_cast<int>(std::min(
                             std::floor(length_s * options.rate_hz), 1e6));
  }
  return options;
}

absl::Status Record(const RecordFlags& flags, const CLI::App& command,
                    const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const recorder::RecordOptions options,
                      OptionsOf(flags, command));
  TL_RETURN_IF_ERROR(options.Validate());
  const int frames = recorder::FrameCount(options);
  {
    base::Progress progress("recording", frames, flags.quiet);
    TL_RETURN_IF_ERROR(recorder::RecordWorld(
        options, [&progress] { progress.Add(1); }, stop));
  }
  std::printf("Recorded %d frames of '%s' in %s\n", frames,
              options.world.c_str(), options.folder.c_str());
  return absl::OkStatus();
}

void AddSensorFlags(CLI::App& command, RecordFlags& flags) {
  command
      .add_option("--jpeg", flags.jpeg,
                  "JPEG quality; LOW..HIGH: another for each frame")
      ->type_name("N|LOW..HIGH")
      ->capture_default_str();
  command
      .add_option("--blur", flags.blur_ms,
                  "Motion blur: how long the shutter is open; 0: none")
      ->type_name("MS")
      ->capture_default_str();
  command
      .add_option("--readout-time", flags.readout_ms,
                  "Rolling shutter: rows are exposed one after the other, in "
                  "so long; 0: all at once")
      ->type_name("MS")
      ->capture_default_str();
  command.add_flag("--auto-exposure", flags.options.is_exposure_automatic,
                   "Expose each frame by itself, as cheap cameras do");
  command.add_flag("--people", flags.has_people,
                   "People and carts go about their ways");
  command.add_flag("--after-moves", flags.options.world_options.after_moves,
                   "With objects where they are moved to after mapping");
  worlds::WorldOptions& world = flags.options.world_options;
  worlds::AddLightFlag(command, "--light", kLightHelp, world.lighting);
  worlds::AddRearrangedFlag(command, world.rearranged);
  command.add_flag("--truth", flags.options.has_truth,
                   "Also write normals, surfaces and their kinds (DIR/truth)");
}

cli::Command AddRecord(CLI::App& synth) {
  CLI::App* command = synth.add_subcommand(
      "record", "Walk through a world with an RGB-D camera");
  command->footer(kRecordFooter);
  auto flags = std::make_shared<RecordFlags>();
  recorder::RecordOptions& options = flags->options;
  command->add_option("--world", options.world, "What to walk through")
      ->type_name("NAME|FILE|seed:N")
      ->capture_default_str();
  command
      ->add_option("--output", options.folder,
                   "Folder to record into; made if it is not there")
      ->type_name("DIR")
      ->required();
  command->add_option("--frames", options.frames, "Length of the walk")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--rate", options.rate_hz, "Frames in a second")
      ->type_name("HZ")
      ->capture_default_str();
  command
      ->add_option("--seed", options.seed,
                   "Another seed is another walk and other noise, in the same "
                   "world")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--trajectory", flags->trajectory,
                   "Poses to record from, in place of a walk")
      ->type_name("FILE");
  command->add_option("--format", flags->format, "Layout of the recording")
      ->check(CLI::IsMember({"7scenes", "tum"}))
      ->capture_default_str();
  AddSensorFlags(*command, *flags);
  command
      ->add_option("--threads", options.threads, "Threads; 0: one a processor")
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command, [flags, command](const std::stop_token& stop) {
            return Record(*flags, *command, stop);
          }};
}

constexpr const char* kPictureFooter = R"(
Views:
  top    the whole world from above, ceilings and what hangs from them cut
         away; what is above --below Z is left out too (lower floors)
  color  what a camera sees, without noise
  depth  what a depth camera measures there: red is near (0.4 m), blue is far
         (4.5 m), black was not measured

The camera stands where a recording's walk comes by at --time, or at --at.

Examples:
  treeline synth picture --world cafe --output cafe.png
  treeline synth picture --world cafe --view color --time 12 --output view.png
  treeline synth picture --world room --view depth --at 2,2,1.4,90 \
      --output depth.png)";

struct PictureFlags {
  std::string world = "room";
  std::string output;
  std::string view = "top";
  std::vector<double> at;
  double time_s = 0;
  double below_m = 1e6;
  int width_px = 960;
  uint64_t seed = 0;
  worlds::WorldOptions world_options;
  bool no_people = false;
};

absl::StatusOr<geometry::Rigid3> PicturePose(
    const PictureFlags& flags, const renderer::Renderer& renderer) {
  if (flags.at.empty()) {
    TL_ASSIGN_OR_RETURN(const recorder::CameraPath path,
                        recorder::MakeCameraPath(
                            renderer.world(), renderer.caster(), flags.seed));
    return path(flags.time_s);
  }
  constexpr double kRadiansPerDegree = std::numbers::pi / 180;
  const double pitch_deg = flags.at.size() > 4 ? flags.at[4] : 0;
  return sensors::LookingFrom({flags.at[0], flags.at[1], flags.at[2]},
                              flags.at[3] * kRadiansPerDegree,
                              pitch_deg * kRadiansPerDegree);
}

absl::StatusOr<image::ColorImage> Draw(const PictureFlags& flags) {
  worlds::WorldOptions options = flags.world_options;
  options.with_people = !flags.no_people;
  const int threads = options.threads;
  TL_ASSIGN_OR_RETURN(worlds::World world,
                      worlds::MakeWorld(flags.world, options));
  const bool is_top = flags.view == "top";
  // What hangs from the ceiling begins high up.
  constexpr double kHanging_m = 0.7;
  const double cut_m = std::min(flags.below_m, world.size_m.z - kHanging_m);
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<const renderer::Renderer> renderer,
      is_top ? renderer::Renderer::CreateOpened(
                   std::move(world), static_cast<float>(cut_m), threads)
             : renderer::Renderer::Create(std::move(world), threads));
  const renderer::WorldSnapshot snapshot =
      renderer->caster().At(renderer->world().InstancesAt(flags.time_s));
  if (is_top) {
    return sensors::PictureFromAbove(*renderer, snapshot, flags.width_px,
                                     threads);
  }
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 pose,
                      PicturePose(flags, *renderer));
  const int height_px = flags.width_px * 3 / 4;
  return flags.view == "depth"
             ? sensors::PictureOfDepth(*renderer, snapshot, pose,
                                       flags.width_px, height_px, threads)
             : sensors::PictureOf(*renderer, snapshot, pose, flags.width_px,
                                  height_px, threads);
}

absl::Status TakePicture(const PictureFlags& flags) {
  if (!flags.at.empty() && flags.at.size() < 4) {
    return absl::InvalidArgumentError(
        "--at takes X,Y,Z,YAW or X,Y,Z,YAW,PITCH (m, degrees)");
  }
  TL_RETURN_IF_ERROR(base::CheckWritable(flags.output));
  TL_ASSIGN_OR_RETURN(const image::ColorImage image, Draw(flags));
  constexpr int kJpegQuality = 85;
  TL_ASSIGN_OR_RETURN(const std::string bytes,
                      absl::EndsWith(flags.output, ".jpg")
                          ? image::EncodeJpeg(image, kJpegQuality)
                          : image::EncodePng(image));
  return base::WriteFileAtomically(flags.output, bytes);
}

cli::Command AddPicture(CLI::App& synth) {
  CLI::App* command =
      synth.add_subcommand("picture", "Draw a world for people to look at");
  command->footer(kPictureFooter);
  auto flags = std::make_shared<PictureFlags>();
  command->add_option("--world", flags->world, "What to draw")
      ->type_name("NAME|FILE|seed:N|room:N")
      ->capture_default_str();
  command->add_option("--output", flags->output, "The picture")
      ->type_name("FILE.png|FILE.jpg")
      ->required();
  command->add_option("--view", flags->view, "From above, or as a camera")
      ->check(CLI::IsMember({"top", "color", "depth"}))
      ->capture_default_str();
  command->add_option("--at", flags->at, "Where the camera is and looks")
      ->type_name("X,Y,Z,YAW[,PITCH]")
      ->delimiter(',')
      ->expected(1, 5);
  command
      ->add_option("--time", flags->time_s,
                   "When: where people are, and how far the walk has come")
      ->type_name("S")
      ->capture_default_str();
  command->add_option("--below", flags->below_m, "Top: leave out what is above")
      ->type_name("Z");
  command->add_option("--width", flags->width_px, "Longer side of the picture")
      ->type_name("PIXELS")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  command->add_option("--seed", flags->seed, "Of the walk")
      ->type_name("N")
      ->capture_default_str();
  worlds::WorldOptions& world = flags->world_options;
  command->add_flag("--after-moves", world.after_moves,
                    "With objects where they are moved to after mapping");
  worlds::AddLightFlag(*command, "--light", kLightHelp, world.lighting);
  worlds::AddRearrangedFlag(*command, world.rearranged);
  command->add_flag("--no-people", flags->no_people, "Nobody is about");
  command->add_option("--threads", world.threads, "Threads; 0: one a processor")
      ->type_name("N")
      ->capture_default_str();
  return {command,
          [flags](const std::stop_token&) { return TakePicture(*flags); }};
}

}  // namespace

cli::Command AddSynthCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("synth", "Record walks through synthetic worlds");
  command->footer(kFooter);
  command->require_subcommand(1);
  const cli::Command record = AddRecord(*command);
  const cli::Command picture = AddPicture(*command);
  return {command, [record, picture](const std::stop_token& stop) {
            return picture.app->parsed() ? picture.run(stop) : record.run(stop);
          }};
}

}  // namespace treeline::tools_app
