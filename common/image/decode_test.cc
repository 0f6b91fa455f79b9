#include "common/image/decode.h"

#include <spng.h>
#include <turbojpeg.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::image {
namespace {

using ::testing::HasSubstr;

// Smooth, so that JPEG keeps it, and different in each channel and corner.
ColorImage Gradient(int width, int height) {
  ColorImage image{.width = width, .height = height, .rgb = {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.rgb.push_back(static_cast<uint8_t>(255 * x / width));
      image.rgb.push_back(static_cast<uint8_t>(255 * y / height));
      image.rgb.push_back(static_cast<uint8_t>(128 - 100 * x / width));
    }
  }
  return image;
}

DepthImage SomeDepth(int width, int height) {
  DepthImage image{.width = width, .height = height, .values = {}};
  for (int i = 0; i < width * height; ++i) {
    image.values.push_back(static_cast<uint16_t>(i * 40503));
  }
  image.values[0] = 0x0102;  // Tells the byte orders apart.
  return image;
}

struct PngKind {
  int color_type;
  int bit_depth;
  int interlace = 0;
};

// A PNG of any kind from raw samples (host order if 16 bit).
std::string MakePng(PngKind kind, uint32_t width, uint32_t height,
                    const void* pixels, size_t bytes,
                    const spng_plte* palette = nullptr) {
  spng_ctx* context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_ihdr header = {};
  header.width = width;
  header.height = height;
  header.color_type = static_cast<uint8_t>(kind.color_type);
  header.bit_depth = static_cast<uint8_t>(kind.bit_depth);
  header.interlace_method = static_cast<uint8_t>(kind.interlace);
  EXPECT_EQ(spng_set_ihdr(context, &header), 0);
  if (palette != nullptr) {
    spng_plte copy = *palette;
    EXPECT_EQ(spng_set_plte(context, &copy), 0);
  }
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  EXPECT_EQ(spng_encode_image(context, pixels, bytes, SPNG_FMT_PNG,
                              SPNG_ENCODE_FINALIZE),
            0);
  size_t size = 0;
  int error = 0;
  void* buffer = spng_get_png_buffer(context, &size, &error);
  EXPECT_EQ(error, 0);
  std::string result(static_cast<char*>(buffer), size);
  std::free(buffer);
  spng_ctx_free(context);
  return result;
}

std::string MakeJpeg(const ColorImage& image, int subsampling, int flags) {
  const tjhandle handle = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(handle, image.rgb.data(), image.width, 0, image.height,
                        TJPF_RGB, &data, &size, subsampling, 95, flags),
            0);
  std::string result(reinterpret_cast<char*>(data), size);
  tjFree(data);
  tjDestroy(handle);
  return result;
}

// A number in the header of a PNG changed, and its CRC with it.
std::string WithPngSize(std::string png, uint32_t width, uint32_t height) {
  const auto put = [&](size_t at, uint32_t value) {
    for (size_t i = 0; i < 4; ++i) {
      png[at + i] = static_cast<char>(value >> (24 - 8 * i));
    }
  };
  put(16, width);
  put(20, height);
  uint32_t crc = 0xffffffffu;
  for (size_t i = 12; i < 29; ++i) {
    crc ^= static_cast<uint8_t>(png[i]);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320u : 0);
    }
  }
  put(29, ~crc);
  return png;
}

std::string WithJpegSize(std::string jpeg, int width, int height) {
  const size_t at = jpeg.find("\xff\xc0");
  EXPECT_NE(at, std::string::npos);
  jpeg[at + 5] = static_cast<char>(height >> 8);
  jpeg[at + 6] = static_cast<char>(height);
  jpeg[at + 7] = static_cast<char>(width >> 8);
  jpeg[at + 8] = static_cast<char>(width);
  return jpeg;
}

// The CRC of a PNG's closing chunk, which has no content, is not looked at.
size_t IgnoredTail(const std::string& bytes) {
  return SniffFormat(bytes) == ImageFormat::kPng ? 4 : 0;
}

