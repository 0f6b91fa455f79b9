#include "common/image/decode.h"

#include <turbojpeg.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/image/depth_png.h"
#include "common/image/png_reader.h"

namespace treeline::image {
namespace {

constexpr absl::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);
constexpr absl::string_view kJpegSignature("\xff\xd8\xff", 3);
struct TurboJpegDeleter {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpegHandle =
    std::unique_ptr<std::remove_pointer_t<tjhandle>, TurboJpegDeleter>;

const unsigned char* UnsignedBytes(absl::string_view bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

// What people send in place of JPEG and PNG, by its first bytes; or nothing.
absl::string_view OtherFormat(absl::string_view bytes) {
  struct Magic {
    size_t at;
    absl::string_view bytes;
    absl::string_view name;
  };
  // AVIF has HEIC's container; its brand follows "ftyp".
  constexpr Magic kMagics[] = {
      {4, "ftypavif", "AVIF"},  {4, "ftypavis", "AVIF"},
      {4, "ftyphe", "HEIC"},    {4, "ftypmif1", "HEIC"},
      {8, "WEBP", "WebP"},      {0, "GIF8", "GIF"},
      {0, "BM", "BMP"},         {0, {"II*\0", 4}, "TIFF"},
      {0, {"MM\0*", 4}, "TIFF"}};
  for (const auto& [at, magic, name] : kMagics) {
    if (bytes.size() > at && absl::StartsWith(bytes.substr(at), magic)) {
      return name;
    }
  }
  return "";
}

absl::Status NotAnImage(absl::string_view what, absl::string_view bytes) {
  if (bytes.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(what, " is empty"));
  }
  if (const absl::string_view other = OtherFormat(bytes); !other.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(what, " is neither JPEG nor PNG but ", other));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(what, " is neither JPEG nor PNG (", bytes.size(),
                   " bytes without the signature of either)"));
}

absl::Status JpegError(absl::string_view bytes, tjhandle handle) {
  return absl::InvalidArgumentError(absl::StrCat(
      "JPEG image of ", bytes.size(), " bytes: ", tjGetErrorStr2(handle)));
}

struct OpenedJpeg {
  TurboJpegHandle handle;
  ImageSize size;
};

// Reads the header only.
absl::StatusOr<OpenedJpeg> OpenJpeg(absl::string_view bytes,
                                    const DecodeLimits& limits) {
  OpenedJpeg jpeg{.handle = TurboJpegHandle(tjInitDecompress()), .size = {}};
  if (jpeg.handle == nullptr) {
    return absl::ResourceExhaustedError("cannot start the JPEG decoder");
  }
  int subsampling = 0;
  int color_space = 0;
  if (tjDecompressHeader3(jpeg.handle.get(), UnsignedBytes(bytes), bytes.size(),
                          &jpeg.size.width, &jpeg.size.height, &subsampling,
                          &color_space) != 0) {
    return JpegError(bytes, jpeg.handle.get());
  }
  TL_RETURN_IF_ERROR(
      CheckSize("JPEG image", jpeg.size.width, jpeg.size.height, limits));
  if (color_space == TJCS_CMYK || color_space == TJCS_YCCK) {
    return absl::InvalidArgumentError(
        "JPEG image is CMYK; send grey, YCbCr or RGB");
  }
  return jpeg;
}

// Whether all that the decoder complained of are a few bytes between the last
// pixel and the closing marker, as many USB cameras write them: after them it
// has seen the whole picture.
bool IsPadding(tjhandle handle) {
  constexpr int kMostPadding = 16;
  absl::string_view warning = tjGetErrorStr2(handle);
  int bytes = 0;
  return tjGetErrorCode(handle) == TJERR_WARNING &&
         absl::ConsumePrefix(&warning, "Corrupt JPEG data: ") &&
         absl::ConsumeSuffix(&warning,
                             " extraneous bytes before marker 0xd9") &&
         absl::SimpleAtoi(warning, &bytes) && bytes <= kMostPadding;
}

absl::StatusOr<ColorImage> DecodeJpeg(absl::string_view bytes,
                                      const DecodeLimits& limits) {
  TL_ASSIGN_OR_RETURN(const OpenedJpeg jpeg, OpenJpeg(bytes, limits));
  const int width = jpeg.size.width;
  const int height = jpeg.size.height;
  ColorImage image{.width = width, .height = height, .rgb = {}};
  image.rgb.resize(static_cast<size_t>(width) * static_cast<size_t>(height) *
                   3);
  // The decoder paints what is missing in grey and calls it a warning: to us
  // a warning is an error. The scan limit stops progressive bombs.
  constexpr int kFlags = TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS;
  tjhandle handle = jpeg.handle.get();
  const auto decode = [&](int flags) {
    return tjDecompress2(handle, UnsignedBytes(bytes), bytes.size(),
                         image.rgb.data(), width, 0, height, TJPF_RGB, flags);
  };
  if (decode(kFlags | TJFLAG_STOPONWARNING) == 0) return image;
  if (!IsPadding(handle)) return JpegError(bytes, handle);
  decode(kFlags);  // it complains again, but of nothing before the padding
  return image;
}

absl::StatusOr<ColorImage> DecodeColorPng(absl::string_view bytes,
                                          const DecodeLimits& limits) {
  spng_ihdr header = {};
  TL_ASSIGN_OR_RETURN(const SpngContext context,
                      OpenPng(bytes, limits, header));
  ColorImage image{.width = static_cast<int>(header.width),
                   .height = static_cast<int>(header.height),
                   .rgb = {}};
  image.rgb.resize(size_t{header.width} * header.height * 3);
  TL_RETURN_IF_ERROR(DecodePng(bytes, context.get(), SPNG_FMT_RGB8,
                               image.rgb.data(), image.rgb.size()));
  return image;
}

absl::Status CheckBuffer(int width, int height, size_t count, size_t channels) {
  if (width < 1 || height < 1 ||
      count !=
          static_cast<size_t>(width) * static_cast<size_t>(height) * channels) {
    return absl::InvalidArgumentError(
        absl::StrCat("cannot encode an image of ", width, " x ", height,
                     " pixels with ", count, " values"));
  }
  return absl::OkStatus();
}

}  // namespace

