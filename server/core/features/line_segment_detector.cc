#include "server/core/features/line_segment_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "server/core/features/gaussian_sampler.h"
#include "server/core/features/parameters.h"

namespace treeline::features {
namespace {

// As the paper has them. Pixels of an edge turn by at most so much from its
// direction; of those of a picture without edges, so many do.
constexpr float kMaxTurn_rad = 22.5F * std::numbers::pi_v<float> / 180;
constexpr double kTurnShare = 22.5 / 180;
// Brightness is in whole steps: a gradient may be wrong by this much.
constexpr float kQuantisation = 2;
// What is blurred before it is sampled, in pixels of the result.
constexpr double kBlur_px = 0.6;
// Pixels of an edge for each pixel of its rectangle.
constexpr double kMinDensity = 0.7;
// One step of taking a region's far end away.
constexpr double kShrink = 0.75;
constexpr size_t kStrengthBins = 1024;

// One place between four pixels, where brightness may jump.
struct Edge {
  // Along the edge, of length 1, with the brighter side to the right.
  float dx = 0;
  float dy = 0;
  // The gradient per pixel.
  float strength = 0;
};

struct Place {
  int16_t x = 0;
  int16_t y = 0;
};

double SquaredDistance(Place a, Place b) {
  const double x = a.x - b.x;
  const double y = a.y - b.y;
  return x * x + y * y;
}

// The gradients of the picture, `scale` times as large, with a border that has
// none. Place (x, y) lies at pixel (x - 0.5, y - 0.5) of the smaller picture.
class EdgeMap {
 public:
  EdgeMap(const GrayPyramid::Level& picture, double scale) {
    GaussianSampler sampler(picture.width, picture.height, scale, kBlur_px);
    width_ = sampler.width();
    height_ = sampler.height();
    stride_ = static_cast<size_t>(width_) + 1;
    edges_.resize(stride_ * (static_cast<size_t>(height_) + 1));
    is_free_.resize(edges_.size());
    std::vector<float> above(static_cast<size_t>(width_));
    std::vector<float> row(above.size());
    for (int y = 0; y < height_; ++y) {
      sampler.Sample(picture.gray.data(), y, row);
      if (y > 0) AddRow(above, row, y);
      std::swap(above, row);
    }
  }

  int width() const { return width_; }
  int height() const { return height_; }
  const Edge& at(Place p) const { return edges_[Index(p)]; }
  // Whether there is an edge, and no region has it.
  bool IsFree(Place p) const { return is_free_[Index(p)] != 0; }
  // Of the three from (x, y) on, which is quicker.
  bool IsAnyFree(int x, int y) const {
    const uint8_t* const first =
        is_free_.data() +
        Index({static_cast<int16_t>(x), static_cast<int16_t>(y)});
    return (first[0] | first[1] | first[2]) != 0;
  }
  void set_free(Place p, bool is_free) { is_free_[Index(p)] = is_free; }

  // All that have a gradient, the steepest first.
  std::vector<Place> BySteepness() const {
    const float per_strength =
        static_cast<float>(kStrengthBins - 1) / std::max(steepest_, 1e-6F);
    const auto bin = [&](const Edge& edge) {
      return kStrengthBins - 1 -
             static_cast<size_t>(edge.strength * per_strength);
    };
    std::array<size_t, kStrengthBins + 1> begin{};
    for (size_t i = 0; i < edges_.size(); ++i) {
      if (is_free_[i]) ++begin[bin(edges_[i]) + 1];
    }
    for (size_t b = 1; b < begin.size(); ++b) begin[b] += begin[b - 1];
    std::vector<Place> places(begin.back());
    for (int y = 1; y < height_; ++y) {
      for (int x = 1; x < width_; ++x) {
        const Place p{static_cast<int16_t>(x), static_cast<int16_t>(y)};
        if (IsFree(p)) places[begin[bin(at(p))]++] = p;
      }
    }
    return places;
  }

 private:
  size_t Index(Place p) const {
    return static_cast<size_t>(p.y) * stride_ + static_cast<size_t>(p.x);
  }