std::string ColorError(const std::string& bytes,
                       const DecodeLimits& limits = {}) {
  const auto image = DecodeColor(bytes, limits);
  EXPECT_EQ(image.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(image.status().message());
}

std::string DepthError(const std::string& bytes, double unit_m = 0.001) {
  const auto image = DecodeDepthPng(bytes, unit_m);
  EXPECT_EQ(image.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(image.status().message());
}

void ExpectNear(const ColorImage& a, const ColorImage& b, double rms) {
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  ASSERT_EQ(a.rgb.size(), b.rgb.size());
  double sum = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i) {
    const double difference = a.rgb[i] - b.rgb[i];
    sum += difference * difference;
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(a.rgb.size())), rms);
}

TEST(SniffFormatTest, LooksAtTheFirstBytesOnly) {
  EXPECT_EQ(SniffFormat(*EncodeJpeg(Gradient(8, 8), 90)), ImageFormat::kJpeg);
  EXPECT_EQ(SniffFormat(*EncodePng(Gradient(8, 8))), ImageFormat::kPng);
  EXPECT_EQ(SniffFormat("GIF89a"), ImageFormat::kUnknown);
  EXPECT_EQ(SniffFormat("\xff\xd8"), ImageFormat::kUnknown);
  EXPECT_EQ(SniffFormat(""), ImageFormat::kUnknown);
}

TEST(ReadImageSizeTest, ReadsTheHeaderOfBothFormats) {
  const std::string png = *EncodePng(Gradient(37, 23));
  const std::string jpeg = *EncodeJpeg(Gradient(23, 37), 90);
  EXPECT_EQ(*ReadImageSize(png), (ImageSize{37, 23}));
  EXPECT_EQ(*ReadImageSize(jpeg), (ImageSize{23, 37}));
  // The pixels need not be there, the header must.
  EXPECT_EQ(*ReadImageSize(png.substr(0, 40)), (ImageSize{37, 23}));
  EXPECT_FALSE(ReadImageSize(png.substr(0, 20)).ok());
  EXPECT_FALSE(ReadImageSize(jpeg.substr(0, 20)).ok());
  EXPECT_FALSE(ReadImageSize("").ok());
  EXPECT_FALSE(ReadImageSize(WithPngSize(png, 65000, 65000)).ok());
}

TEST(DecodeColorTest, PngIsExact) {
  const ColorImage image = Gradient(37, 23);
  const auto decoded = DecodeColor(*EncodePng(image));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->width, 37);
  EXPECT_EQ(decoded->height, 23);
  EXPECT_EQ(decoded->rgb, image.rgb);
}

// Quantisation steps at these qualities are a few grey levels; the gradient
// has no detail that a coarser step would take away.
TEST(DecodeColorTest, JpegOfEverySamplingIsClose) {
  const ColorImage image = Gradient(65, 47);
  for (const int sampling : {TJSAMP_444, TJSAMP_422, TJSAMP_420, TJSAMP_440}) {
    const auto decoded = DecodeColor(MakeJpeg(image, sampling, 0));
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    ExpectNear(*decoded, image, 2.5);
  }
}

TEST(DecodeColorTest, ProgressiveJpegEqualsBaseline) {
  const ColorImage image = Gradient(65, 47);
  const auto baseline = DecodeColor(MakeJpeg(image, TJSAMP_444, 0));
  const auto progressive =
      DecodeColor(MakeJpeg(image, TJSAMP_444, TJFLAG_PROGRESSIVE));
  ASSERT_TRUE(progressive.ok()) << progressive.status();
  ExpectNear(*progressive, *baseline, 1);
}

TEST(DecodeColorTest, GreyJpegBecomesEqualChannels) {
  const auto decoded = DecodeColor(MakeJpeg(Gradient(40, 30), TJSAMP_GRAY, 0));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  ASSERT_EQ(decoded->rgb.size(), 3u * 40 * 30);
  for (size_t i = 0; i < decoded->rgb.size(); i += 3) {
    ASSERT_EQ(decoded->rgb[i], decoded->rgb[i + 1]);
    ASSERT_EQ(decoded->rgb[i], decoded->rgb[i + 2]);
  }
  EXPECT_NE(decoded->rgb[0], decoded->rgb[3 * 39]);
}

