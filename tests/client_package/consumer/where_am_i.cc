// A program of somebody else's, as docs/how-to/use-from-cpp.md shows it: asks
// for one picture, and says where it was taken.
//
//   where_am_i SERVER SCENE COLOR DEPTH
#include <chrono>
#include <cstdio>
#include <string>

#include "client/fusion/drift_corrector.h"
#include "client/relocalizer/frame_files.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "common/base/error_info.h"

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "where_am_i SERVER SCENE COLOR DEPTH\n");
    return 2;
  }
  auto client = treeline::relocalizer::ConnectRelocalizer({.server = argv[1]});
  auto frame = treeline::relocalizer::ReadFrame(
      {.color = argv[3], .depth = argv[4]}, {});
  if (!client.ok() || !frame.ok()) {
    std::fprintf(stderr, "%s\n%s\n", client.status().ToString().c_str(),
                 frame.status().ToString().c_str());
    return 1;
  }
  const auto answer =
      (*client)->Localize({.scene = argv[2], .frame = *frame},
                          {.timeout = std::chrono::seconds(30)});
  if (!answer.ok()) {
    const std::string reason =
        treeline::base::ErrorInfoOf(answer.status()).reason;
    std::printf("error %s: %s\n", reason.c_str(),
                std::string(answer.status().message()).c_str());
    return 1;
  }
  if (!answer->localized) {
    std::printf("not localized: %s\n", answer->reason.c_str());
    return 3;
  }
  const treeline::geometry::Vec3& at = answer->world_from_camera.translation;
  std::printf("localized %.17g %.17g %.17g\n", at.x, at.y, at.z);

  // Its own tracking and the answer become one world.
  auto world = treeline::drift::DriftCorrector::Create();
  const std::chrono::nanoseconds now(1);
  if (!world.ok() || !world->Track(now, {}).ok() ||
      !world
           ->AddFix({.capture_time = now,
                     .world_from_camera = answer->world_from_camera,
                     .covariance = answer->covariance,
                     .confidence = answer->confidence})
           .ok()) {
    return 1;
  }
  std::printf("world %s\n",
              std::string(treeline::drift::NameOf(world->state())).c_str());
  return 0;
}
