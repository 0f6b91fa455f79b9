#include "nav_agent/localization/particle_clusters.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <numeric>

#include "common/base/random.h"

namespace treeline {
namespace {

// Ground heights this far apart are of different floors.
constexpr double kHeightBin_m = 0.6;

// A bin's place as one number: 22 bits each of x and y, 7 of height, 13 of yaw.
struct BinPlace {
  int64_t x = 0;
  int64_t y = 0;
  int64_t height = 0;
  int64_t yaw = 0;

  uint64_t Key() const {
    const auto bits = [](int64_t value, int count) {
      return static_cast<uint64_t>(value + (int64_t{1} << (count - 1))) &
             ((uint64_t{1} << count) - 1);
    };
    return bits(x, 22) << 42 | bits(y, 22) << 20 | bits(height, 7) << 13 |
           static_cast<uint64_t>(yaw);
  }
  static BinPlace Of(uint64_t key) {
    const auto value = [key](int shift, int count) {
      return static_cast<int64_t>(key >> shift & ((uint64_t{1} << count) - 1)) -
             (int64_t{1} << (count - 1));
    };
    return {.x = value(42, 22),
            .y = value(20, 22),
            .height = value(13, 7),
            .yaw = static_cast<int64_t>(key & 0x1fff)};
  }
};

class Binning {
 public:
  Binning(double bin_m, double bin_rad)
      : bin_m_(bin_m),
        yaw_bins_(std::max<int64_t>(
            1, std::llround(2 * std::numbers::pi / bin_rad))) {}

  uint64_t KeyOf(const Particle& particle) const {
    const Rigid2& pose = particle.map_from_base;
    const double turns = pose.yaw_rad / (2 * std::numbers::pi) -
                         std::floor(pose.yaw_rad / (2 * std::numbers::pi));
    const int64_t yaw =
        static_cast<int64_t>(turns * static_cast<double>(yaw_bins_));
    return BinPlace{
        .x = static_cast<int64_t>(std::floor(pose.translation.x / bin_m_)),
        .y = static_cast<int64_t>(std::floor(pose.translation.y / bin_m_)),
        .height = static_cast<int64_t>(
            std::floor(particle.place.height_m / kHeightBin_m)),
        .yaw = std::min(yaw, yaw_bins_ - 1)}
        .Key();
  }
  int64_t yaw_bins() const { return yaw_bins_; }

 private:
  double bin_m_;
  int64_t yaw_bins_;
};

// Which set each of some numbers is in (Tarjan).
class DisjointSets {
 public:
  explicit DisjointSets(int count) : parents_(static_cast<size_t>(count)) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }
  int Find(int i) {
    while (parents_[static_cast<size_t>(i)] != i) {
      int& parent = parents_[static_cast<size_t>(i)];
      parent = parents_[static_cast<size_t>(parent)];
      i = parent;
    }
    return i;
  }
  // The smaller number names the set.
  void Join(int a, int b) {
    const int root_a = Find(a);
    const int root_b = Find(b);
    parents_[static_cast<size_t>(std::max(root_a, root_b))] =
        std::min(root_a, root_b);
  }

 private:
  std::vector<int> parents_;
};

// Numbers keys in the order in which they come: a hash table with open
// addresses, at most half full, as a wide cloud's bins are looked up half a
// million times.
class BinTable {
 public:
  explicit BinTable(size_t most)
      : slots_(std::bit_ceil(std::max<size_t>(2 * most, 16)), -1) {
    keys_.reserve(most);
  }
  // -1: it is not there.
  int Find(uint64_t key) const { return slots_[SlotOf(key)]; }
  int FindOrAdd(uint64_t key) {
    int& number = slots_[SlotOf(key)];
    if (number < 0) {
      number = static_cast<int>(keys_.size());
      keys_.push_back(key);
    }
    return number;
  }
  const std::vector<uint64_t>& keys() const { return keys_; }

 private:
  // Where it is, or belongs.
  size_t SlotOf(uint64_t key) const {
    const size_t mask = slots_.size() - 1;
    size_t slot = MixBits(key) & mask;
    while (slots_[slot] >= 0 &&
           keys_[static_cast<size_t>(slots_[slot])] != key) {
      slot = (slot + 1) & mask;
    }
    return slot;
  }

