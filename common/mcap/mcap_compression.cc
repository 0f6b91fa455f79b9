#include "common/mcap/mcap_compression.h"

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::mcap {
namespace {

constexpr size_t kFirstRoom = size_t{1} << 20;

absl::Status Failed(const char* what) {
  return absl::DataLossError(absl::StrCat("a chunk: ", what));
}

// Calls step(room, taken), which unpacks into `made` from `written` on, until
// it says that all is done. Room grows with what was unpacked: what bytes from
// outside announce is not believed before it is there.
template <typename Step>
absl::StatusOr<std::string> Unpacked(absl::string_view bytes, size_t size,
                                     const Step& step) {
  std::string made(std::min(size, kFirstRoom), 0);
  size_t written = 0;
  while (true) {
    size_t room = made.size() - written;
    size_t taken = bytes.size();
    TL_ASSIGN_OR_RETURN(const bool is_done,
                        step(made.data() + written, room, bytes.data(), taken));
    written += room;
    bytes.remove_prefix(taken);
    if (is_done) break;
    if (written == made.size() && made.size() < size) {
      made.resize(std::min(size, 2 * made.size()));
    } else if (room == 0 && taken == 0) {
      return Failed("it ends too early, or is longer than told");
    }
  }
  if (written != size || !bytes.empty()) {
    return Failed("it is of another size than told");
  }
  return made;
}

absl::StatusOr<std::string> DecompressLz4(absl::string_view bytes,
                                          size_t size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) {
    return absl::InternalError("lz4: no context");
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)>
      context(raw, LZ4F_freeDecompressionContext);
  return Unpacked(bytes, size,
                  [&](char* to, size_t& room, const char* from,
                      size_t& taken) -> absl::StatusOr<bool> {
                    const size_t hint = LZ4F_decompress(
                        context.get(), to, &room, from, &taken, nullptr);
                    if (LZ4F_isError(hint) != 0) {
                      return Failed("its lz4 is broken");
                    }
                    return hint == 0;
                  });
}

absl::StatusOr<std::string> DecompressZstd(absl::string_view bytes,
                                           size_t size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(
      ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (context == nullptr) return absl::InternalError("zstd: no context");
  return Unpacked(bytes, size,
                  [&](char* to, size_t& room, const char* from,
                      size_t& taken) -> absl::StatusOr<bool> {
                    ZSTD_outBuffer out = {to, room, 0};
                    ZSTD_inBuffer in = {from, taken, 0};
                    const size_t hint =
                        ZSTD_decompressStream(context.get(), &out, &in);
                    if (ZSTD_isError(hint) != 0)
                      return Failed("its zstd is broken");
                    room = out.pos;
                    taken = in.pos;
                    return hint == 0;
                  });
}

}  // namespace

absl::string_view CompressionName(Compression compression) {
  switch (compression) {
    case Compression::kNone:
      return "";
    case Compression::kLz4:
      return "lz4";
    case Compression::kZstd:
      return "zstd";
  }
  return "?";
}

absl::StatusOr<Compression> ParseCompression(absl::string_view name) {
  for (const Compression known :
       {Compression::kNone, Compression::kLz4, Compression::kZstd}) {
    if (name == CompressionName(known)) return known;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "MCAP: the compression \"", name, "\" is not known; lz4 and zstd are"));
}

absl::StatusOr<std::string> Compress(Compression compression,
                                     absl::string_view bytes) {
  if (compression == Compression::kNone) return std::string(bytes);
  std::string made;
  size_t size = 0;
  if (compression == Compression::kLz4) {
    made.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
    size = LZ4F_compressFrame(made.data(), made.size(), bytes.data(),
                              bytes.size(), nullptr);
    if (LZ4F_isError(size) != 0) {
      return absl::InternalError(
          absl::StrCat("lz4: ", LZ4F_getErrorName(size)));
    }
  } else {
    made.resize(ZSTD_compressBound(bytes.size()));
    size = ZSTD_compress(made.data(), made.size(), bytes.data(), bytes.size(),
                         ZSTD_CLEVEL_DEFAULT);
    if (ZSTD_isError(size) != 0) {
      return absl::InternalError(
          absl::StrCat("zstd: ", ZSTD_getErrorName(size)));
    }
  }
  made.resize(size);
  return made;
}

absl::StatusOr<std::string> Decompress(Compression compression,
                                       absl::string_view bytes, size_t size) {
  if (compression == Compression::kLz4) return DecompressLz4(bytes, size);
  if (compression == Compression::kNone) {
    if (bytes.size() != size) return Failed("another size than told");
    return std::string(bytes);
  }
  return DecompressZstd(bytes, size);
}

uint32_t Crc32(absl::string_view bytes) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace treeline::mcap
