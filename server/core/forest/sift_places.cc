#include "server/core/forest/sift_places.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace treeline::forest {
namespace {

constexpr size_t kBuckets = size_t{1} << 13;
constexpr size_t kAhead = 2;  // pairs whose descriptors are on their way
constexpr size_t kLineBytes = 64;

// The bits of `value`, two zeros between them.
uint64_t Spread(uint64_t value) {
  value = (value | value << 16) & 0x0000ff0000ffull;
  value = (value | value << 8) & 0x00f00f00f00full;
  value = (value | value << 4) & 0x0c30c30c30c3ull;
  return (value | value << 2) & 0x249249249249ull;
}

// Morton's order: what has neighbouring numbers lies near each other.
uint64_t PlaceCode(const LeafPayload& payload) {
  return Spread(payload.mean[0]) | Spread(payload.mean[1]) << 1 |
         Spread(payload.mean[2]) << 2;
}

}  // namespace

SiftPlaces::SiftPlaces(const ForestView& forest) : forest_(forest) {
  std::vector<std::pair<uint64_t, uint32_t>> order(forest.payloads.size());
  for (uint32_t m = 0; m < order.size(); ++m) {
    order[m] = {PlaceCode(forest.payloads[m]), m};
  }
  std::ranges::sort(order);
  for (size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || order[i].first != order[i - 1].first) {
      first_mode_.push_back(static_cast<uint32_t>(i));
      position_in_world_.push_back(forest.LeafMean(order[i].second));
    }
    modes_.push_back(order[i].second);
  }
  first_mode_.push_back(static_cast<uint32_t>(order.size()));
  for (size_t begin = 0; begin < size(); begin += kBlock) {
    const size_t end = std::min(begin + kBlock, size());
    Block block;
    for (size_t p = begin; p < end; ++p) {
      block.center_in_world =
          block.center_in_world +
          position_in_world_[p] / static_cast<double>(end - begin);
    }
    for (size_t p = begin; p < end; ++p) {
      block.radius = std::max(
          block.radius,
          geometry::Norm(position_in_world_[p] - block.center_in_world));
    }
    blocks_.push_back(block);
  }
}

// One frame's features, by where they are.
class SiftPlaces::Query {
 public:
  Query(std::span<const camera::Pixel> rays, std::span<const uint32_t> which,
        double radius)
      : rays_(rays), radius_(radius), first_(kBuckets + 1) {
    // A feature is in each cell that its window meets, so that a place need be
    // looked for in one.
    std::vector<std::pair<size_t, uint32_t>> entries;
    for (const uint32_t i : which) {
      const camera::Pixel& ray = rays[i];
      low_ = {std::min(low_.x, ray.x - radius),
              std::min(low_.y, ray.y - radius)};
      high_ = {std::max(high_.x, ray.x + radius),
               std::max(high_.y, ray.y + radius)};
      const int64_t left = Cell(ray.x - radius);
      const int64_t right = Cell(ray.x + radius);
      const int64_t top = Cell(ray.y - radius);
      const int64_t bottom = Cell(ray.y + radius);
      for (int64_t y = top; y <= bottom; ++y) {
        for (int64_t x = left; x <= right; ++x) {
          entries.emplace_back(Bucket(x, y), i);
        }
      }
    }
    for (const auto& entry : entries) ++first_[entry.first + 1];
    for (size_t b = 0; b < kBuckets; ++b) first_[b + 1] += first_[b];
    members_.resize(entries.size());
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    for (const auto& [bucket, i] : entries) members_[next[bucket]++] = i;
  }

  // Whether a place in the block may be in a window.
  bool MayShow(const geometry::Vec3& center_in_camera, double radius) const {
    const auto inside = [&](double along, double bound) {
      // Towards z, of the plane through the camera and the bound.
      return along - bound * center_in_camera.z >=
             -radius * std::sqrt(1 + bound * bound);
    };
    return center_in_camera.z > -radius && inside(center_in_camera.x, low_.x) &&
           inside(-center_in_camera.x, -high_.x) &&
           inside(center_in_camera.y, low_.y) &&
           inside(-center_in_camera.y, -high_.y);
  }

  // Calls see(feature) for each whose window a point is in.
  template <typename See>
  void ForEachAt(const geometry::Vec3& point_in_camera, const See& see) const {
    if (!(point_in_camera.z > 0)) return;
    const double x = point_in_camera.x / point_in_camera.z;
    const double y = point_in_camera.y / point_in_camera.z;
    if (!(x > low_.x && x < high_.x && y > low_.y && y < high_.y)) return;
    const size_t bucket = Bucket(Cell(x), Cell(y));
    for (size_t k = first_[bucket]; k < first_[bucket + 1]; ++k) {
      const camera::Pixel& ray = rays_[members_[k]];
      const double dx = ray.x - x;
      const double dy = ray.y - y;
      if (dx * dx + dy * dy <= radius_ * radius_) see(members_[k]);
    }
  }

 private:
  int64_t Cell(double value) const {
    return static_cast<int64_t>(std::floor(value / (2 * radius_)));
  }
  static size_t Bucket(int64_t x, int64_t y) {
    // Neighbours of a row are neighbours here; rows are far apart.
    return static_cast<size_t>(x + 97 * y) % kBuckets;
  }

  const std::span<const camera::Pixel> rays_;
  const double radius_;
  camera::Pixel low_{1e9, 1e9};
  camera::Pixel high_{-1e9, -1e9};
  std::vector<uint32_t> first_;
  std::vector<uint32_t> members_;
};

void SiftPlaces::Match(const geometry::Rigid3& camera_from_world,
                       std::span<const camera::Pixel> rays,
                       std::span<const features::SiftDescriptor> descriptors,
                       std::span<const uint32_t> which,
                       const SiftWindow& window,
                       std::span<SiftMatch> matches) const {
  const Query query(rays, which, window.radius);
  struct Pair {
    uint32_t feature;
    uint32_t place;
  };
  std::vector<Pair> pairs;
  for (size_t b = 0; b < blocks_.size(); ++b) {
    if (!query.MayShow(camera_from_world * blocks_[b].center_in_world,
                       blocks_[b].radius)) {
      continue;
    }
    const size_t end = std::min((b + 1) * kBlock, size());
    for (size_t p = b * kBlock; p < end; ++p) {
      query.ForEachAt(camera_from_world * position_in_world_[p],
                      [&](uint32_t feature) {
                        pairs.push_back({feature, static_cast<uint32_t>(p)});
                      });
    }
  }
  for (const uint32_t i : which) {
    matches[i] = {.distance = window.max_squared_distance + 1,
                  .distance_elsewhere = SiftMatch::kNothingElsewhere};
  }
  for (size_t k = 0; k < pairs.size(); ++k) {
    if (k + kAhead < pairs.size()) Prefetch(pairs[k + kAhead].place);
    SiftMatch& match = matches[pairs[k].feature];
    for (const uint32_t mode : modes(pairs[k].place)) {
      const int32_t distance = SquaredDistance(descriptors[pairs[k].feature],
                                               forest_.sift_descriptors[mode]);
      if (distance < match.distance ||
          (distance == match.distance && mode < match.mode)) {
        match.mode = mode;
        match.distance = distance;
      }
    }
  }
}

void SiftPlaces::Prefetch(size_t place) const {
  for (const uint32_t mode : modes(place)) {
    const char* at =
        reinterpret_cast<const char*>(&forest_.sift_descriptors[mode]);
    for (size_t b = 0; b < sizeof(features::SiftDescriptor); b += kLineBytes) {
      __builtin_prefetch(at + b);
    }
  }
}

}  // namespace treeline::forest
