#include "nav_agent/localization/particle_clusters.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "common/base/disjoint_sets.h"
#include "common/base/random.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {
namespace {

// Where a bin is, whatever its heading, as one number: 22 bits each of x and y,
// 20 of height.
struct ColumnPlace {
  int64_t x = 0;
  int64_t y = 0;
  int64_t height = 0;

  uint64_t Key() const {
    const auto bits = [](int64_t value, int count) {
      return static_cast<uint64_t>(value + (int64_t{1} << (count - 1))) &
             ((uint64_t{1} << count) - 1);
    };
    return bits(x, 22) << 42 | bits(y, 22) << 20 | bits(height, 20);
  }
  static ColumnPlace Of(uint64_t key) {
    const auto value = [key](int shift, int count) {
      return static_cast<int64_t>(key >> shift & ((uint64_t{1} << count) - 1)) -
             (int64_t{1} << (count - 1));
    };
    return {.x = value(42, 22), .y = value(20, 22), .height = value(0, 20)};
  }
};

// Numbers keys in the order in which they come: a hash table with open
// addresses, at most half full.
class KeyTable {
 public:
  explicit KeyTable(size_t most)
      : slots_(std::bit_ceil(std::max<size_t>(2 * most, 16)), -1) {}
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
    size_t slot = base::MixBits(key) & mask;
    while (slots_[slot] >= 0 &&
           keys_[static_cast<size_t>(slots_[slot])] != key) {
      slot = (slot + 1) & mask;
    }
    return slot;
  }

  std::vector<int> slots_;
  std::vector<uint64_t> keys_;
};

// Numbers bins in the order in which poses occupy them. Columns of bins, one
// for each heading, are looked up; what is in one stands side by side. A wide
// cloud has thousands of columns, and tens of thousands of bins.
class BinTable {
 public:
  BinTable(double bin_m, double bin_rad, size_t max_columns)
      : bin_m_(bin_m),
        yaw_bins_(static_cast<size_t>(std::max<int64_t>(
            1, std::llround(2 * std::numbers::pi / bin_rad)))),
        columns_(max_columns) {}

  int FindOrAdd(const Particle& particle) {
    const geometry::Rigid2& pose = particle.map_from_base;
    const ColumnPlace place = {
        .x = static_cast<int64_t>(std::floor(pose.translation.x / bin_m_)),
        .y = static_cast<int64_t>(std::floor(pose.translation.y / bin_m_)),
        .height = static_cast<int64_t>(
            std::floor(particle.place.height_m / kFloorHeight_m))};
    const double turns = pose.yaw_rad / (2 * std::numbers::pi) -
                         std::floor(pose.yaw_rad / (2 * std::numbers::pi));
    const size_t yaw =
        std::min(static_cast<size_t>(turns * static_cast<double>(yaw_bins_)),
                 yaw_bins_ - 1);
    const auto column = static_cast<size_t>(columns_.FindOrAdd(place.Key()));
    if ((column + 1) * yaw_bins_ > bins_.size()) {
      bins_.resize((column + 1) * yaw_bins_, -1);
    }
    int& bin = bins_[column * yaw_bins_ + yaw];
    if (bin < 0) bin = count_++;
    return bin;
  }
  int count() const { return count_; }

  // Bins that are neighbours, in any of the four directions and diagonally, are
  // of one set.
  void JoinNeighbors(base::DisjointSets& sets) const {
    for (size_t column = 0; column < columns_.keys().size(); ++column) {
      const ColumnPlace place = ColumnPlace::Of(columns_.keys()[column]);
      // The half of them that the others' turns leave out.
      for (int64_t height = -1; height <= 1; ++height) {
        for (int64_t dx = 0; dx <= 1; ++dx) {
          for (int64_t dy = dx == 0 ? 0 : -1; dy <= 1; ++dy) {
            const int other =
                columns_.Find(ColumnPlace{.x = place.x + dx,
                                          .y = place.y + dy,
                                          .height = place.height + height}
                                  .Key());
            if (other >= 0) Join(column, static_cast<size_t>(other), sets);
          }
        }
      }
    }
  }

 private:
  // Bins of two columns whose headings are neighbours.
  void Join(size_t column, size_t other, base::DisjointSets& sets) const {
    const int* const bins = &bins_[column * yaw_bins_];
    const int* const others = &bins_[other * yaw_bins_];
    for (size_t yaw = 0; yaw < yaw_bins_; ++yaw) {
      if (bins[yaw] < 0) continue;
      for (const size_t near :
           {yaw, (yaw + 1) % yaw_bins_, (yaw + yaw_bins_ - 1) % yaw_bins_}) {
        if (others[near] < 0) continue;
        sets.Join(static_cast<uint32_t>(bins[yaw]),
                  static_cast<uint32_t>(others[near]));
      }
    }
  }

  double bin_m_;
  size_t yaw_bins_;
  KeyTable columns_;
  // Column by column, each with all headings; -1: it is empty.
  std::vector<int> bins_;
  int count_ = 0;
};

}  // namespace

PoseBins BinParticles(const std::vector<Particle>& particles, double bin_m,
                      double bin_rad) {
  BinTable bins(bin_m, bin_rad, particles.size());
  PoseBins result;
  result.bin_of_particle.reserve(particles.size());
  for (const Particle& particle : particles) {
    result.bin_of_particle.push_back(bins.FindOrAdd(particle));
  }
  result.count = bins.count();
  base::DisjointSets sets(static_cast<size_t>(result.count));
  bins.JoinNeighbors(sets);
  result.cluster_of_bin.resize(static_cast<size_t>(result.count));
  for (int bin = 0; bin < result.count; ++bin) {
    // A set is named by its first bin, which has its number already.
    const int root = static_cast<int>(sets.Find(static_cast<uint32_t>(bin)));
    result.cluster_of_bin[static_cast<size_t>(bin)] =
        root == bin ? result.clusters++
                    : result.cluster_of_bin[static_cast<size_t>(root)];
  }
  return result;
}

int CountBins(const std::vector<Particle>& particles, double bin_m,
              double bin_rad) {
  BinTable bins(bin_m, bin_rad, particles.size());
  for (const Particle& particle : particles) bins.FindOrAdd(particle);
  return bins.count();
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

  geometry::Vec2 position;
  geometry::Vec2 heading;
  double height_m = 0;
  for (size_t i = 0; i < particles.size(); ++i) {
    if (cluster_of(i) != heaviest) continue;
    const Particle& p = particles[i];
    const double yaw_rad = p.map_from_base.yaw_rad;
    position = position + (p.weight / weight) * p.map_from_base.translation;
    height_m += p.weight / weight * p.place.height_m;
    heading = heading + (p.weight / weight) * geometry::Vec2{std::cos(yaw_rad),
                                                             std::sin(yaw_rad)};
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
        geometry::NormalizedAngle_rad(p.map_from_base.yaw_rad -
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

}  // namespace treeline::localization
