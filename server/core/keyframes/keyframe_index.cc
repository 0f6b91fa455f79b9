#include "server/core/keyframes/keyframe_index.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "server/core/keyframes/least_first.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

using features::NearestSift;
using features::SiftDescriptor;

constexpr size_t kSize = SiftDescriptor::kDimensions;
constexpr int kSignatureBits = 64;
static_assert(kMaxKinds * kMaxKinds <= 65536, "a word fits into 16 bits");

features::SiftDescriptorView ViewOf(std::span<const SiftDescriptor> values) {
  return {.data = values.empty() ? nullptr : values[0].values.data(),
          .size = values.size()};
}

std::vector<NearestSift> NearestOf(std::span<const SiftDescriptor> queries,
                                   std::span<const SiftDescriptor> means) {
  std::vector<NearestSift> nearest(queries.size());
  features::FindNearestSift(queries, ViewOf(means), nearest);
  return nearest;
}

// k-means, from means that are spread over the samples. With fewer samples than
// means, some means are the same.
std::vector<SiftDescriptor> Means(std::span<const SiftDescriptor> samples,
                                  size_t count) {
  std::vector<SiftDescriptor> means(count);
  if (samples.empty()) return means;
  for (size_t m = 0; m < count; ++m) {
    means[m] = samples[m * samples.size() / count];
  }
  for (int round = 0; round < kWordRounds; ++round) {
    const std::vector<NearestSift> nearest = NearestOf(samples, means);
    std::vector<std::array<uint32_t, kSize>> sums(count);
    std::vector<uint32_t> members(count);
    for (size_t i = 0; i < samples.size(); ++i) {
      const size_t m = nearest[i].index;
      ++members[m];
      for (size_t d = 0; d < kSize; ++d) sums[m][d] += samples[i].values[d];
    }
    for (size_t m = 0; m < count; ++m) {
      if (members[m] == 0) continue;
      for (size_t d = 0; d < kSize; ++d) {
        means[m].values[d] =
            static_cast<uint8_t>((sums[m][d] + members[m] / 2) / members[m]);
      }
    }
  }
  return means;
}

// Calls visit(kind, members) for each kind that has some, with the indices of
// its members.
template <typename Visit>
void ForEachKind(std::span<const NearestSift> kind_of, size_t kinds,
                 const Visit& visit) {
  std::vector<std::vector<uint32_t>> members(kinds);
  for (uint32_t i = 0; i < kind_of.size(); ++i) {
    members[kind_of[i].index].push_back(i);
  }
  for (size_t k = 0; k < kinds; ++k) {
    if (!members[k].empty()) visit(k, members[k]);
  }
}

std::vector<SiftDescriptor> Pick(std::span<const SiftDescriptor> descriptors,
                                 std::span<const uint32_t> indices) {
  std::vector<SiftDescriptor> picked;
  picked.reserve(indices.size());
  for (const uint32_t i : indices) picked.push_back(descriptors[i]);
  return picked;
}

// n for n kinds of n words each; 0 if these are none.
size_t KindsAmong(size_t means) {
  for (size_t n = 1; n <= kMaxKinds; ++n) {
    if (n + n * n == means) return n;
  }
  return 0;
}

// Descriptors of a keyframe that are indexed.
size_t IndexedOf(std::span<const size_t> first, size_t keyframe) {
  return std::min<size_t>(kIndexedFeatures,
                          first[keyframe + 1] - first[keyframe]);
}

std::vector<SiftDescriptor> Indexed(
    const features::SiftDescriptorView& descriptors,
    std::span<const size_t> first) {
  std::vector<SiftDescriptor> indexed;
  for (size_t k = 0; k + 1 < first.size(); ++k) {
    for (size_t i = 0; i < IndexedOf(first, k); ++i) {
      indexed.emplace_back();
      std::memcpy(indexed.back().values.data(),
                  descriptors.data + (first[k] + i) * descriptors.stride_bytes,
                  kSize);
    }
  }
  return indexed;
}

std::vector<uint16_t> WordsOf(std::span<const SiftDescriptor> descriptors,
                              std::span<const SiftDescriptor> means) {
  const size_t kinds = KindsAmong(means.size());
  std::vector<uint16_t> words(descriptors.size());
  ForEachKind(NearestOf(descriptors, means.first(kinds)), kinds,
              [&](size_t kind, std::span<const uint32_t> members) {
                const std::vector<NearestSift> nearest =
                    NearestOf(Pick(descriptors, members),
                              means.subspan(kinds + kind * kinds, kinds));
                for (size_t i = 0; i < members.size(); ++i) {
                  words[members[i]] =
                      static_cast<uint16_t>(kind * kinds + nearest[i].index);
                }
              });
  return words;
}

// A bit says whether two neighbouring values are more than those of the mean.
uint64_t SignatureOf(const SiftDescriptor& descriptor,
                     const SiftDescriptor& mean) {
  uint64_t signature = 0;
  for (size_t bit = 0; bit < kSignatureBits; ++bit) {
    const int value =
        descriptor.values[2 * bit] + descriptor.values[2 * bit + 1];
    const int middle = mean.values[2 * bit] + mean.values[2 * bit + 1];
    signature |= static_cast<uint64_t>(value > middle) << bit;
  }
  return signature;
}

}  // namespace

