#include "client/cli/localize_command.h"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/cli/answer_text.h"
#include "client/cli/client_tracing.h"
#include "client/cli/connection_flags.h"
#include "client/relocalizer/frame_files.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "client/relocalizer/relocalizer.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"

namespace treeline::client_cli {
namespace {

constexpr const char* kFooter = R"(
One frame is given by --color and --depth. Many are given by --list, a file with
one stem a line, and --root: the images of stem S are ROOT/S.color.jpg or
ROOT/S.color.png and, if it is there, ROOT/S.depth.png. They are asked for one
after the other over one connection.

Depth is taken to be the raw image of the depth camera that the scene was
recorded with, in millimetres; --registered and --depth-unit state otherwise.
The camera is taken to be the scene's; --camera states another one, with pixel
centres at integer coordinates.

Examples:
  treeline-client localize --server 127.0.0.1:50051 --scene office \
      --color query.jpg --depth query.png
  treeline-client localize --server 127.0.0.1:50051 --scene desk \
      --color rgb.png --depth depth.png --registered --depth-unit 0.0002 \
      --camera PINHOLE,517.3,516.5,318.6,255.3
  treeline-client localize --server 127.0.0.1:50051 --scene office \
      --list office/test.txt --root office --json > answers.jsonl
  treeline-client localize --server 127.0.0.1:50051 --candidate-scene office \
      --candidate-scene lab --color query.jpg --depth query.png
  treeline-client localize --server 127.0.0.1:50051 --scene office \
      --color portrait.jpg --orientation left --near 3.6,1.6,1.2,2

Exit codes: 0 localized, 1 failed, 2 wrong usage, 3 not localized, 130
interrupted. For a list: 0 if at least one frame was localized and none failed,
3 if none was localized, 1 if any failed.)";

struct LocalizeFlags {
  ConnectionFlags connection;
  relocalizer::LocalizeQuery query;  // but for its frame
  relocalizer::FrameFiles files;
  relocalizer::FrameFileOptions frames;
  std::string list;
  std::string root;
  std::string orientation;      // the side that is up; empty: not stated
  std::vector<double> gravity;  // the rest: empty is none
  std::vector<double> prior;
  double prior_radius_m = 4;
  double prior_radius_deg = 25;
  std::vector<double> near;
  std::vector<double> height_band;
  std::vector<double> up;
  bool stream = false;
  relocalizer::StreamOptions stream_options;
  bool json = false;
};

// The turn that brings a side of a picture, one of --orientation's, to its top.
image::QuarterTurn UprightTurn(absl::string_view side_up) {
  if (side_up == "left") return image::QuarterTurn::kClockwise;
  if (side_up == "bottom") return image::QuarterTurn::kHalf;
  if (side_up == "right") return image::QuarterTurn::kCounterclockwise;
  return image::QuarterTurn::kNone;
}

geometry::Vec3 VectorOf(const std::vector<double>& xyz) {
  return {xyz[0], xyz[1], xyz[2]};
}

template <typename Prior>
absl::Status SetPrior(Prior prior, absl::string_view flag,
                      std::optional<Prior>& result) {
  const absl::Status valid = prior.Validate();
  if (!valid.ok()) return base::Annotate(valid, flag);
  result = std::move(prior);
  return absl::OkStatus();
}

// What the flags say of where the camera is.
absl::Status SetPriors(LocalizeFlags& flags) {
  geometry::PosePriors& priors = flags.query.priors;
  if (const std::vector<double>& p = flags.prior; !p.empty()) {
    const absl::StatusOr<geometry::Rigid3> pose = geometry::RigidFromQuaternion(
        p[0], p[1], p[2], p[3], {p[4], p[5], p[6]});
    if (!pose.ok()) return base::Annotate(pose.status(), "--prior");
    TL_RETURN_IF_ERROR(SetPrior(
        geometry::PosePrior{.world_from_camera = *pose,
                            .position_radius_m = flags.prior_radius_m,
                            .rotation_radius_rad = flags.prior_radius_deg *
                                                   std::numbers::pi / 180},
        "--prior", priors.pose));
  }
  if (!flags.near.empty()) {
    TL_RETURN_IF_ERROR(
        SetPrior(geometry::PositionPrior{VectorOf(flags.near), flags.near[3]},
                 "--near", priors.position));
  }
  if (flags.height_band.empty()) return absl::OkStatus();
  geometry::HeightBand band{.min_m = flags.height_band[0],
                            .max_m = flags.height_band[1]};
  if (!flags.up.empty()) band.up_in_world = VectorOf(flags.up);
  return SetPrior(band, "--height-band", priors.height);
}

// Reads a frame, which all have the same way up.
absl::StatusOr<wire::QueryFrame> ReadFrame(
    const LocalizeFlags& flags, const relocalizer::FrameFiles& files) {
  TL_ASSIGN_OR_RETURN(wire::QueryFrame frame,
                      relocalizer::ReadFrame(files, flags.frames));
  if (!flags.orientation.empty()) {
    frame.orientation = {UprightTurn(flags.orientation), /*is_certain=*/true};
  }
  if (!flags.gravity.empty()) {
    frame.gravity_in_camera_mps2 = VectorOf(flags.gravity);
  }
  return frame;
}

// A failure after which the other frames of a list would fail too, and slowly.
bool EndsTheList(const absl::Status& status) {
  return !absl::IsInvalidArgument(status) && !absl::IsInternal(status) &&
         !absl::IsDeadlineExceeded(status);
}

// Reads the files of one frame and asks about it. `asked`: whether it came as
// far as asking.
absl::StatusOr<relocalizer::LocalizeAnswer> ReadAndAsk(
    relocalizer::Relocalizer& client, const LocalizeFlags& flags,
    const relocalizer::FrameFiles& files, const std::stop_token& stop,
    ClientTracing& tracing, bool& asked) {
  asked = false;
  relocalizer::LocalizeQuery query = flags.query;
  TL_ASSIGN_OR_RETURN(query.frame, ReadFrame(flags, files));
  asked = true;
  TracedCall call(tracing);
  relocalizer::CallOptions options = CallOptionsOf(flags.connection, stop);
  options.traceparent = call.traceparent();
  absl::StatusOr<relocalizer::LocalizeAnswer> answer =
      client.Localize(query, options);
  call.End(answer);
  return answer;
}

int LocalizeOne(relocalizer::Relocalizer& client, const LocalizeFlags& flags,
                const std::stop_token& stop, ClientTracing& tracing) {
  bool asked = false;
  const absl::StatusOr<relocalizer::LocalizeAnswer> answer =
      ReadAndAsk(client, flags, flags.files, stop, tracing, asked);
  if (flags.json) {
    std::printf("%s\n", AnswerJson(flags.files, answer).c_str());
  } else if (answer.ok()) {
    std::fputs(AnswerText(*answer).c_str(), stdout);
  }
  const bool written = FlushOutput();
  if (!answer.ok()) {
    return asked ? ReportFailure(answer.status(), flags.connection, stop)
                 : ReportLocalFailure(answer.status());
  }
  if (!written) return kExitFailed;
  return answer->localized ? kExitLocalized : kExitNotLocalized;
}

// Asks about every frame, but for the rest of them if one fails in a way that
// the rest would too; then that failure is returned.
absl::Status AskForAll(relocalizer::Relocalizer& client,
                       const LocalizeFlags& flags,
                       const std::vector<relocalizer::FrameFiles>& list,
                       const std::stop_token& stop, ClientTracing& tracing,
                       AnswerSummary& summary) {
  // On a terminal the answers themselves show how far it is.
  base::Progress progress("localizing", static_cast<int64_t>(list.size()),
                          /*quiet=*/isatty(STDOUT_FILENO) == 1);
  for (const relocalizer::FrameFiles& files : list) {
    bool asked = false;
    const absl::StatusOr<relocalizer::LocalizeAnswer> answer =
        ReadAndAsk(client, flags, files, stop, tracing, asked);
    summary.Add(answer);
    std::printf("%s\n", flags.json ? AnswerJson(files, answer).c_str()
                                   : AnswerLine(files, answer).c_str());
    progress.Add(1);
    if (asked && !answer.ok() && EndsTheList(answer.status())) {
      return answer.status();
    }
  }
  return absl::OkStatus();
}

// Sends every frame as soon as the server has room for it, and prints the
// answers as they come.
absl::Status StreamAll(relocalizer::Relocalizer& client,
                       const LocalizeFlags& flags,
                       const std::vector<relocalizer::FrameFiles>& list,
                       const std::stop_token& stop, ClientTracing& tracing,
                       AnswerSummary& summary) {
  TracedCall call(tracing);
  relocalizer::StreamOptions options = flags.stream_options;
  options.stop = stop;
  options.traceparent = call.traceparent();
  const std::unique_ptr<relocalizer::LocalizeStream> stream =
      client.OpenStream(options);
  absl::Status unreadable;
  std::jthread sender([&] {
    relocalizer::LocalizeQuery query = flags.query;
    for (size_t i = 0; i < list.size(); ++i) {
      absl::StatusOr<wire::QueryFrame> frame = ReadFrame(flags, list[i]);
      if (!frame.ok()) {
        unreadable = frame.status();
        break;
      }
      query.frame = *std::move(frame);
      if (!stream->Send(i, query)) break;
    }
    stream->FinishSending();
  });
  base::Progress progress("localizing", static_cast<int64_t>(list.size()),
                          /*quiet=*/isatty(STDOUT_FILENO) == 1);
  while (const std::optional<relocalizer::StreamAnswer> next =
             stream->Receive()) {
    summary.Add(next->answer);
    if (next->id >= list.size()) continue;  // a server's fault, and counted
    const relocalizer::FrameFiles& files = list[next->id];
    std::printf("%s\n", flags.json ? AnswerJson(files, next->answer).c_str()
                                   : AnswerLine(files, next->answer).c_str());
    progress.Add(1);
  }
  sender.join();
  const absl::Status ended = stream->Finish();
  call.EndStream(ended);
  TL_RETURN_IF_ERROR(ended);
  return unreadable;
}

int LocalizeList(relocalizer::Relocalizer& client, const LocalizeFlags& flags,
                 const std::stop_token& stop, ClientTracing& tracing) {
  const absl::StatusOr<std::vector<relocalizer::FrameFiles>> list =
      relocalizer::ReadFrameList(flags.list, flags.root);
  if (!list.ok()) return ReportLocalFailure(list.status());
  AnswerSummary summary;
  const absl::Status ended =
      flags.stream ? StreamAll(client, flags, *list, stop, tracing, summary)
                   : AskForAll(client, flags, *list, stop, tracing, summary);
  const bool written = FlushOutput();
  std::fprintf(stderr, "%s\n", summary.Text().c_str());
  if (!ended.ok()) return ReportFailure(ended, flags.connection, stop);
  if (!written || summary.failed() > 0) return kExitFailed;
  return summary.localized() > 0 ? kExitLocalized : kExitNotLocalized;
}

int RunLocalize(LocalizeFlags flags, const std::stop_token& stop) {
  if (const absl::Status priors = SetPriors(flags); !priors.ok()) {
    ReportLocalFailure(priors);
    return kExitUsage;
  }
  if (flags.files.color.empty() == flags.list.empty()) {
    std::fprintf(stderr,
                 "treeline-client localize: give either --color or --list; "
                 "--help explains\n");
    return kExitUsage;
  }
  const auto client =
      relocalizer::ConnectRelocalizer(ConnectOptionsOf(flags.connection));
  if (!client.ok()) {
    return ReportFailure(client.status(), flags.connection, stop);
  }
  ClientTracing tracing;
  return flags.list.empty() ? LocalizeOne(**client, flags, stop, tracing)
                            : LocalizeList(**client, flags, stop, tracing);
}

void AddFlags(CLI::App& app, LocalizeFlags& flags) {
  AddConnectionFlags(app, flags.connection);
  CLI::Option* scene =
      app.add_option("--scene", flags.query.scene, "The scene to look in")
          ->type_name("NAME");
  app.add_option("--candidate-scene", flags.query.candidate_scenes,
                 "A scene that it may be; may be repeated. Without this and "
                 "--scene: any scene of the server")
      ->type_name("NAME")
      ->excludes(scene);
  app.add_option("--time-budget-ms", flags.query.time_budget_ms,
                 "Most that the server may take")
      ->check(CLI::PositiveNumber);
  app.add_option("--min-confidence", flags.query.min_confidence,
                 "Least confidence of an answer (default: the scene's "
                 "threshold); lower only if you check poses yourself")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--prior", flags.prior,
                 "Pose that an answer must be near: qw,qx,qy,qz,tx,ty,tz of "
                 "world_from_camera (m)")
      ->type_name("POSE")
      ->delimiter(',')
      ->expected(7);
  app.add_option("--prior-radius-m", flags.prior_radius_m,
                 "How far from it the position may be")
      ->capture_default_str();
  app.add_option("--prior-radius-deg", flags.prior_radius_deg,
                 "How far from it the rotation may be")
      ->capture_default_str();
  app.add_option("--near", flags.near,
                 "Place that an answer must be near: x,y,z in the world and a "
                 "radius (m)")
      ->type_name("X,Y,Z,R")
      ->delimiter(',')
      ->expected(4);
  CLI::Option* height_band =
      app.add_option("--height-band", flags.height_band,
                     "Heights that an answer must lie between (m)")
          ->type_name("MIN,MAX")
          ->delimiter(',')
          ->expected(2);
  app.add_option("--up", flags.up,
                 "Upwards in the world, for --height-band; without: z")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->needs(height_band);
  app.add_option("--model-version", flags.query.model_version,
                 "Version of its model; without: the newest")
      ->type_name("VERSION");
  CLI::Option* color =
      app.add_option("--color", flags.files.color, "Colour image, JPEG or PNG")
          ->type_name("FILE");
  CLI::Option* depth =
      app.add_option("--depth", flags.files.depth, "Depth image, 16-bit PNG")
          ->type_name("FILE")
          ->needs(color);
  CLI::Option* root =
      app.add_option("--root", flags.root, "Folder of the stems in --list")
          ->type_name("DIR");
  CLI::Option* list =
      app.add_option("--list", flags.list, "File with one stem a line")
          ->type_name("FILE")
          ->needs(root)
          ->excludes(color)
          ->excludes(depth);
  root->needs(list);
  CLI::Option* stream =
      app.add_flag("--stream", flags.stream,
                   "Send the list as one stream, computed side by side")
          ->needs(list);
  app.add_flag("--drop-oldest", flags.stream_options.drop_oldest,
               "Of a stream that waits, drop the oldest frame rather than "
               "send more slowly")
      ->needs(stream);
  app.add_option("--max-pending", flags.stream_options.max_pending,
                 "Frames of a stream that may wait; 0: as the server likes")
      ->check(CLI::Range(0, 64))
      ->needs(stream);
  app.add_option("--depth-unit", flags.frames.depth_unit_m,
                 "Metres per unit of depth")
      ->capture_default_str()
      ->type_name("M");
  app.add_flag("--registered", flags.frames.depth_is_registered,
               "Depth pixel (x, y) sees what colour pixel (x, y) sees");
  app.add_option("--camera", flags.frames.camera,
                 "Intrinsics of the colour image: COLMAP's model name and "
                 "parameters")
      ->type_name("MODEL,PARAMS");
  app.add_option("--orientation", flags.orientation,
                 "Side of the picture, as it is sent, that is up; without: as "
                 "--gravity or EXIF say, and if they do not, all are tried")
      ->check(CLI::IsMember({"top", "right", "bottom", "left"}));
  app.add_option("--gravity", flags.gravity,
                 "Where things fall, in the frame of the colour camera (x "
                 "right, y down, z forward)")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3);
  app.add_option("--seed", flags.query.seed,
                 "The same seed gives the same answer, bit for bit")
      ->capture_default_str();
  app.add_flag("--json", flags.json, "One JSON object a line for each frame");
}

}  // namespace

ClientCommand AddLocalizeCommand(CLI::App& app) {
  auto flags = std::make_shared<LocalizeFlags>();
  CLI::App* command = app.add_subcommand(
      "localize", "Ask where a frame, or a list of frames, was taken");
  command->footer(kFooter);
  AddFlags(*command, *flags);
  return {command, [flags](const std::stop_token& stop) {
            return RunLocalize(*flags, stop);
          }};
}

}  // namespace treeline::client_cli
