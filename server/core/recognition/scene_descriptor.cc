#include "server/core/recognition/scene_descriptor.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_file.h"
#include "server/core/recognition/appearance_words.h"

namespace treeline::recognition {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is little-endian");
static_assert(SceneDescriptor::kEntries * 64 == kWords);

struct Header {
  uint32_t vocabulary;
  uint32_t images;
  uint64_t checksum;  // XXH3-64 of what follows, seeded with `images`
};
static_assert(sizeof(Header) == 16);

constexpr size_t kBytes =
    sizeof(Header) + SceneDescriptor::kEntries * sizeof(uint64_t);

uint64_t Checksum(const Header& header, const void* bits) {
  return XXH3_64bits_withSeed(bits, kBytes - sizeof(Header), header.images);
}

}  // namespace

void SceneDescriptor::Add(std::span<const uint32_t> words) {
  for (const uint32_t word : words) {
    bits_[word / 64] |= uint64_t{1} << (word % 64);
  }
  ++images_;
}

void SceneDescriptor::Merge(const SceneDescriptor& other) {
  for (size_t i = 0; i < kEntries; ++i) bits_[i] |= other.bits_[i];
  images_ += other.images_;
}

double SceneDescriptor::Fill() const {
  int64_t set = 0;
  for (const uint64_t entry : bits_) set += std::popcount(entry);
  return static_cast<double>(set) / kWords;
}

std::string SceneDescriptor::Serialize() const {
  Header header{.vocabulary = kVocabulary, .images = images_, .checksum = 0};
  header.checksum = Checksum(header, bits_.data());
  std::string bytes(kBytes, '\0');
  std::memcpy(bytes.data(), &header, sizeof(header));
  std::memcpy(bytes.data() + sizeof(header), bits_.data(),
              kBytes - sizeof(header));
  return bytes;
}

absl::StatusOr<SceneDescriptor> SceneDescriptor::Parse(
    absl::string_view bytes) {
  Header header;
  if (bytes.size() < sizeof(header)) {
    return absl::DataLossError("corrupt model: a short scene descriptor");
  }
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.vocabulary != kVocabulary) {
    return absl::UnimplementedError(absl::StrCat(
        "the scene descriptor has vocabulary ", header.vocabulary,
        ", this software reads ", kVocabulary, "; train the scene anew"));
  }
  if (bytes.size() != kBytes) {
    return absl::DataLossError(
        "corrupt model: a scene descriptor of odd length");
  }
  bytes.remove_prefix(sizeof(header));
  if (Checksum(header, bytes.data()) != header.checksum) {
    return absl::DataLossError(
        "corrupt model: checksum mismatch in the scene descriptor");
  }
  SceneDescriptor descriptor;
  descriptor.images_ = header.images;
  std::memcpy(descriptor.bits_.data(), bytes.data(), bytes.size());
  return descriptor;
}

absl::StatusOr<SceneDescriptor> ReadSceneDescriptor(
    const std::string& model_path) {
  TL_ASSIGN_OR_RETURN(
      const std::string bytes,
      forest::ReadModelExtra(model_path, forest::ModelExtra::kSceneDescriptor,
                             kBytes));
  absl::StatusOr<SceneDescriptor> descriptor = SceneDescriptor::Parse(bytes);
  if (!descriptor.ok()) return base::Annotate(descriptor.status(), model_path);
  return descriptor;
}

}  // namespace treeline::recognition