KeyframeWords LearnWords(const features::SiftDescriptorView& descriptors,
                         std::span<const size_t> first) {
  KeyframeWords words;
  const std::vector<SiftDescriptor> indexed = Indexed(descriptors, first);
  if (indexed.empty()) return words;
  const size_t kinds = std::clamp<size_t>(
      static_cast<size_t>(
          std::sqrt(static_cast<double>(indexed.size()) / kFeaturesPerWord)),
      1, kMaxKinds);
  // Some are enough to learn from.
  const size_t step = indexed.size() / kWordSamples + 1;
  std::vector<SiftDescriptor> samples;
  for (size_t i = 0; i < indexed.size(); i += step) {
    samples.push_back(indexed[i]);
  }
  words.means = Means(samples, kinds);
  const std::vector<NearestSift> kind_of = NearestOf(samples, words.means);
  words.means.resize(kinds + kinds * kinds);
  ForEachKind(
      kind_of, kinds, [&](size_t kind, std::span<const uint32_t> members) {
        std::ranges::copy(Means(Pick(samples, members), kinds),
                          words.means.begin() + static_cast<std::ptrdiff_t>(
                                                    kinds + kind * kinds));
      });
  words.word_of = WordsOf(indexed, words.means);
  return words;
}

absl::StatusOr<KeyframeIndex> KeyframeIndex::Create(
    KeyframeWords words, const features::SiftDescriptorView& descriptors,
    std::span<const size_t> first) {
  const std::vector<SiftDescriptor> indexed = Indexed(descriptors, first);
  KeyframeIndex index;
  if (indexed.empty()) return index;
  const size_t kinds = KindsAmong(words.means.size());
  const size_t count = kinds * kinds;
  if (kinds == 0 || words.word_of.size() != indexed.size() ||
      std::ranges::any_of(words.word_of,
                          [&](uint16_t word) { return word >= count; })) {
    return absl::DataLossError("corrupt model: words of keyframe features");
  }
  index.means_ = std::move(words.means);
  index.first_posting_.resize(count + 1);
  for (const uint16_t word : words.word_of) ++index.first_posting_[word + 1U];
  for (size_t w = 0; w < count; ++w) {
    const size_t postings = index.first_posting_[w + 1];
    index.word_weight_.push_back(std::log1p(static_cast<float>(indexed.size()) /
                                            static_cast<float>(postings + 1)));
    index.first_posting_[w + 1] += index.first_posting_[w];
  }
  std::vector<size_t> end(index.first_posting_.begin(),
                          index.first_posting_.end() - 1);
  index.postings_.resize(indexed.size());
  size_t i = 0;
  for (size_t k = 0; k + 1 < first.size(); ++k) {
    const size_t features = IndexedOf(first, k);
    index.keyframe_weight_.push_back(
        1 / std::sqrt(static_cast<float>(std::max<size_t>(features, 1))));
    for (const size_t stop = i + features; i < stop; ++i) {
      const uint16_t word = words.word_of[i];
      index.postings_[end[word]++] = {
          SignatureOf(indexed[i], index.means_[kinds + word]),
          static_cast<uint32_t>(k),
          static_cast<uint32_t>(first[k] + IndexedOf(first, k) - (stop - i))};
    }
  }
  return index;
}

template <typename Visit>
void KeyframeIndex::ForEachAlike(std::span<const SiftDescriptor> queries,
                                 const Visit& visit) const {
  const size_t kinds = KindsAmong(means_.size());
  const std::vector<uint16_t> words = WordsOf(queries, means_);
  for (size_t q = 0; q < queries.size(); ++q) {
    const uint16_t word = words[q];
    const uint64_t signature = SignatureOf(queries[q], means_[kinds + word]);
    for (size_t p = first_posting_[word]; p < first_posting_[word + 1]; ++p) {
      const int bits = std::popcount(signature ^ postings_[p].signature);
      if (bits > kMaxDifferentBits) continue;
      visit(q, word, postings_[p], static_cast<size_t>(bits));
    }
  }
}

std::vector<std::vector<uint32_t>> KeyframeIndex::FeaturesLike(
    std::span<const SiftDescriptor> queries) const {
  std::vector<std::vector<uint32_t>> alike(queries.size());
  if (postings_.empty()) return alike;
  ForEachAlike(queries,
               [&](size_t query, uint16_t, const Posting& posting, size_t) {
                 alike[query].push_back(posting.feature);
               });
  return alike;
}

std::vector<size_t> KeyframeIndex::MostSimilar(
    std::span<const SiftDescriptor> queries, size_t count) const {
  if (postings_.empty()) return {};
  queries = queries.first(std::min<size_t>(queries.size(), kIndexQueries));
  // By the bits that differ.
  std::array<float, kSignatureBits + 1> likeness{};
  for (int bits = 0; bits <= kMaxDifferentBits; ++bits) {
    const float t = static_cast<float>(bits) / kDifferentBits;
    likeness[static_cast<size_t>(bits)] = std::exp(-t * t);
  }
  std::vector<float> votes(keyframe_weight_.size());
  ForEachAlike(queries,
               [&](size_t, uint16_t word, const Posting& posting, size_t bits) {
                 const float weight = word_weight_[word] * word_weight_[word];
                 votes[posting.keyframe] += weight * likeness[bits];
               });
  std::vector<std::pair<float, size_t>> order;  // least is most similar
  for (size_t k = 0; k < votes.size(); ++k) {
    if (votes[k] > 0) order.emplace_back(-votes[k] * keyframe_weight_[k], k);
  }
  return LeastFirst(std::move(order), count);
}

}  // namespace treeline::keyframes
