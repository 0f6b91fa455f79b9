// What a load generator asks: requests made from recorded frames.
#ifndef CLIENT_BENCH_WORKLOAD_H_
#define CLIENT_BENCH_WORKLOAD_H_

#include <grpcpp/support/byte_buffer.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/relocalizer/frame_files.h"
#include "common/geometry/rigid3.h"

namespace treeline::bench {

// Frames of one recording, asked for in one scene.
struct SceneFrames {
  std::string scene;
  std::string root;
  // As in ReadFrameList.
  std::string list;

  // "NAME=ROOT,LIST"; ",LIST" may be left out: ROOT/test.txt.
  static absl::StatusOr<SceneFrames> Parse(absl::string_view text);
};

// How a frame is sent.
struct FrameEncoding {
  enum class Color { kAsRecorded, kJpeg, kPng, kRaw };
  enum class Depth { kPng, kRaw, kNone };
  Color color = Color::kAsRecorded;
  Depth depth = Depth::kPng;

  // "COLOUR+DEPTH" of file|jpeg|png|raw and png|raw|none; without "+DEPTH" it
  // is png.
  static absl::StatusOr<FrameEncoding> Parse(absl::string_view text);
  std::string Name() const;
};

struct WorkloadOptions {
  std::vector<SceneFrames> scenes;
  // Every frame is asked for in each of them.
  std::vector<FrameEncoding> encodings = {FrameEncoding{}};
  relocalizer::FrameFileOptions frames;
  // Most frames of a scene, spread over its list; at least 1.
  int max_frames = 32;
  // Of the queries, and of their order.
  uint64_t seed = 0;
};

// One query, ready to be sent.
struct WorkItem {
  std::string scene;
  std::string stem;
  std::string encoding;
  // A serialised LocalizeRequest.
  grpc::ByteBuffer request;
  // True pose of the recording's pose sensor, where it is known.
  std::optional<geometry::Rigid3> world_from_camera;
};

// Reads and encodes every frame, in memory, in an order that mixes scenes and
// encodings. Errors name the file.
absl::StatusOr<std::vector<WorkItem>> LoadWorkload(
    const WorkloadOptions& options);

}  // namespace treeline::bench

#endif  // CLIENT_BENCH_WORKLOAD_H_
