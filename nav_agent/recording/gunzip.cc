#include "nav_agent/recording/gunzip.h"

#include <zlib.h>

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"

namespace treeline::recording {
namespace {

// Ends the stream when it goes out of scope.
struct Inflater {
  z_stream stream{};
  bool started = false;

  Inflater() = default;
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() {
    if (started) inflateEnd(&stream);
  }
};

}  // namespace

bool IsGzip(absl::string_view bytes) {
  return bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b';
}

absl::StatusOr<std::string> Gunzip(absl::string_view bytes, size_t max_bytes) {
  constexpr int kGzipWindow = 15 + 16;  // zlib.h: 16 says gzip
  constexpr size_t kChunk = size_t{1} << 18;
  Inflater inflater;
  z_stream& stream = inflater.stream;
  if (inflateInit2(&stream, kGzipWindow) != Z_OK) {
    return absl::InternalError("zlib does not start");
  }
  inflater.started = true;
  std::string out;
  std::vector<Bytef> chunk(kChunk);
  // zlib counts in 32 bits; it promises not to write through next_in.
  size_t offset = 0;
  int state = Z_OK;
  while (state != Z_STREAM_END) {
    const size_t take = std::min(bytes.size() - offset, kChunk);
    if (take == 0 && stream.avail_in == 0) {
      return absl::DataLossError("the compressed data ends early");
    }
    if (stream.avail_in == 0) {
      stream.next_in =
          reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + offset));
      stream.avail_in = static_cast<uInt>(take);
      offset += take;
    }
    stream.next_out = chunk.data();
    stream.avail_out = static_cast<uInt>(chunk.size());
    state = inflate(&stream, Z_NO_FLUSH);
    if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR) {
      return absl::DataLossError("the compressed data is broken");
    }
    const size_t made = chunk.size() - stream.avail_out;
    if (out.size() + made > max_bytes) {
      return absl::ResourceExhaustedError(
          absl::StrCat("more than ", max_bytes, " bytes after decompression"));
    }
    out.append(reinterpret_cast<const char*>(chunk.data()), made);
  }
  return out;
}

}  // namespace treeline::recording
