#include "server/core/keyframes/keyframe_index.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

using features::NearestSift;
using features::SiftDescriptor;

constexpr size_t kSize = SiftDescriptor::kDimensions;
constexpr int kSignatureBits = 64;

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

}  // namespace

KeyframeIndex::KeyframeIndex(const features::SiftDescriptorView& descriptors,
                             std::span<const size_t> first) {
  std::vector<SiftDescriptor> indexed;
  std::vector<uint32_t> keyframe_of;
  for (size_t k = 0; k + 1 < first.size(); ++k) {
    const size_t count =
        std::min<size_t>(kIndexedFeatures, first[k + 1] - first[k]);
    for (size_t i = 0; i < count; ++i) {
      indexed.emplace_back();
      std::memcpy(indexed.back().values.data(),
                  descriptors.data + (first[k] + i) * descriptors.stride_bytes,
                  kSize);
      keyframe_of.push_back(static_cast<uint32_t>(k));
    }
    keyframe_weight_.push_back(
        1 / std::sqrt(static_cast<float>(std::max<size_t>(count, 1))));
  }
  if (indexed.empty()) return;
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
  kinds_ = Means(samples, kinds);
  words_.resize(kinds * kinds);
  ForEachKind(NearestOf(samples, kinds_), kinds,
              [&](size_t kind, std::span<const uint32_t> members) {
                std::ranges::copy(
                    Means(Pick(samples, members), kinds),
                    words_.begin() + static_cast<std::ptrdiff_t>(kind * kinds));
              });
  const std::vector<uint32_t> words = WordsOf(indexed);
  first_posting_.resize(words_.size() + 1);
  for (const uint32_t word : words) ++first_posting_[word + 1];
  for (size_t w = 0; w < words_.size(); ++w) {
    const size_t postings = first_posting_[w + 1];
    word_weight_.push_back(std::log1p(static_cast<float>(indexed.size()) /
                                      static_cast<float>(postings + 1)));
    first_posting_[w + 1] += first_posting_[w];
  }
  std::vector<size_t> end(first_posting_.begin(), first_posting_.end() - 1);
  postings_.resize(indexed.size());
  for (size_t i = 0; i < indexed.size(); ++i) {
    postings_[end[words[i]]++] = {SignatureOf(indexed[i], words[i]),
                                  keyframe_of[i]};
  }
}

std::vector<uint32_t> KeyframeIndex::WordsOf(
    std::span<const SiftDescriptor> descriptors) const {
  std::vector<uint32_t> words(descriptors.size());
  const size_t kinds = kinds_.size();
  ForEachKind(NearestOf(descriptors, kinds_), kinds,
              [&](size_t kind, std::span<const uint32_t> members) {
                const std::vector<NearestSift> nearest =
                    NearestOf(Pick(descriptors, members),
                              std::span(words_).subspan(kind * kinds, kinds));
                for (size_t i = 0; i < members.size(); ++i) {
                  words[members[i]] =
                      static_cast<uint32_t>(kind * kinds) + nearest[i].index;
                }
              });
  return words;
}

// A bit says whether two neighbouring values are more than those of the word.
uint64_t KeyframeIndex::SignatureOf(const SiftDescriptor& descriptor,
                                    uint32_t word) const {
  const std::array<uint8_t, kSize>& values = descriptor.values;
  const std::array<uint8_t, kSize>& means = words_[word].values;
  uint64_t signature = 0;
  for (size_t bit = 0; bit < kSignatureBits; ++bit) {
    const int value = values[2 * bit] + values[2 * bit + 1];
    const int mean = means[2 * bit] + means[2 * bit + 1];
    signature |= static_cast<uint64_t>(value > mean) << bit;
  }
  return signature;
}

std::vector<size_t> KeyframeIndex::MostSimilar(
    std::span<const SiftDescriptor> queries, size_t count) const {
  if (words_.empty()) return {};
  queries = queries.first(std::min<size_t>(queries.size(), kIndexQueries));
  // By the bits that differ.
  std::array<float, kSignatureBits + 1> likeness{};
  for (int bits = 0; bits <= kMaxDifferentBits; ++bits) {
    const float t = static_cast<float>(bits) / kDifferentBits;
    likeness[static_cast<size_t>(bits)] = std::exp(-t * t);
  }
  const std::vector<uint32_t> words = WordsOf(queries);
  std::vector<float> votes(keyframe_weight_.size());
  for (size_t q = 0; q < queries.size(); ++q) {
    const uint32_t word = words[q];
    const uint64_t signature = SignatureOf(queries[q], word);
    const float weight = word_weight_[word] * word_weight_[word];
    for (size_t p = first_posting_[word]; p < first_posting_[word + 1]; ++p) {
      const Posting& posting = postings_[p];
      const int bits = std::popcount(signature ^ posting.signature);
      if (bits > kMaxDifferentBits) continue;
      votes[posting.keyframe] += weight * likeness[static_cast<size_t>(bits)];
    }
  }
  std::vector<std::pair<float, size_t>> order;  // least is most similar
  for (size_t k = 0; k < votes.size(); ++k) {
    if (votes[k] > 0) order.emplace_back(-votes[k] * keyframe_weight_[k], k);
  }
  const size_t kept = std::min(count, order.size());
  std::partial_sort(order.begin(),
                    order.begin() + static_cast<std::ptrdiff_t>(kept),
                    order.end());
  std::vector<size_t> result;
  for (size_t i = 0; i < kept; ++i) result.push_back(order[i].second);
  return result;
}

}  // namespace treeline::keyframes
