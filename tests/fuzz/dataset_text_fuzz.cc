// The text files of recordings, as arbitrary bytes: no crash, and no pose that
// is not rigid.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "common/dataset/text_formats.h"
#include "tests/fuzz/check_rigid.h"

namespace treeline {
namespace {

void ParseEveryWay(absl::string_view text) {
  if (const auto pose = dataset::ParsePoseMatrix(text, "fuzz"); pose.ok()) {
    CheckRigid(*pose);
  }
  if (const auto poses = dataset::ParseStemPoses(text, "fuzz"); poses.ok()) {
    for (const dataset::StemPose& pose : *poses)
      CheckRigid(pose.world_from_camera);
  }
  if (const auto poses = dataset::ParseTimedPoses(text, "fuzz"); poses.ok()) {
    for (const dataset::TimedPose& pose : *poses)
      CheckRigid(pose.world_from_camera);
  }
  if (const auto files = dataset::ParseTimedFiles(text, "fuzz"); files.ok()) {
    for (size_t i = 1; i < files->size(); ++i) {
      if ((*files)[i].time <= (*files)[i - 1].time) std::abort();
    }
  }
  if (const auto stems = dataset::ParseFrameList(text, "fuzz"); stems.ok()) {
    if (stems->empty()) std::abort();
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::ParseEveryWay(
      absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