ImageFormat SniffFormat(absl::string_view bytes) {
  if (absl::StartsWith(bytes, kJpegSignature)) return ImageFormat::kJpeg;
  if (absl::StartsWith(bytes, kPngSignature)) return ImageFormat::kPng;
  return ImageFormat::kUnknown;
}

absl::StatusOr<ImageSize> ReadImageSize(absl::string_view bytes,
                                        const DecodeLimits& limits) {
  switch (SniffFormat(bytes)) {
    case ImageFormat::kJpeg: {
      TL_ASSIGN_OR_RETURN(const OpenedJpeg jpeg, OpenJpeg(bytes, limits));
      return jpeg.size;
    }
    case ImageFormat::kPng: {
      spng_ihdr header = {};
      TL_ASSIGN_OR_RETURN(const SpngContext context,
                          OpenPng(bytes, limits, header));
      return ImageSize{static_cast<int>(header.width),
                       static_cast<int>(header.height)};
    }
    case ImageFormat::kUnknown:
      break;
  }
  return NotAnImage("image", bytes);
}

absl::StatusOr<ColorImage> DecodeColor(absl::string_view bytes,
                                       const DecodeLimits& limits) {
  switch (SniffFormat(bytes)) {
    case ImageFormat::kJpeg:
      return DecodeJpeg(bytes, limits);
    case ImageFormat::kPng:
      return DecodeColorPng(bytes, limits);
    case ImageFormat::kUnknown:
      break;
  }
  return NotAnImage("colour image", bytes);
}

