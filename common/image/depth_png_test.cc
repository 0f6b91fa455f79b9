#include "common/image/depth_png.h"

#include <libdeflate.h>

#include <algorithm>
#include <string>

#include "common/image/decode.h"
#include "common/image/testing_png_filters.h"
#include "gtest/gtest.h"

namespace treeline::image {
namespace {

constexpr int kWidth = 7;
constexpr int kHeight = 12;
constexpr int64_t kMaxPixels = 1000;

std::string BigEndian(uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<char>(value >> shift));
  }
  return bytes;
}

std::string Chunk(const std::string& type, const std::string& content) {
  const std::string checked = type + content;
  return BigEndian(static_cast<uint32_t>(content.size())) + checked +
         BigEndian(libdeflate_crc32(0, checked.data(), checked.size()));
}

std::string Header(uint32_t width, uint32_t height,
                   const std::string& rest = std::string("\x10\0\0\0\0", 5)) {
  return Chunk("IHDR", BigEndian(width) + BigEndian(height) + rest);
}

std::string Deflated(const std::string& bytes) {
  libdeflate_compressor* compressor = libdeflate_alloc_compressor(6);
  std::string out(libdeflate_zlib_compress_bound(compressor, bytes.size()),
                  '\0');
  out.resize(libdeflate_zlib_compress(compressor, bytes.data(), bytes.size(),
                                      out.data(), out.size()));
  libdeflate_free_compressor(compressor);
  return out;
}

const std::string kSignature("\x89PNG\r\n\x1a\n", 8);

std::vector<uint16_t> SomeValues() {
  std::vector<uint16_t> values;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    values.push_back(static_cast<uint16_t>(i * 40503 + (i % 3) * 77));
  }
  return values;
}

// Rows with the filters 0 to 4 by turns, each row of `shift` further.
std::string FilteredRows(const std::vector<uint16_t>& values, int shift) {
  std::vector<std::string> raw;
  for (int y = 0; y < kHeight; ++y) {
    std::string row;
    for (int x = 0; x < kWidth; ++x) {
      const uint16_t value = values[static_cast<size_t>(y * kWidth + x)];
      row.push_back(static_cast<char>(value >> 8));
      row.push_back(static_cast<char>(value));
    }
    raw.push_back(row);
  }
  const auto byte_at = [&](int y, int i) {
    return y < 0 || i < 0
               ? 0
               : static_cast<int>(static_cast<uint8_t>(
                     raw[static_cast<size_t>(y)][static_cast<size_t>(i)]));
  };
  std::string filtered;
  for (int y = 0; y < kHeight; ++y) {
    const int filter = (y + shift) % 5;
    filtered.push_back(static_cast<char>(filter));
    for (int i = 0; i < 2 * kWidth; ++i) {
      filtered.push_back(static_cast<char>(
          byte_at(y, i) - Predicted(filter, byte_at(y, i - 2),
                                    byte_at(y - 1, i), byte_at(y - 1, i - 2))));
    }
  }
  return filtered;
}

std::string PlainPng(int shift = 0) {
  return kSignature + Header(kWidth, kHeight) +
         Chunk("IDAT", Deflated(FilteredRows(SomeValues(), shift))) +
         Chunk("IEND", "");
}

TEST(DepthPngTest, UndoesEveryFilterInEveryRow) {
  for (int shift = 0; shift < 5; ++shift) {
    const auto image = DecodePlainDepthPng(PlainPng(shift), kMaxPixels);
    ASSERT_TRUE(image.has_value()) << shift;
    EXPECT_EQ(image->width, kWidth);
    EXPECT_EQ(image->height, kHeight);
    EXPECT_EQ(image->values, SomeValues()) << shift;
  }
}

TEST(DepthPngTest, PixelsMayStandInManyChunksAndTextBesideThem) {
  const std::string pixels = Deflated(FilteredRows(SomeValues(), 0));
  const std::string png =
      kSignature + Header(kWidth, kHeight) + Chunk("tEXt", "Comment") +
      Chunk("IDAT", pixels.substr(0, 5)) + Chunk("IDAT", "") +
      Chunk("IDAT", pixels.substr(5, 40)) + Chunk("IDAT", pixels.substr(45)) +
      Chunk("tIME", "1234567") + Chunk("IEND", "");
  const auto image = DecodePlainDepthPng(png, kMaxPixels);
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(image->values, SomeValues());
}

