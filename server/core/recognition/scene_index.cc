#include "server/core/recognition/scene_index.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "server/core/recognition/appearance_words.h"

namespace treeline::recognition {
namespace {

// Chosen on training frames; docs/research/scene-recognition.md.
constexpr double kMinFill = 0.02;
constexpr double kFillPower = 0.5;
// Votes are fixed-point numbers: so many are an idf of 1.
constexpr double kVoteUnit = 1024;

uint32_t Vote(size_t scenes, size_t scenes_with_word) {
  const double idf = std::log((static_cast<double>(scenes) + 1) /
                              (static_cast<double>(scenes_with_word) + 0.5));
  return static_cast<uint32_t>(std::lround(kVoteUnit * idf));
}

// Adds votes[i] to the sum of every scene that has words[i].
void CountVotes(std::span<const uint64_t> scenes_of_word,
                std::span<const uint32_t> words,
                std::span<const uint32_t> votes, std::span<uint32_t, 64> sums) {
  for (size_t i = 0; i < words.size(); ++i) {
    uint64_t scenes = scenes_of_word[words[i]];
    while (scenes != 0) {
      sums[static_cast<size_t>(std::countr_zero(scenes))] += votes[i];
      scenes &= scenes - 1;
    }
  }
}

}  // namespace

SceneIndex::Block::Block() : scenes_of_word(kWords, 0) {}

void SceneIndex::Set(const std::string& scene,
                     const SceneDescriptor& descriptor) {
  const double chance =
      std::pow(kMinFill / std::max(kMinFill, descriptor.Fill()), kFillPower);
  absl::MutexLock lock(&mutex_);
  const auto [found, is_new] = slots_.try_emplace(scene);
  Slot& slot = found->second;
  if (is_new) {
    if (free_slots_.empty()) {
      for (size_t i = kBlockScenes; i > 0; --i) {
        free_slots_.push_back(kBlockScenes * blocks_.size() + i - 1);
      }
      blocks_.push_back(std::make_unique<Block>());
    }
    slot.number = free_slots_.back();
    free_slots_.pop_back();
  } else {
    Clear(slot.number);
  }
  slot.chance = chance;
  std::vector<uint64_t>& scenes_of_word =
      blocks_[slot.number / kBlockScenes]->scenes_of_word;
  const uint64_t bit = uint64_t{1} << (slot.number % kBlockScenes);
  const std::span<const uint64_t> bits = descriptor.bits();
  for (size_t i = 0; i < bits.size(); ++i) {
    uint64_t words = bits[i];
    while (words != 0) {
      scenes_of_word[64 * i + static_cast<size_t>(std::countr_zero(words))] |=
          bit;
      words &= words - 1;
    }
  }
}

bool SceneIndex::Remove(const std::string& scene) {
  absl::MutexLock lock(&mutex_);
  const auto found = slots_.find(scene);
  if (found == slots_.end()) return false;
  Clear(found->second.number);
  free_slots_.push_back(found->second.number);
  slots_.erase(found);
  return true;
}

void SceneIndex::Clear(size_t slot) {
  const uint64_t bit = uint64_t{1} << (slot % kBlockScenes);
  for (uint64_t& scenes : blocks_[slot / kBlockScenes]->scenes_of_word) {
    scenes &= ~bit;
  }
}

bool SceneIndex::Contains(const std::string& scene) const {
  absl::ReaderMutexLock lock(&mutex_);
  return slots_.contains(scene);
}

size_t SceneIndex::size() const {
  absl::ReaderMutexLock lock(&mutex_);
  return slots_.size();
}

std::vector<SceneScore> SceneIndex::Rank(
    const image::Frame& frame,
    std::optional<std::span<const std::string>> candidates) const {
  AppearanceWords words;
  return RankWords(words.Extract(frame.color), candidates);
}

std::vector<SceneScore> SceneIndex::RankWords(
    std::span<const uint32_t> words,
    std::optional<std::span<const std::string>> candidates) const {
  std::vector<SceneScore> ranking;
  absl::ReaderMutexLock lock(&mutex_);
  std::vector<uint32_t> vote_of_count(slots_.size() + 1);
  for (size_t n = 0; n < vote_of_count.size(); ++n) {
    vote_of_count[n] = Vote(slots_.size(), n);
  }
  std::vector<uint32_t> votes(words.size());
  uint64_t all = 0;
  for (size_t i = 0; i < words.size(); ++i) {
    size_t count = 0;
    for (const auto& block : blocks_) {
      count +=
          static_cast<size_t>(std::popcount(block->scenes_of_word[words[i]]));
    }
    votes[i] = vote_of_count[count];
    all += votes[i];
  }
  std::vector<std::array<uint32_t, kBlockScenes>> sums(blocks_.size());
  for (size_t b = 0; b < blocks_.size(); ++b) {
    CountVotes(blocks_[b]->scenes_of_word, words, votes, sums[b]);
  }
  const auto add = [&](const std::string& scene, const Slot& slot) {
    const uint32_t sum =
        sums[slot.number / kBlockScenes][slot.number % kBlockScenes];
    ranking.push_back({scene, all == 0
                                  ? 0
                                  : slot.chance * static_cast<double>(sum) /
                                        static_cast<double>(all)});
  };
  if (!candidates) {
    for (const auto& [scene, slot] : slots_) add(scene, slot);
  } else {
    for (const std::string& scene : *candidates) {
      const auto found = slots_.find(scene);
      if (found != slots_.end()) add(scene, found->second);
    }
  }
  std::ranges::sort(ranking, [](const SceneScore& a, const SceneScore& b) {
    if (a.similarity != b.similarity) return a.similarity > b.similarity;
    return a.scene < b.scene;
  });
  return ranking;
}

}  // namespace treeline::recognition
