// For tests: depth packed as others pack it, written here by their listings and
// not with the decoders' code.
#ifndef COMMON_IMAGE_TESTING_DEPTH_CODECS_H_
#define COMMON_IMAGE_TESTING_DEPTH_CODECS_H_

#include <spng.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

namespace treeline::image {

inline void AppendWord(uint32_t word, std::string& out) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<char>(word >> 8 * i));
}

// By the paper's listing: each number in nibbles, the lowest three bits first,
// eight nibbles a word, the first one highest.
inline std::string EncodedRvl(uint32_t width, uint32_t height,
                              const std::vector<uint16_t>& values) {
  std::vector<uint32_t> nibbles;
  const auto put = [&](uint32_t number) {
    do {
      const uint32_t low = number & 7U;
      number >>= 3;
      nibbles.push_back(number != 0 ? low | 8U : low);
    } while (number != 0);
  };
  int previous = 0;
  for (size_t at = 0; at < values.size();) {
    size_t zeros = 0;
    while (at + zeros < values.size() && values[at + zeros] == 0) ++zeros;
    at += zeros;
    size_t measured = 0;
    while (at + measured < values.size() && values[at + measured] != 0) {
      ++measured;
    }
    put(static_cast<uint32_t>(zeros));
    put(static_cast<uint32_t>(measured));
    for (; measured > 0; --measured, ++at) {
      const int delta = values[at] - previous;
      put(static_cast<uint32_t>(delta < 0 ? -2 * delta - 1 : 2 * delta));
      previous = values[at];
    }
  }
  std::string bytes;
  AppendWord(width, bytes);
  AppendWord(height, bytes);
  uint32_t word = 0;
  for (size_t i = 0; i < nibbles.size(); ++i) {
    word |= nibbles[i] << (28 - 4 * (i % 8));
    if (i % 8 == 7 || i + 1 == nibbles.size()) {
      AppendWord(word, bytes);
      word = 0;
    }
  }
  return bytes;
}

// As OpenCV writes BGRA pixels: the PNG's channels are red, green, blue, alpha.
inline std::string EncodedFloatDepthPng(uint32_t width, uint32_t height,
                                        const std::vector<float>& values_m) {
  std::vector<uint8_t> rgba;
  for (const float value : values_m) {
    const auto bits = std::bit_cast<uint32_t>(value);
    const auto byte = [bits](int i) {
      return static_cast<uint8_t>(bits >> (8 * i));
    };
    for (const int channel : {2, 1, 0, 3}) rgba.push_back(byte(channel));
  }
  spng_ctx* const context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  spng_ihdr header = {};
  header.width = width;
  header.height = height;
  header.bit_depth = 8;
  header.color_type = SPNG_COLOR_TYPE_TRUECOLOR_ALPHA;
  spng_set_ihdr(context, &header);
  if (spng_encode_image(context, rgba.data(), rgba.size(), SPNG_FMT_PNG,
                        SPNG_ENCODE_FINALIZE) != 0) {
    std::abort();
  }
  size_t size = 0;
  int error = 0;
  void* const bytes = spng_get_png_buffer(context, &size, &error);
  std::string png(static_cast<const char*>(bytes), size);
  std::free(bytes);
  spng_ctx_free(context);
  return png;
}

}  // namespace treeline::image

#endif  // COMMON_IMAGE_TESTING_DEPTH_CODECS_H_
