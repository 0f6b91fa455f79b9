#include "nav_agent/rgbd_slam/word_index.h"

#include <cmath>
#include <cstddef>

#include "common/base/random.h"

namespace treeline::rgbd_slam {

WordIndex::WordIndex(uint64_t seed)
    : keyframes_(static_cast<size_t>(kTables) << kBits) {
  constexpr uint64_t kStream = 0x776f726473;
  base::Random random(seed, kStream);
  for (auto& table : bits_) {
    for (uint8_t& bit : table) {
      bit = static_cast<uint8_t>(random.NextBelow(256));
    }
  }
}

std::array<uint32_t, WordIndex::kTables> WordIndex::WordsOf(
    const BinaryDescriptor& descriptor) const {
  std::array<uint32_t, kTables> words{};
  for (size_t table = 0; table < kTables; ++table) {
    auto word = static_cast<uint32_t>(table);
    for (const uint8_t bit : bits_[table]) {
      word = word << 1 |
             static_cast<uint32_t>(descriptor[bit / 64] >> (bit % 64) & 1);
    }
    words[table] = word;
  }
  return words;
}

void WordIndex::Add(const FeatureSet& features) {
  for (const ImageFeature& feature : features.all()) {
    for (const uint32_t word : WordsOf(feature.descriptor)) {
      std::vector<int>& list = keyframes_[word];
      if (list.empty() || list.back() != count_) list.push_back(count_);
    }
  }
  ++count_;
}

std::vector<double> WordIndex::Score(const FeatureSet& features) const {
  std::vector<double> scores(static_cast<size_t>(count_), 0);
  for (const ImageFeature& feature : features.all()) {
    for (const uint32_t word : WordsOf(feature.descriptor)) {
      const std::vector<int>& list = keyframes_[word];
      if (list.empty()) continue;
      const double weight =
          std::log(1 + count_ / static_cast<double>(list.size()));
      for (const int keyframe : list) {
        scores[static_cast<size_t>(keyframe)] += weight;
      }
    }
  }
  return scores;
}

}  // namespace treeline::rgbd_slam
