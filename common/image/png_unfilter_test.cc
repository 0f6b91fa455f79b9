#include "common/image/png_unfilter.h"

#include <cstdlib>
#include <string>
#include <vector>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "common/image/testing_png_filters.h"
#include "gtest/gtest.h"

namespace treeline::image {
namespace {

std::vector<uint16_t> Undone(const std::vector<uint8_t>& rows, size_t width,
                             size_t height) {
  const size_t stride = FilteredRowBytes(width);
  std::vector<uint8_t> bytes = rows;
  const auto at = [&](size_t y, size_t i) -> uint8_t& {
    return bytes[y * stride + 1 + i];
  };
  std::vector<uint16_t> values;
  for (size_t y = 0; y < height; ++y) {
    for (size_t i = 0; i < 2 * width; ++i) {
      const int left = i < 2 ? 0 : at(y, i - 2);
      const int above = y == 0 ? 0 : at(y - 1, i);
      const int diagonal = i < 2 || y == 0 ? 0 : at(y - 1, i - 2);
      at(y, i) = static_cast<uint8_t>(
          at(y, i) + Predicted(rows[y * stride], left, above, diagonal));
    }
    for (size_t x = 0; x < width; ++x) {
      values.push_back(
          static_cast<uint16_t>(at(y, 2 * x) << 8 | at(y, 2 * x + 1)));
    }
  }
  return values;
}

// Bytes that are anything, or differ by little, so that predictions are
// nearly alike.
std::vector<uint8_t> SomeRows(size_t width, size_t height, uint32_t most,
                              int filter, base::Random& random) {
  std::vector<uint8_t> rows;
  for (size_t y = 0; y < height; ++y) {
    rows.push_back(static_cast<uint8_t>(
        filter < 0 ? static_cast<int>(random.NextBelow(5)) : filter));
    for (size_t i = 0; i < 2 * width; ++i) {
      rows.push_back(static_cast<uint8_t>(random.NextBelow(most)));
    }
  }
  return rows;
}

std::vector<uint16_t> Unfiltered(std::vector<uint8_t> rows, size_t width,
                                 size_t height) {
  // What follows must not matter.
  rows.resize(rows.size() + kUnfilterPadding_bytes, 0xa5);
  std::vector<uint16_t> values(width * height);
  EXPECT_TRUE(UnfilterGray16(rows, width, height, values));
  return values;
}

TEST(PngUnfilterTest, UndoesWhatTheStandardSays) {
  base::WithEachVectorTarget([] {
    base::Random random(1, 0);
    for (const size_t width :
         {1u, 2u, 7u, 15u, 16u, 17u, 23u, 24u, 31u, 40u, 63u}) {
      for (const size_t height : {1u, 2u, 15u, 16u, 17u, 32u, 33u, 49u}) {
        for (const uint32_t most : {256u, 4u}) {
          const std::vector<uint8_t> rows =
              SomeRows(width, height, most, -1, random);
          ASSERT_EQ(Unfiltered(rows, width, height),
                    Undone(rows, width, height))
              << width << " x " << height;
        }
      }
    }
  });
}

TEST(PngUnfilterTest, UndoesRowsOfOneFilter) {
  base::WithEachVectorTarget([] {
    base::Random random(2, 0);
    for (int filter = 0; filter < 5; ++filter) {
      const std::vector<uint8_t> rows = SomeRows(64, 48, 256, filter, random);
      ASSERT_EQ(Unfiltered(rows, 64, 48), Undone(rows, 64, 48)) << filter;
    }
  });
}

TEST(PngUnfilterTest, RefusesAFilterThatDoesNotExistWhereverItIs) {
  base::Random random(3, 0);
  for (const size_t broken : {0u, 5u, 16u, 34u}) {
    std::vector<uint8_t> rows = SomeRows(20, 35, 256, -1, random);
    rows[broken * FilteredRowBytes(20)] = 5;
    rows.resize(rows.size() + kUnfilterPadding_bytes);
    std::vector<uint16_t> values(20 * 35);
    EXPECT_FALSE(UnfilterGray16(rows, 20, 35, values)) << broken;
  }
}

}  // namespace
}  // namespace treeline::image
