// Keyframes by what they look like.
#ifndef NAV_AGENT_RGBD_SLAM_WORD_INDEX_H_
#define NAV_AGENT_RGBD_SLAM_WORD_INDEX_H_

#include <array>
#include <cstdint>
#include <vector>

#include "nav_agent/rgbd_slam/binary_features.h"

namespace treeline::rgbd_slam {

// An inverted index without a vocabulary to train: each descriptor gives a
// few words, each of them some of its bits, drawn by seed (locality-sensitive
// hashing of Hamming distance; Indyk, Motwani 1998). Descriptors of the same
// corner share a word often, others seldom.
class WordIndex {
 public:
  explicit WordIndex(uint64_t seed);

  // Keyframes are numbered as they are added: 0, 1, ...
  void Add(const FeatureSet& features);

  // For each keyframe, the words shared with `features`, a rare one counting
  // for more (inverse document frequency).
  std::vector<double> Score(const FeatureSet& features) const;

 private:
  static constexpr int kTables = 4;
  static constexpr int kBits = 14;

  std::array<uint32_t, kTables> WordsOf(
      const BinaryDescriptor& descriptor) const;

  std::array<std::array<uint8_t, kBits>, kTables> bits_{};
  // keyframes_[table << kBits | word]: who has the word, each once.
  std::vector<std::vector<int>> keyframes_;
  int count_ = 0;
};

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_WORD_INDEX_H_
