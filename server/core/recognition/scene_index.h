// Which scene does a frame show? Ranks scenes by what they look like.
#ifndef SERVER_CORE_RECOGNITION_SCENE_INDEX_H_
#define SERVER_CORE_RECOGNITION_SCENE_INDEX_H_

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/image/frame.h"
#include "server/core/recognition/scene_descriptor.h"

namespace treeline::recognition {

struct SceneScore {
  std::string scene;
  // How alike the frame and the scene look, in [0, 1]; comparable within one
  // ranking only.
  double similarity = 0;

  bool operator==(const SceneScore&) const = default;
};

// The descriptors of many scenes, turned round: for every word, the scenes
// that it occurs in. 8 MiB of memory for every 64 scenes. Thread-safe: Rank
// runs on many threads at once, Set and Remove wait for it and it for them.
class SceneIndex {
 public:
  SceneIndex() = default;
  SceneIndex(const SceneIndex&) = delete;
  SceneIndex& operator=(const SceneIndex&) = delete;

  // Adds a scene, or replaces what was known of it. Some milliseconds.
  void Set(const std::string& scene, const SceneDescriptor& descriptor);
  // Whether it was there.
  bool Remove(const std::string& scene);

  bool Contains(const std::string& scene) const;
  size_t size() const;

  // Scenes, the most alike first and by name among equals. The similarity of
  // scene s to a frame of words W is
  //   sum of idf(w) over w in W that occur in s
  //   / sum of idf(w) over w in W * (kMinFill / fill(s)) ^ kFillPower
  // with idf(w) = log((N + 1) / (n(w) + 1/2)), n(w) of the N scenes having w,
  // and fill(s), at least kMinFill, the share of all words that s has: a
  // scene of many words has some of any frame's by chance.
  //
  // candidates: those to rank; names that are not in the index are left out.
  // nullopt: all. Of the frame, the colour alone is looked at.
  std::vector<SceneScore> Rank(const image::Frame& frame,
                               std::optional<std::span<const std::string>>
                                   candidates = std::nullopt) const;
  // The same for the words of a frame: see AppearanceWords.
  std::vector<SceneScore> RankWords(std::span<const uint32_t> words,
                                    std::optional<std::span<const std::string>>
                                        candidates = std::nullopt) const;

 private:
  static constexpr size_t kBlockScenes = 64;
  // Scenes of slots 64 b to 64 b + 63: bit i of entry w says whether scene i
  // of them has word w.
  struct Block {
    Block();
    std::vector<uint64_t> scenes_of_word;
  };
  struct Slot {
    size_t number = 0;
    double chance = 1;  // (kMinFill / fill) ^ kFillPower
  };

  void Clear(size_t slot) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable absl::Mutex mutex_;
  std::map<std::string, Slot> slots_ ABSL_GUARDED_BY(mutex_);
  std::vector<size_t> free_slots_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::unique_ptr<Block>> blocks_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::recognition

#endif  // SERVER_CORE_RECOGNITION_SCENE_INDEX_H_