  std::vector<int> slots_;
  std::vector<uint64_t> keys_;
};

// Joins a bin with the half of its neighbours at one height that the others'
// turns leave out.
void JoinNeighborsAt(const BinTable& bins, int bin, const BinPlace& place,
                     int64_t yaw_bins, DisjointSets& sets) {
  for (int64_t dx = 0; dx <= 1; ++dx) {
    for (int64_t dy = dx == 0 ? 0 : -1; dy <= 1; ++dy) {
      for (int64_t turn = -1; turn <= 1; ++turn) {
        const BinPlace other = {
            .x = place.x + dx,
            .y = place.y + dy,
            .height = place.height,
            .yaw = (place.yaw + turn + yaw_bins) % yaw_bins};
        const int neighbor = bins.Find(other.Key());
        if (neighbor >= 0) sets.Join(bin, neighbor);
      }
    }
  }
}

// Where all are of one height there are no others to look for.
void JoinNeighbors(const BinTable& bins, int bin, int64_t yaw_bins,
                   bool is_flat, DisjointSets& sets) {
  BinPlace place = BinPlace::Of(bins.keys()[static_cast<size_t>(bin)]);
  JoinNeighborsAt(bins, bin, place, yaw_bins, sets);
  if (is_flat) return;
  place.height -= 1;
  JoinNeighborsAt(bins, bin, place, yaw_bins, sets);
  place.height += 2;
  JoinNeighborsAt(bins, bin, place, yaw_bins, sets);
}

}  // namespace

PoseBins BinParticles(const std::vector<Particle>& particles, double bin_m,
                      double bin_rad) {
  const Binning binning(bin_m, bin_rad);
  BinTable bins(particles.size());
  PoseBins result;
  result.bin_of_particle.reserve(particles.size());
  for (const Particle& particle : particles) {
    result.bin_of_particle.push_back(bins.FindOrAdd(binning.KeyOf(particle)));
  }
  result.count = static_cast<int>(bins.keys().size());
  DisjointSets sets(result.count);
  const bool is_flat = std::ranges::all_of(bins.keys(), [&bins](uint64_t key) {
    return BinPlace::Of(key).height == BinPlace::Of(bins.keys()[0]).height;
  });
  for (int bin = 0; bin < result.count; ++bin) {
    JoinNeighbors(bins, bin, binning.yaw_bins(), is_flat, sets);
  }
  result.cluster_of_bin.resize(bins.keys().size());
  for (int bin = 0; bin < result.count; ++bin) {
    // A set is named by its first bin, which has its number already.
    const int root = sets.Find(bin);
    result.cluster_of_bin[static_cast<size_t>(bin)] =
        root == bin ? result.clusters++
                    : result.cluster_of_bin[static_cast<size_t>(root)];
  }
  return result;
}

int CountBins(const std::vector<Particle>& particles, double bin_m,
              double bin_rad) {
  const Binning binning(bin_m, bin_rad);
  BinTable bins(particles.size());
  for (const Particle& particle : particles) {
    bins.FindOrAdd(binning.KeyOf(particle));
  }
  return static_cast<int>(bins.keys().size());
}

PlanarEstimate HeaviestCluster(const std::vector<Particle>& particles,
                               double bin_m, double bin_rad) {
  const PoseBins bins = BinParticles(particles, bin_m, bin_rad);
  std::vector<double> weights(static_cast<size_t>(bins.clusters));
  const auto cluster_of = [&bins](size_t i) {
    return bins.cluster_of_bin[static_cast<size_t>(bins.bin_of_particle[i])];
  };
  double total = 0;
  for (size_t i = 0; i < particles.size(); ++i) {
    weights[static_cast<size_t>(cluster_of(i))] += particles[i].weight;
    total += particles[i].weight;
  }
  const int heaviest = static_cast<int>(
      std::max_element(weights.begin(), weights.end()) - weights.begin());
  const double weight = weights[static_cast<size_t>(heaviest)];

  Vec2 position;
  Vec2 heading;
  double height_m = 0;
  for (size_t i = 0; i < particles.size(); ++i) {
    if (cluster_of(i) != heaviest) continue;
    const Particle& p = particles[i];
    const double yaw_rad = p.map_from_base.yaw_rad;
    position = position + (p.weight / weight) * p.map_from_base.translation;
    height_m += p.weight / weight * p.place.height_m;
    heading = heading +
              (p.weight / weight) * Vec2{std::cos(yaw_rad), std::sin(yaw_rad)};
  }
  PlanarEstimate estimate;
  estimate.map_from_base = {.translation = position,
                            .yaw_rad = std::atan2(heading.y, heading.x)};
  for (size_t i = 0; i < particles.size(); ++i) {
    if (cluster_of(i) != heaviest) continue;
    const Particle& p = particles[i];
    const std::array<double, 3> away = {
        p.map_from_base.translation.x - position.x,
        p.map_from_base.translation.y - position.y,
        NormalizedAngle_rad(p.map_from_base.yaw_rad -
                            estimate.map_from_base.yaw_rad)};
    for (size_t a = 0; a < 3; ++a) {
      for (size_t b = 0; b < 3; ++b) {
        estimate.covariance[3 * a + b] += p.weight / weight * away[a] * away[b];
      }
    }
  }
  estimate.place.height_m = height_m;
  estimate.share = weight / total;
  estimate.particles = static_cast<int>(particles.size());
  return estimate;
}

}  // namespace treeline
