// What a scene looks like, small enough to compare a frame with hundreds of
// scenes whose models are not loaded.
#ifndef SERVER_CORE_RECOGNITION_SCENE_DESCRIPTOR_H_
#define SERVER_CORE_RECOGNITION_SCENE_DESCRIPTOR_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::recognition {

// The set of words (see AppearanceWords) that occur in a scene's training
// images. A value; an empty one is a scene that no image is known of.
class SceneDescriptor {
 public:
  // A word for every bit: word w is bit w % 64 of entry w / 64.
  static constexpr size_t kEntries = (size_t{1} << 20) / 64;

  SceneDescriptor() : bits_(kEntries, 0) {}

  // Of an image; the order of images does not matter.
  void Add(std::span<const uint32_t> words);
  // All that `other` has too.
  void Merge(const SceneDescriptor& other);

  std::span<const uint64_t> bits() const { return bits_; }
  // Images that it was made of.
  uint32_t images() const { return images_; }
  // Share of all words that occur, in [0, 1].
  double Fill() const;

  // As the model file holds it: docs/reference/model-format.md.
  std::string Serialize() const;
  // DATA_LOSS: not what Serialize gives. UNIMPLEMENTED: of another vocabulary,
  // that is of another version. Safe on hostile bytes.
  static absl::StatusOr<SceneDescriptor> Parse(absl::string_view bytes);

  bool operator==(const SceneDescriptor&) const = default;

 private:
  std::vector<uint64_t> bits_;
  uint32_t images_ = 0;
};

// The descriptor in a model file. Reads the file's header, its table of
// sections and this one section, which has a checksum of its own; the rest may
// be corrupt. NOT_FOUND: no such file, or a model without a descriptor (of an
// older version; train it anew, or extend it). Otherwise as ModelFile::Open
// and SceneDescriptor::Parse. Safe on hostile files.
absl::StatusOr<SceneDescriptor> ReadSceneDescriptor(
    const std::string& model_path);

}  // namespace treeline::recognition

#endif  // SERVER_CORE_RECOGNITION_SCENE_DESCRIPTOR_H_
