// Lines that tell a live learner of frames, as arbitrary bytes: no crash, and
// no pose that is not rigid.
#include <cstddef>
#include <cstdint>
#include <variant>

#include "absl/strings/string_view.h"
#include "server/tools/learning/live_source.h"
#include "tests/fuzz/check_rigid.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto item = treeline::learning::ParseLiveLine(
      absl::string_view(reinterpret_cast<const char*>(data), size));
  if (!item.ok() || !item->has_value()) return 0;
  if (const auto* frame = std::get_if<treeline::learning::LiveFrame>(&**item)) {
    treeline::CheckRigid(frame->world_from_sensor);
  }
  if (const auto* pose =
          std::get_if<treeline::learning::PoseCorrection>(&**item)) {
    treeline::CheckRigid(pose->world_from_sensor);
  }
  return 0;
}