TEST(DepthPngTest, LeavesWhatIsUnusualToOthers) {
  const auto with_header = [](const std::string& rest) {
    return kSignature + Header(kWidth, kHeight, rest) +
           Chunk("IDAT", Deflated(FilteredRows(SomeValues(), 0))) +
           Chunk("IEND", "");
  };
  const std::string variants[] = {
      with_header(std::string("\x08\0\0\0\0", 5)),    // 8 bits
      with_header(std::string("\x10\x02\0\0\0", 5)),  // colour
      with_header(std::string("\x10\0\0\0\x01", 5)),  // interlaced
      with_header(std::string("\x10\0\x01\0\0", 5)),  // no such method
  };
  for (const std::string& png : variants) {
    EXPECT_FALSE(DecodePlainDepthPng(png, kMaxPixels).has_value());
  }
  EXPECT_FALSE(
      DecodePlainDepthPng(PlainPng(), kWidth * kHeight - 1).has_value());
  EXPECT_TRUE(DecodePlainDepthPng(PlainPng(), kWidth * kHeight).has_value());
}

TEST(DepthPngTest, RefusesEveryTruncationAndEveryFlippedBit) {
  const std::string png = PlainPng();
  for (size_t size = 0; size < png.size(); ++size) {
    EXPECT_FALSE(
        DecodePlainDepthPng(png.substr(0, size), kMaxPixels).has_value());
  }
  for (size_t i = 0; i < png.size(); ++i) {
    std::string broken = png;
    broken[i] = static_cast<char>(broken[i] ^ 4);
    EXPECT_FALSE(DecodePlainDepthPng(broken, kMaxPixels).has_value()) << i;
  }
}

TEST(DepthPngTest, RefusesPixelsThatDoNotFitTheHeader) {
  const auto png = [](uint32_t width, uint32_t height,
                      const std::string& rows) {
    return kSignature + Header(width, height) + Chunk("IDAT", Deflated(rows)) +
           Chunk("IEND", "");
  };
  const std::string rows = FilteredRows(SomeValues(), 0);
  EXPECT_TRUE(DecodePlainDepthPng(png(kWidth, kHeight, rows), kMaxPixels));
  EXPECT_FALSE(DecodePlainDepthPng(png(kWidth, kHeight + 1, rows), kMaxPixels));
  EXPECT_FALSE(DecodePlainDepthPng(png(kWidth, kHeight - 1, rows), kMaxPixels));
  std::string unknown_filter = rows;
  unknown_filter[0] = 5;
  EXPECT_FALSE(
      DecodePlainDepthPng(png(kWidth, kHeight, unknown_filter), kMaxPixels));
  // More than deflate can pack is refused before memory is asked for.
  EXPECT_FALSE(DecodePlainDepthPng(png(60000, 60000, rows), int64_t{1} << 40));
  EXPECT_FALSE(DecodePlainDepthPng(png(0, kHeight, ""), kMaxPixels));
}

TEST(DepthPngTest, WhatItWritesItReads) {
  const std::string png = EncodePlainDepthPng(kWidth, kHeight, SomeValues());
  const auto image = DecodePlainDepthPng(png, kMaxPixels);
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(image->width, kWidth);
  EXPECT_EQ(image->height, kHeight);
  EXPECT_EQ(image->values, SomeValues());
  // And so does libspng, which knows every kind of PNG: grey of 16 bits
  // becomes colour of the high byte.
  const auto color = DecodeColor(png);
  ASSERT_TRUE(color.ok()) << color.status();
  for (size_t i = 0; i < SomeValues().size(); ++i) {
    ASSERT_EQ(color->rgb[3 * i + 1], SomeValues()[i] >> 8);
  }
}

TEST(DepthPngTest, DecodeDepthPngTakesBothWays) {
  const auto plain = DecodeDepthPng(PlainPng(), 0.001);
  ASSERT_TRUE(plain.ok()) << plain.status();
  EXPECT_EQ(plain->values, SomeValues());
  // What follows the end is nobody's business.
  const std::string after_end = PlainPng() + "trailing bytes";
  EXPECT_EQ(DecodeDepthPng(after_end, 0.001)->values, SomeValues());
  // The reader here gives up at a critical chunk that it does not know; the
  // general one has the last word, and refuses it by name.
  const std::string unknown =
      kSignature + Header(kWidth, kHeight) +
      Chunk("IDAT", Deflated(FilteredRows(SomeValues(), 0))) +
      Chunk("ABCD", "") + Chunk("IEND", "");
  EXPECT_FALSE(DecodePlainDepthPng(unknown, kMaxPixels).has_value());
  EXPECT_EQ(DecodeDepthPng(unknown, 0.001).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::image
