// Which keyframes a frame looks like: an inverted file over words of their own
// features (Sivic and Zisserman 2003) with signatures inside the words (Hamming
// embedding, Jegou et al. 2008).
#ifndef SERVER_CORE_KEYFRAMES_KEYFRAME_INDEX_H_
#define SERVER_CORE_KEYFRAMES_KEYFRAME_INDEX_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/features/sift_descriptor.h"
#include "server/core/features/sift_matching.h"

namespace treeline::keyframes {

// The words of an index, which the model file has.
struct KeyframeWords {
  // The means of n kinds, and of n words of each kind, as many as of the first.
  std::vector<features::SiftDescriptor> means;
  // Of each indexed feature, keyframe after keyframe.
  std::vector<uint16_t> word_of;
};

// Keyframe k has descriptors first[k] to first[k + 1]; the first of them, up to
// kIndexedFeatures, are indexed. Words are learnt from these by k-means in two
// levels. A function of the descriptors.
KeyframeWords LearnWords(const features::SiftDescriptorView& descriptors,
                         std::span<const size_t> first);

// Immutable, and thread-safe.
class KeyframeIndex {
 public:
  KeyframeIndex() = default;

  // Of descriptors and keyframes as in LearnWords. DATA_LOSS for words that are
  // not of so many features.
  static absl::StatusOr<KeyframeIndex> Create(
      KeyframeWords words, const features::SiftDescriptorView& descriptors,
      std::span<const size_t> first);

  // Up to `count` keyframes, those first that most of the queries vote for. A
  // query votes for keyframes with a feature of its word and a signature alike,
  // with more weight the more alike it is and the rarer the word.
  std::vector<size_t> MostSimilar(
      std::span<const features::SiftDescriptor> queries, size_t count) const;

  // The indexed features, numbered as in LearnWords, of each query's word and
  // with a signature like its own.
  std::vector<std::vector<uint32_t>> FeaturesLike(
      std::span<const features::SiftDescriptor> queries) const;

 private:
  struct Posting {
    uint64_t signature = 0;
    uint32_t keyframe = 0;
    uint32_t feature = 0;
  };
  // Calls visit(query, word, posting, differing bits) for each posting of each
  // query's word with a signature alike.
  template <typename Visit>
  void ForEachAlike(std::span<const features::SiftDescriptor> queries,
                    const Visit& visit) const;

  // Those of KeyframeWords.
  std::vector<features::SiftDescriptor> means_;
  // Postings of word w: first_posting_[w] to first_posting_[w + 1].
  std::vector<size_t> first_posting_;
  std::vector<Posting> postings_;
  std::vector<float> word_weight_;
  std::vector<float> keyframe_weight_;
};

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_KEYFRAME_INDEX_H_
