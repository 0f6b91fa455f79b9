#include "server/core/recognition/appearance_words.h"

#include <algorithm>
#include <cmath>

#include "common/base/random.h"

namespace treeline::recognition {
namespace {

constexpr uint64_t kSeed = 0x776f726473u;
// Ferns look this far from their corner (px of the level).
constexpr int kRadius_px = 2;
// Thresholds of the comparisons are at most this, in logarithmic intensity.
constexpr int kMaxThreshold = 10;
// Weaker corners (squared differences of intensity) are noise.
constexpr int64_t kMinStrength = 20;

}  // namespace

AppearanceWords::AppearanceWords() {
  base::Random random(kSeed, kVocabulary);
  const auto offset = [&] {
    return static_cast<int>(random.NextBelow(2 * kRadius_px + 1)) - kRadius_px;
  };
  const auto channel = [&] { return static_cast<int>(random.NextBelow(3)); };
  for (Test& test : tests_) {
    test.dx1 = offset();
    test.dy1 = offset();
    test.channel1 = channel();
    test.dx2 = offset();
    test.dy2 = offset();
    test.channel2 = channel();
    test.threshold = static_cast<int>(random.NextBelow(2 * kMaxThreshold + 1)) -
                     kMaxThreshold;
  }
  for (size_t i = 0; i < logarithm_.size(); ++i) {
    const double value =
        std::log((static_cast<double>(i) + 8) / 8) / std::log((255.0 + 8) / 8);
    logarithm_[i] = static_cast<uint8_t>(std::lround(255 * value));
  }
}

const std::vector<uint32_t>& AppearanceWords::Extract(
    const image::ColorImage& image) {
  words_.clear();
  if (image.width < 1 || image.height < 1) return words_;
  Shrink(image);
  for (size_t l = 1; l < levels_.size(); ++l) Halve(levels_[l - 1], levels_[l]);
  for (const Level& level : levels_) {
    FindCorners(level);
    AddWords(level);
  }
  return words_;
}

// Each pixel is the mean of those of the image that it covers.
void AppearanceWords::Shrink(const image::ColorImage& image) {
  const int longest = std::max(image.width, image.height);
  Level& level = levels_[0];
  const auto scaled = [&](int side) {
    // Small images stay as they are.
    if (longest <= kLongSide_px) return side;
    return std::max(1, (2 * side * kLongSide_px + longest) / (2 * longest));
  };
  level.width = scaled(image.width);
  level.height = scaled(image.height);
  const int pixels = level.width * level.height;
  level.planes.resize(3 * static_cast<size_t>(pixels));
  const size_t row_bytes = 3 * static_cast<size_t>(image.width);
  column_sums_.resize(row_bytes);
  for (int y = 0; y < level.height; ++y) {
    const int top = y * image.height / level.height;
    const int bottom = (y + 1) * image.height / level.height;
    std::ranges::fill(column_sums_, 0u);
    for (int v = top; v < bottom; ++v) {
      const uint8_t* row =
          image.rgb.data() + static_cast<size_t>(v) * row_bytes;
      for (size_t i = 0; i < row_bytes; ++i) column_sums_[i] += row[i];
    }
    for (int x = 0; x < level.width; ++x) {
      const int left = x * image.width / level.width;
      const int right = (x + 1) * image.width / level.width;
      uint32_t sums[3] = {0, 0, 0};
      for (int u = left; u < right; ++u) {
        const uint32_t* sum = column_sums_.data() + 3 * u;
        for (int c = 0; c < 3; ++c) sums[c] += sum[c];
      }
      const auto covered =
          static_cast<uint32_t>((right - left) * (bottom - top));
      for (int c = 0; c < 3; ++c) {
        level.planes[static_cast<size_t>(c * pixels + y * level.width + x)] =
            logarithm_[sums[c] / covered];
      }
    }
  }
}

void AppearanceWords::Halve(const Level& from, Level& to) {
  to.width = from.width / 2;
  to.height = from.height / 2;
  to.planes.resize(3 * static_cast<size_t>(to.width) *
                   static_cast<size_t>(to.height));
  uint8_t* out = to.planes.data();
  for (int c = 0; c < 3; ++c) {
    const uint8_t* plane = from.planes.data() + c * from.width * from.height;
    for (int y = 0; y < to.height; ++y) {
      const uint8_t* top = plane + 2 * y * from.width;
      const uint8_t* bottom = top + from.width;
      for (int x = 0; x < to.width; ++x) {
        *out++ = static_cast<uint8_t>((top[2 * x] + top[2 * x + 1] +
                                       bottom[2 * x] + bottom[2 * x + 1] + 2) /
                                      4);
      }
    }
  }
}

// With the structure tensor (a b; b c) of the brightness around a pixel, its
// strength is 4 det / trace, the harmonic mean of its eigenvalues times two.
void AppearanceWords::FindCorners(const Level& level) {
  corners_.clear();
  const int w = level.width;
  const int h = level.height;
  if (w <= 2 * kRadius_px || h <= 2 * kRadius_px) return;
  const int pixels = w * h;
  const uint8_t* red = level.planes.data();
  const uint8_t* green = red + pixels;
  const uint8_t* blue = green + pixels;
  const auto gray = [&](int i) { return red[i] + 2 * green[i] + blue[i]; };
  gradients_.assign(3 * static_cast<size_t>(pixels), 0);
  int32_t* xx = gradients_.data();
  int32_t* xy = xx + pixels;
  int32_t* yy = xy + pixels;
  for (int y = 1; y + 1 < h; ++y) {
    for (int i = y * w + 1; i < y * w + w - 1; ++i) {
      const int dx = gray(i + 1) - gray(i - 1);
      const int dy = gray(i + w) - gray(i - w);
      xx[i] = dx * dx;
      xy[i] = dx * dy;
      yy[i] = dy * dy;
    }
  }
  // Weights 1 2 1, 2 2 2, 1 2 1; gray is four times the intensity.
  const auto around = [&](const int32_t* p) -> int64_t {
    return int64_t{p[-w - 1]} + p[-w + 1] + p[w - 1] + p[w + 1] +
           2 * (int64_t{p[-w]} + p[-1] + p[0] + p[1] + p[w]);
  };
  strengths_.assign(static_cast<size_t>(pixels), 0);
  int64_t* strengths = strengths_.data();
  for (int y = 2; y + 2 < h; ++y) {
    for (int i = y * w + 2; i < y * w + w - 2; ++i) {
      const int64_t a = around(xx + i);
      const int64_t b = around(xy + i);
      const int64_t c = around(yy + i);
      strengths[i] = 4 * (a * c - b * b) / (a + c + 1) / 64;
    }
  }
  for (int y = kRadius_px; y + kRadius_px < h; ++y) {
    for (int i = y * w + kRadius_px; i < y * w + w - kRadius_px; ++i) {
      const int64_t s = strengths[i];
      if (s < kMinStrength) continue;
      // Of equals that touch, the first is the corner.
      if (s > strengths[i - w - 1] && s > strengths[i - w] &&
          s > strengths[i - w + 1] && s > strengths[i - 1] &&
          s >= strengths[i + 1] && s >= strengths[i + w - 1] &&
          s >= strengths[i + w] && s >= strengths[i + w + 1]) {
        corners_.push_back({s, i});
      }
    }
  }
  const size_t kept =
      std::min(corners_.size(), static_cast<size_t>(kCornersPerLevel));
  std::partial_sort(corners_.begin(),
                    corners_.begin() + static_cast<std::ptrdiff_t>(kept),
                    corners_.end(), [](const Corner& a, const Corner& b) {
                      if (a.strength != b.strength) {
                        return a.strength > b.strength;
                      }
                      return a.index < b.index;
                    });
  corners_.resize(kept);
}

void AppearanceWords::AddWords(const Level& level) {
  const int pixels = level.width * level.height;
  // The comparisons as offsets in this level's planes.
  std::array<std::array<int, 3>, size_t{kFerns} * kFernTests> offsets;
  for (size_t t = 0; t < tests_.size(); ++t) {
    const Test& test = tests_[t];
    offsets[t] = {test.channel1 * pixels + test.dy1 * level.width + test.dx1,
                  test.channel2 * pixels + test.dy2 * level.width + test.dx2,
                  test.threshold};
  }
  for (const Corner& corner : corners_) {
    const uint8_t* at = level.planes.data() + corner.index;
    const std::array<int, 3>* test = offsets.data();
    for (uint32_t fern = 0; fern < kFerns; ++fern) {
      uint32_t code = 0;
      for (int t = 0; t < kFernTests; ++t, ++test) {
        const auto& [first, second, threshold] = *test;
        code = 2 * code + (at[first] - at[second] > threshold ? 1u : 0u);
      }
      const auto hashed =
          static_cast<uint32_t>(base::MixBits(code) >> (64 - kWordBits));
      words_.push_back(fern * kWordsPerFern + hashed);
    }
  }
}

}  // namespace treeline::recognition