  // The places between two rows.
  void AddRow(std::span<const float> above, std::span<const float> below,
              int y) {
    const float least = kQuantisation / std::sin(kMaxTurn_rad);
    for (int x = 1; x < width_; ++x) {
      const size_t i = static_cast<size_t>(x);
      const float down = below[i] - above[i - 1];
      const float up = above[i] - below[i - 1];
      const float gx = 0.5F * (down + up);
      const float gy = 0.5F * (down - up);
      const float squared = gx * gx + gy * gy;
      if (squared <= least * least) continue;
      const float strength = std::sqrt(squared);
      steepest_ = std::max(steepest_, strength);
      const size_t at = static_cast<size_t>(y) * stride_ + i;
      edges_[at] = {
          .dx = gy / strength, .dy = -gx / strength, .strength = strength};
      is_free_[at] = 1;
    }
  }

  int width_ = 0;
  int height_ = 0;
  size_t stride_ = 0;
  float steepest_ = 0;
  std::vector<Edge> edges_;
  std::vector<uint8_t> is_free_;
};

// What a region's pixels lie in.
struct Rectangle {
  double length() const { return to - from; }
  // Of its middle line, and ends of it along the direction.
  double x = 0, y = 0;
  double dx = 1, dy = 0;
  double from = 0, to = 0;
  double width = 1;
};

class Detector {
 public:
  Detector(const GrayPyramid::Level& picture, double scale)
      : map_(picture, scale) {
    // Fewer pixels would be alike by chance somewhere.
    const double log_tests =
        2.5 * (std::log10(map_.width()) + std::log10(map_.height())) +
        std::log10(11.0);
    min_size_ = static_cast<size_t>(-log_tests / std::log10(kTurnShare));
  }

  std::vector<Rectangle> Run() {
    std::vector<Rectangle> found;
    for (const Place seed : map_.BySteepness()) {
      if (!map_.IsFree(seed)) continue;
      Grow(seed, kMaxTurn_rad);
      if (region_.size() < min_size_) continue;
      Fit();
      if (Refine()) found.push_back(rectangle_);
    }
    return found;
  }

 private:
  // Neighbours of neighbours whose edges go the region's way.
  void Grow(Place seed, float max_turn_rad) {
    const float least = std::cos(max_turn_rad);
    region_.assign(1, seed);
    map_.set_free(seed, false);
    float sum_x = map_.at(seed).dx;
    float sum_y = map_.at(seed).dy;
    float bound = least;
    for (size_t i = 0; i < region_.size(); ++i) {
      const Place p = region_[i];
      for (int y = p.y - 1; y <= p.y + 1; ++y) {
        if (!map_.IsAnyFree(p.x - 1, y)) continue;
        for (int x = p.x - 1; x <= p.x + 1; ++x) {
          const Place q{static_cast<int16_t>(x), static_cast<int16_t>(y)};
          if (!map_.IsFree(q)) continue;
          const Edge& edge = map_.at(q);
          if (edge.dx * sum_x + edge.dy * sum_y < bound) continue;
          map_.set_free(q, false);
          region_.push_back(q);
          sum_x += edge.dx;
          sum_y += edge.dy;
          bound = least * std::sqrt(sum_x * sum_x + sum_y * sum_y);
        }
      }
    }
    direction_x_ = sum_x;
    direction_y_ = sum_y;
  }

  void Release() {
    for (const Place p : region_) map_.set_free(p, true);
  }

