// Blobs of RTAB-Map's databases, as arbitrary bytes: no crash, and cameras,
// poses and depth that are ones. The first byte says which blob it is.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "common/image/image.h"
#include "server/tools/capture/rtabmap_blobs.h"
#include "tests/fuzz/check_rigid.h"

namespace treeline {
namespace {

constexpr image::ImageSize kPicture{640, 480};

void ParseCalibration(capture::Bytes blob) {
  for (const capture::RtabmapVersion& version :
       {capture::RtabmapVersion{{0, 23, 0}},
        capture::RtabmapVersion{{0, 17, 0}},
        capture::RtabmapVersion{{0, 10, 0}}}) {
    const auto cameras =
        capture::ParseRtabmapCalibration(blob, version, kPicture);
    if (!cameras.ok()) continue;
    if (cameras->empty()) std::abort();
    for (const capture::RtabmapCamera& camera : *cameras) {
      CheckRigid(camera.base_from_camera);
    }
  }
}

void ParseMatrices(capture::Bytes blob) {
  // Ids and poses, one after the other: where the one ends, the first byte
  // says.
  if (blob.empty()) return;
  const size_t ids = blob[0];
  blob = blob.subspan(1);
  if (ids > blob.size()) return;
  const auto poses =
      capture::ParseOptimizedPoses(blob.first(ids), blob.subspan(ids));
  if (!poses.ok()) return;
  for (const auto& [id, pose] : *poses) CheckRigid(pose);
}

void DecodeDepth(capture::Bytes blob) {
  const auto depth = capture::DecodeRtabmapDepth(blob, 0.001);
  if (depth.ok() &&
      depth->values.size() != static_cast<size_t>(depth->width) *
                                  static_cast<size_t>(depth->height)) {
    std::abort();
  }
}

void Parse(capture::Bytes bytes) {
  if (bytes.empty()) return;
  const capture::Bytes blob = bytes.subspan(1);
  switch (bytes[0] % 4) {
    case 0:
      ParseCalibration(blob);
      break;
    case 1:
      ParseMatrices(blob);
      break;
    case 2:
      DecodeDepth(blob);
      break;
    default:
      capture::ParseDepthConfidence(blob, {64, 48}).IgnoreError();
      if (const auto pose = capture::ParseRtabmapPose(blob); pose.ok()) {
        CheckRigid(*pose);
      }
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Parse(std::span(data, size));
  return 0;
}