absl::StatusOr<DepthImage> DecodeDepthPng(absl::string_view bytes,
                                          double unit_m,
                                          const DecodeLimits& limits) {
  if (!std::isfinite(unit_m) || !(unit_m > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("depth unit of ", unit_m, " m is not positive"));
  }
  switch (SniffFormat(bytes)) {
    case ImageFormat::kPng:
      break;
    case ImageFormat::kJpeg:
      return absl::InvalidArgumentError(
          "depth image is a JPEG; depth must be a 16-bit grey PNG");
    case ImageFormat::kUnknown: {
      const absl::Status problem = NotAnImage("depth image", bytes);
      return absl::InvalidArgumentError(
          absl::StrCat(problem.message(), "; depth must be a 16-bit grey PNG"));
    }
  }
  spng_ihdr header = {};
  TL_ASSIGN_OR_RETURN(const SpngContext context,
                      OpenPng(bytes, limits, header));
  // The header is read, and its size within the limits: now the fast way.
  if (std::optional<PlainDepthPng> plain =
          DecodePlainDepthPng(bytes, limits.max_pixels)) {
    return DepthImage{.width = plain->width,
                      .height = plain->height,
                      .values = std::move(plain->values),
                      .unit_m = unit_m};
  }
  if (header.bit_depth != 16 ||
      header.color_type != SPNG_COLOR_TYPE_GRAYSCALE) {
    return absl::InvalidArgumentError(
        absl::StrCat("depth image has ", header.bit_depth,
                     " bits a channel and PNG colour "
                     "type ",
                     header.color_type, "; depth must be a 16-bit grey PNG"));
  }
  DepthImage image{.width = static_cast<int>(header.width),
                   .height = static_cast<int>(header.height),
                   .values = {},
                   .unit_m = unit_m};
  image.values.resize(size_t{header.width} * header.height);
  TL_RETURN_IF_ERROR(DecodePng(bytes, context.get(), SPNG_FMT_PNG,
                               image.values.data(),
                               image.values.size() * sizeof(uint16_t)));
  return image;
}

absl::StatusOr<std::string> EncodeJpeg(const ColorImage& image, int quality) {
  TL_RETURN_IF_ERROR(
      CheckBuffer(image.width, image.height, image.rgb.size(), 3));
  if (quality < 1 || quality > 100) {
    return absl::InvalidArgumentError(
        absl::StrCat("JPEG quality ", quality, " is outside 1..100"));
  }
  const TurboJpegHandle handle(tjInitCompress());
  if (handle == nullptr) {
    return absl::ResourceExhaustedError("cannot start the JPEG encoder");
  }
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type.
  const int code = tjCompress2(handle.get(), image.rgb.data(), image.width, 0,
                               image.height, TJPF_RGB, &data, &size,
                               quality >= 95 ? TJSAMP_444 : TJSAMP_420, quality,
                               TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, decltype(&tjFree)> buffer(data, &tjFree);
  if (code != 0) {
    return absl::InternalError(
        absl::StrCat("JPEG encoder: ", tjGetErrorStr2(handle.get())));
  }
  return std::string(reinterpret_cast<const char*>(data), size);
}

absl::StatusOr<std::string> EncodePng(const ColorImage& image) {
  TL_RETURN_IF_ERROR(
      CheckBuffer(image.width, image.height, image.rgb.size(), 3));
  const SpngContext context(spng_ctx_new(SPNG_CTX_ENCODER));
  if (context == nullptr) {
    return absl::ResourceExhaustedError("no memory to encode a PNG image");
  }
  spng_ihdr header = {};
  header.width = static_cast<uint32_t>(image.width);
  header.height = static_cast<uint32_t>(image.height);
  header.bit_depth = 8;
  header.color_type = SPNG_COLOR_TYPE_TRUECOLOR;
  int code = spng_set_ihdr(context.get(), &header);
  if (code == 0) {
    code = spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  }
  if (code == 0) {
    code = spng_encode_image(context.get(), image.rgb.data(), image.rgb.size(),
                             SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  }
  size_t size = 0;
  const std::unique_ptr<void, decltype(&std::free)> buffer(
      code == 0 ? spng_get_png_buffer(context.get(), &size, &code) : nullptr,
      &std::free);
  if (code != 0 || buffer == nullptr) {
    return absl::InternalError(
        absl::StrCat("PNG encoder: ", spng_strerror(code)));
  }
  return std::string(static_cast<const char*>(buffer.get()), size);
}

absl::StatusOr<std::string> EncodeDepthPng(const DepthImage& image) {
  TL_RETURN_IF_ERROR(
      CheckBuffer(image.width, image.height, image.values.size(), 1));
  return EncodePlainDepthPng(image.width, image.height, image.values);
}

}  // namespace treeline::image
