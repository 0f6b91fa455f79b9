// Model files as arbitrary bytes: refused, or safe to predict with. The header
// is completed first (magic, version, lengths, checksum), so that mutations
// reach what lies behind it.
#include <unistd.h>
#include <xxhash.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "server/core/forest/backtracking.h"
#include "server/core/forest/model_file.h"
#include "server/core/training/quantize_forest.h"
#include "server/core/training/tree_part.h"

namespace treeline {
namespace {

constexpr size_t kHeader_bytes = 64;
constexpr size_t kSection_bytes = 24;
constexpr uint64_t kLongestExtra_bytes = 1 << 20;

// What the sections say that they take in memory;
// docs/reference/model-format.md has the rule.
uint64_t MemoryBytes(const std::string& file) {
  const auto number_at = [&](uint64_t offset, size_t bytes) {
    uint64_t value = 0;
    if (offset <= file.size() && bytes <= file.size() - offset) {
      std::memcpy(&value, file.data() + offset, bytes);
    }
    return value;
  };
  const uint64_t sections = number_at(12, 4);
  uint64_t end = kHeader_bytes + kSection_bytes * sections;
  for (uint64_t i = 0; i < sections && i < 64; ++i) {
    const uint64_t entry = kHeader_bytes + kSection_bytes * i;
    const bool is_packed = (number_at(entry, 4) >> 31) != 0;
    end = (end + 63) / 64 * 64 + (is_packed
                                      ? number_at(number_at(entry + 8, 8), 8)
                                      : number_at(entry + 16, 8));
  }
  return end;
}

void CompleteHeader(std::string& file) {
  if (file.size() < kHeader_bytes) return;
  const uint32_t version = file[8] == 1 ? 1 : forest::kModelFormatVersion;
  const uint64_t size = file.size();
  if (version > 1) {
    const uint64_t memory = MemoryBytes(file);
    std::memcpy(file.data() + 32, &memory, 8);
  }
  uint64_t checksum = 0;
  std::memcpy(file.data(), "TREELINE", 8);
  std::memcpy(file.data() + 8, &version, 4);
  std::memcpy(file.data() + 16, &size, 8);
  std::memcpy(file.data() + 24, &checksum, 8);
  checksum = XXH3_64bits_withSeed(file.data() + kHeader_bytes,
                                  file.size() - kHeader_bytes,
                                  XXH3_64bits(file.data(), kHeader_bytes));
  std::memcpy(file.data() + 24, &checksum, 8);
}

void PredictWith(const forest::ForestView& forest) {
  const features::PlanarImage image(
      image::ColorImage{16, 8, std::vector<uint8_t>(3 * 16 * 8)});
  const std::vector<int32_t> x = {0, 15, 7};
  const std::vector<int32_t> y = {0, 7, 3};
  const std::vector<int32_t> inverse_depth = {1, 4096, 65535};
  const std::vector<features::WhtDescriptor> descriptors(x.size());
  std::vector<forest::LeafMatch> matches(x.size() *
                                         static_cast<size_t>(forest.trees()));
  forest::BacktrackingScratch scratch;
  forest::PredictLeaves(forest, image, {x, y, inverse_depth}, descriptors,
                        {.leaves = 5}, {}, scratch, matches);
  for (const forest::LeafMatch& match : matches) {
    if (match.leaf >= forest.payloads.size()) std::abort();
    if (!geometry::IsFinite(forest.LeafMean(match.leaf))) std::abort();
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string path =
      "/dev/shm/model_file_fuzz." + std::to_string(getpid());
  std::string file(reinterpret_cast<const char*>(data), size);
  treeline::CompleteHeader(file);
  if (!treeline::base::WriteFileAtomically(path, file).ok()) std::abort();
  const auto model = treeline::forest::ModelFile::Open(path);
  // One section alone, whatever the rest is.
  for (const uint32_t kind : {8u, 9u, 10u, 11u}) {
    const auto extra = treeline::forest::ReadModelExtra(
        path, static_cast<treeline::forest::ModelExtra>(kind),
        treeline::kLongestExtra_bytes);
    if (extra.ok() && extra->size() > treeline::kLongestExtra_bytes) {
      std::abort();
    }
  }
  const auto part = treeline::training::ReadTreePart(path);
  unlink(path.c_str());
  for (size_t t = 0; part.ok() && t < part->trees.size(); ++t) {
    const treeline::forest::Forest forest =
        treeline::training::QuantizeForest({part->trees[t]});
    if (!forest.View().Validate().ok()) std::abort();
  }
  for (size_t f = 0; model.ok() && f < (*model)->forests(); ++f) {
    const treeline::forest::ForestView& forest = (*model)->forest(f);
    if (forest.trees() <= 64 && forest.sift_descriptors.empty()) {
      treeline::PredictWith(forest);
    }
  }
  return 0;
}