TEST(DecodeColorTest, GreyPngOfEveryDepthFillsTheRange) {
  // Two pixels a row: black and white, packed from the left.
  const std::vector<uint8_t> one = {0x40};
  const std::vector<uint8_t> two = {0x30};
  const std::vector<uint8_t> four = {0x0f};
  const std::vector<uint8_t> eight = {0x00, 0xff};
  const std::vector<uint16_t> sixteen = {0x0000, 0xffff};
  const auto expect = [](int bits, const void* pixels, size_t bytes) {
    const auto decoded = DecodeColor(
        MakePng({SPNG_COLOR_TYPE_GRAYSCALE, bits}, 2, 1, pixels, bytes));
    ASSERT_TRUE(decoded.ok()) << bits << ": " << decoded.status();
    EXPECT_EQ(decoded->rgb, (std::vector<uint8_t>{0, 0, 0, 255, 255, 255}))
        << bits;
  };
  expect(1, one.data(), one.size());
  expect(2, two.data(), two.size());
  expect(4, four.data(), four.size());
  expect(8, eight.data(), eight.size());
  expect(16, sixteen.data(), 4);
}

TEST(DecodeColorTest, PalettePngLooksUpItsColours) {
  spng_plte palette = {};
  palette.n_entries = 2;
  palette.entries[0] = {10, 20, 30, 255};
  palette.entries[1] = {40, 50, 60, 255};
  const std::vector<uint8_t> indices = {1, 0};
  const auto decoded = DecodeColor(
      MakePng({SPNG_COLOR_TYPE_INDEXED, 8}, 2, 1, indices.data(), 2, &palette));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->rgb, (std::vector<uint8_t>{40, 50, 60, 10, 20, 30}));
}

TEST(DecodeColorTest, AlphaIsDropped) {
  const std::vector<uint8_t> rgba = {1, 2, 3, 0, 4, 5, 6, 255};
  const auto color = DecodeColor(
      MakePng({SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 8}, 2, 1, rgba.data(), 8));
  ASSERT_TRUE(color.ok()) << color.status();
  EXPECT_EQ(color->rgb, (std::vector<uint8_t>{1, 2, 3, 4, 5, 6}));
  const std::vector<uint8_t> grey_alpha = {7, 0, 9, 128};
  const auto grey = DecodeColor(MakePng({SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, 8}, 2,
                                        1, grey_alpha.data(), 4));
  ASSERT_TRUE(grey.ok()) << grey.status();
  EXPECT_EQ(grey->rgb, (std::vector<uint8_t>{7, 7, 7, 9, 9, 9}));
}

TEST(DecodeColorTest, SixteenBitColourKeepsTheHighByte) {
  const std::vector<uint16_t> rgb = {0x1234, 0xabcd, 0x00ff};
  const auto decoded = DecodeColor(
      MakePng({SPNG_COLOR_TYPE_TRUECOLOR, 16}, 1, 1, rgb.data(), 6));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->rgb, (std::vector<uint8_t>{0x12, 0xab, 0x00}));
}

TEST(DecodeColorTest, EveryTruncationIsAnError) {
  const ColorImage image = Gradient(64, 48);
  for (const std::string& whole :
       {*EncodePng(image), MakeJpeg(image, TJSAMP_420, 0),
        MakeJpeg(image, TJSAMP_420, TJFLAG_PROGRESSIVE)}) {
    ASSERT_TRUE(DecodeColor(whole).ok());
    const size_t end = whole.size() - IgnoredTail(whole);
    for (size_t size = 0; size < end; ++size) {
      EXPECT_EQ(DecodeColor(whole.substr(0, size)).status().code(),
                absl::StatusCode::kInvalidArgument)
          << size << " of " << whole.size();
    }
  }
}

