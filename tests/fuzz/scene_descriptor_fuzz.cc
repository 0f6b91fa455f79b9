// Scene descriptors as arbitrary bytes: refused, or safe to rank with. The
// bytes are also taken as the beginning of a descriptor that is whole, so that
// mutations reach what lies behind the checksum.
#include <xxhash.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "server/core/recognition/appearance_words.h"
#include "server/core/recognition/scene_descriptor.h"
#include "server/core/recognition/scene_index.h"

namespace treeline {
namespace {

constexpr size_t kHeader_bytes = 16;
constexpr size_t kBytes = kHeader_bytes + recognition::kWords / 8;

std::string Completed(std::string bytes) {
  bytes.resize(kBytes);
  std::memcpy(bytes.data(), &recognition::kVocabulary, 4);
  uint32_t images = 0;
  std::memcpy(&images, bytes.data() + 4, 4);
  const uint64_t checksum = XXH3_64bits_withSeed(
      bytes.data() + kHeader_bytes, kBytes - kHeader_bytes, images);
  std::memcpy(bytes.data() + 8, &checksum, 8);
  return bytes;
}

void RankWith(const treeline::recognition::SceneDescriptor& descriptor) {
  recognition::SceneIndex index;
  index.Set("scene", descriptor);
  const std::vector<uint32_t> words = {0, 1, 4711, recognition::kWords - 1, 0};
  const std::vector<recognition::SceneScore> ranking = index.RankWords(words);
  if (ranking.size() != 1) std::abort();
  if (!(ranking[0].similarity >= 0 && ranking[0].similarity <= 1)) std::abort();
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using treeline::recognition::SceneDescriptor;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  if (const auto read = treeline::recognition::SceneDescriptor::Parse(bytes);
      read.ok() && read->Serialize() != bytes) {
    std::abort();
  }
  const std::string whole = treeline::Completed(bytes);
  const auto read = treeline::recognition::SceneDescriptor::Parse(whole);
  if (!read.ok() || read->Serialize() != whole) std::abort();
  // Ranking costs some milliseconds.
  if (size % 16 == 0) treeline::RankWith(*read);
  return 0;
}