  // The rectangle of the region's moments.
  void Fit() {
    const Place seed = region_[0];
    double weight = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    for (const Place p : region_) {
      const double w = static_cast<double>(map_.at(p).strength);
      const double from_x = p.x - seed.x;
      const double from_y = p.y - seed.y;
      weight += w;
      x += w * from_x;
      y += w * from_y;
      xx += w * from_x * from_x;
      yy += w * from_y * from_y;
      xy += w * from_x * from_y;
    }
    x /= weight;
    y /= weight;
    xx -= weight * x * x;
    yy -= weight * y * y;
    xy -= weight * x * y;
    x += seed.x;
    y += seed.y;
    // The axis about which the pixels lie closest.
    const double turn = 0.5 * std::atan2(2 * xy, xx - yy);
    double dx = std::cos(turn);
    double dy = std::sin(turn);
    if (dx * static_cast<double>(direction_x_) +
            dy * static_cast<double>(direction_y_) <
        0) {
      dx = -dx;
      dy = -dy;
    }
    rectangle_ = {.x = x, .y = y, .dx = dx, .dy = dy};
    double left = 0, right = 0;
    for (const Place p : region_) {
      const double along = (p.x - x) * dx + (p.y - y) * dy;
      const double beside = (p.y - y) * dx - (p.x - x) * dy;
      rectangle_.from = std::min(rectangle_.from, along);
      rectangle_.to = std::max(rectangle_.to, along);
      left = std::min(left, beside);
      right = std::max(right, beside);
    }
    rectangle_.width = std::max(1.0, right - left);
  }

  bool IsDense() const {
    return static_cast<double>(region_.size()) >=
           kMinDensity * rectangle_.length() * rectangle_.width;
  }

  // A region that is not dense is bent, or two: again with the turn that there
  // is around its seed, and then without its far end. False: nothing is left.
  bool Refine() {
    if (IsDense()) return true;
    const Place seed = region_[0];
    const float turn_rad = TurnAtSeed();
    Release();
    Grow(seed, turn_rad);
    if (region_.size() < 2) return false;
    Fit();
    return IsDense() || Shorten();
  }

  // Twice the standard deviation from the seed's direction, near it.
  float TurnAtSeed() const {
    const Place seed = region_[0];
    const Edge& middle = map_.at(seed);
    double n = 0, sum = 0, squares = 0;
    for (const Place p : region_) {
      if (SquaredDistance(p, seed) >= rectangle_.width * rectangle_.width) {
        continue;
      }
      const Edge& edge = map_.at(p);
      const double turn_rad = static_cast<double>(
          std::atan2(middle.dx * edge.dy - middle.dy * edge.dx,
                     middle.dx * edge.dx + middle.dy * edge.dy));
      n += 1;
      sum += turn_rad;
      squares += turn_rad * turn_rad;
    }
    const double mean = sum / n;
    return static_cast<float>(
        2 * std::sqrt(std::max(0.0, squares / n - mean * mean)));
  }

  bool Shorten() {
    const Place seed = region_[0];
    const auto squared_end = [&](double along) {
      const double x = rectangle_.x + along * rectangle_.dx - seed.x;
      const double y = rectangle_.y + along * rectangle_.dy - seed.y;
      return x * x + y * y;
    };
    double squared_radius =
        std::max(squared_end(rectangle_.from), squared_end(rectangle_.to));
    while (!IsDense()) {
      squared_radius *= kShrink * kShrink;
      std::erase_if(region_, [&](Place p) {
        if (SquaredDistance(p, seed) <= squared_radius) return false;
        map_.set_free(p, true);
        return true;
      });
      if (region_.size() < 2) return false;
      Fit();
    }
    return true;
  }

  EdgeMap map_;
  size_t min_size_ = 0;
  // The seed first.
  std::vector<Place> region_;
  float direction_x_ = 0;
  float direction_y_ = 0;
  Rectangle rectangle_;
};

}  // namespace

std::vector<LineSegment> FindLineSegments(const GrayPyramid::Level& picture) {
  std::vector<LineSegment> segments;
  constexpr int kMaxSide_px = std::numeric_limits<int16_t>::max();
  if (std::min(picture.width, picture.height) < kMinLsdSide_px ||
      std::max(picture.width, picture.height) > kMaxSide_px) {
    return segments;
  }
  // From places of the edge map to pixels.
  const auto pixel = [](double place) { return place / kLsdScale - 0.5; };
  for (const Rectangle& r : Detector(picture, kLsdScale).Run()) {
    segments.push_back(
        {{pixel(r.x + r.from * r.dx), pixel(r.y + r.from * r.dy)},
         {pixel(r.x + r.to * r.dx), pixel(r.y + r.to * r.dy)}});
  }
  return segments;
}

}  // namespace treeline::features