// "Corrupt JPEG data: 2 extraneous bytes before marker 0xd9".
TEST(DecodeColorTest, PaddingBeforeTheEndOfAJpegIsNoDamage) {
  for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
    const std::string whole = MakeJpeg(Gradient(64, 48), TJSAMP_420, flags);
    const auto padded = [&](size_t size) {
      std::string bytes = whole;
      bytes.insert(bytes.size() - 2, std::string(size, '\x12'));
      return DecodeColor(bytes);
    };
    ASSERT_TRUE(padded(2).ok()) << padded(2).status();
    EXPECT_EQ(padded(2)->rgb, DecodeColor(whole)->rgb);
    EXPECT_FALSE(padded(100).ok());
  }
}

TEST(DecodeColorTest, FlippedBytesNeverPassAsAPng) {
  const std::string png = *EncodePng(Gradient(16, 12));
  for (size_t i = 0; i < png.size() - IgnoredTail(png); ++i) {
    std::string broken = png;
    broken[i] = static_cast<char>(broken[i] ^ 0x10);
    EXPECT_FALSE(DecodeColor(broken).ok()) << i;
  }
}

TEST(DecodeColorTest, ForeignBytesAreNamed) {
  EXPECT_THAT(ColorError(""), HasSubstr("empty"));
  EXPECT_THAT(ColorError("GIF89a......"), HasSubstr("neither JPEG nor PNG"));
  EXPECT_THAT(ColorError({"\0\0\0\x18"
                          "ftypheic",
                          12}),
              HasSubstr("HEIC"));
  EXPECT_THAT(ColorError({"\0\0\0\x1c"
                          "ftypavif",
                          12}),
              HasSubstr("AVIF"));
  EXPECT_THAT(ColorError({"RIFF\x10\0\0\0WEBPVP8 ", 16}), HasSubstr("WebP"));
  EXPECT_THAT(DepthError({"II*\0\x08\0\0\0", 8}), HasSubstr("TIFF"));
  EXPECT_THAT(ColorError(std::string(1000, '\0')), HasSubstr("1000 bytes"));
}

TEST(DecodeColorTest, AbsurdSizesAreRefusedFromTheHeader) {
  const std::string png = *EncodePng(Gradient(16, 12));
  const std::string jpeg = MakeJpeg(Gradient(16, 12), TJSAMP_420, 0);
  // Decoding these would take 12 GB; the test would not live to see it.
  EXPECT_THAT(ColorError(WithPngSize(png, 65000, 65000)),
              HasSubstr("65000 x 65000 pixels is over the limit"));
  EXPECT_THAT(ColorError(WithPngSize(png, 0x7fffffff, 0x7fffffff)),
              HasSubstr("PNG"));
  EXPECT_THAT(ColorError(WithPngSize(png, 0, 12)), HasSubstr("PNG"));
  EXPECT_THAT(ColorError(WithJpegSize(jpeg, 65000, 65000)),
              HasSubstr("65000 x 65000 pixels is over the limit"));
  EXPECT_THAT(ColorError(WithJpegSize(jpeg, 0, 12)), HasSubstr("JPEG"));
  // Each side within its limit, the product not.
  EXPECT_THAT(ColorError(WithPngSize(png, 8192, 8192)), HasSubstr("limit"));
}

TEST(DecodeColorTest, ALimitIsInclusive) {
  const std::string png = *EncodePng(Gradient(16, 12));
  EXPECT_TRUE(DecodeColor(png, {16, 12, 16 * 12}).ok());
  EXPECT_FALSE(DecodeColor(png, {15, 12, 16 * 12}).ok());
  EXPECT_FALSE(DecodeColor(png, {16, 11, 16 * 12}).ok());
  EXPECT_FALSE(DecodeColor(png, {16, 12, 16 * 12 - 1}).ok());
}

TEST(DecodeColorTest, APngLargerThanItsDataIsTruncated) {
  const std::string png = *EncodePng(Gradient(16, 12));
  EXPECT_THAT(ColorError(WithPngSize(png, 5000, 5000)), HasSubstr("truncated"));
  EXPECT_FALSE(DecodeColor(WithPngSize(png, 16, 13)).ok());
}

TEST(DecodeDepthPngTest, RoundTripsEveryValueInHostOrder) {
  const DepthImage image = SomeDepth(320, 240);
  const auto decoded = DecodeDepthPng(*EncodeDepthPng(image), 0.0002);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->width, 320);
  EXPECT_EQ(decoded->height, 240);
  EXPECT_EQ(decoded->unit_m, 0.0002);
  EXPECT_EQ(decoded->values, image.values);
}

TEST(DecodeDepthPngTest, StoresBigEndianAsThePngStandardSays) {
  // One row, no filter, stored rather than deflated: the samples are readable.
  const std::vector<uint16_t> pixels = {0x4142};
  const std::string png =
      MakePng({SPNG_COLOR_TYPE_GRAYSCALE, 16}, 1, 1, pixels.data(), 2);
  EXPECT_EQ(DecodeDepthPng(png, 1)->values[0], 0x4142);
  EXPECT_EQ(DecodeColor(png)->rgb[0], 0x41);
}

TEST(DecodeDepthPngTest, OtherKindsAreRefusedByName) {
  const ColorImage color = Gradient(8, 8);
  EXPECT_THAT(DepthError(*EncodePng(color)), HasSubstr("8 bits a channel"));
  EXPECT_THAT(DepthError(*EncodeJpeg(color, 90)), HasSubstr("JPEG"));
  EXPECT_THAT(DepthError(""), HasSubstr("empty"));
  EXPECT_THAT(DepthError("depth"),
              AllOf(HasSubstr("neither"), HasSubstr("16-bit grey PNG")));
  const std::vector<uint8_t> grey = {1, 2};
  EXPECT_THAT(
      DepthError(MakePng({SPNG_COLOR_TYPE_GRAYSCALE, 8}, 2, 1, grey.data(), 2)),
      HasSubstr("16-bit grey"));
}

TEST(DecodeDepthPngTest, EveryTruncationIsAnError) {
  const std::string whole = *EncodeDepthPng(SomeDepth(16, 12));
  for (size_t size = 0; size < whole.size() - IgnoredTail(whole); ++size) {
    EXPECT_FALSE(DecodeDepthPng(whole.substr(0, size), 0.001).ok()) << size;
  }
}

TEST(DecodeDepthPngTest, TheUnitMustBePositive) {
  const std::string png = *EncodeDepthPng(SomeDepth(4, 4));
  EXPECT_THAT(DepthError(png, 0), HasSubstr("unit"));
  EXPECT_THAT(DepthError(png, -0.001), HasSubstr("unit"));
  EXPECT_THAT(DepthError(png, std::numeric_limits<double>::quiet_NaN()),
              HasSubstr("unit"));
  EXPECT_THAT(DepthError(png, std::numeric_limits<double>::infinity()),
              HasSubstr("unit"));
}

TEST(EncodeTest, BuffersThatDoNotMatchTheirSizeAreRefused) {
  ColorImage color = Gradient(8, 8);
  color.rgb.pop_back();
  EXPECT_FALSE(EncodeJpeg(color, 90).ok());
  EXPECT_FALSE(EncodePng(color).ok());
  DepthImage depth = SomeDepth(8, 8);
  depth.height = 9;
  EXPECT_FALSE(EncodeDepthPng(depth).ok());
  EXPECT_FALSE(EncodePng(ColorImage{}).ok());
}

TEST(EncodeTest, JpegQualityIsChecked) {
  EXPECT_FALSE(EncodeJpeg(Gradient(8, 8), 0).ok());
  EXPECT_FALSE(EncodeJpeg(Gradient(8, 8), 101).ok());
}

TEST(EncodeTest, JpegKeepsFullColourFromQuality95) {
  const auto sampling = [](int quality) {
    const std::string jpeg = *EncodeJpeg(Gradient(32, 32), quality);
    const tjhandle handle = tjInitDecompress();
    int width, height, subsampling, color_space;
    EXPECT_EQ(tjDecompressHeader3(
                  handle, reinterpret_cast<const unsigned char*>(jpeg.data()),
                  jpeg.size(), &width, &height, &subsampling, &color_space),
              0);
    tjDestroy(handle);
    return subsampling;
  };
  EXPECT_EQ(sampling(94), TJSAMP_420);
  EXPECT_EQ(sampling(95), TJSAMP_444);
}

}  // namespace
}  // namespace treeline::image
