#include "server/tools/capture/zip_archive.h"

#include <libdeflate.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/input_file.h"
#include "common/base/status_macros.h"

namespace treeline::capture {
namespace {

constexpr uint64_t kEndBytes = 22;  // of the end of the directory
constexpr uint64_t kMaxCommentBytes = 65535;
constexpr size_t kDirectoryEntryBytes = 46;
constexpr uint64_t kLocalHeaderBytes = 30;
constexpr absl::string_view kEndMagic("PK\x05\x06", 4);
constexpr absl::string_view kDirectoryMagic("PK\x01\x02", 4);
constexpr absl::string_view kLocalMagic("PK\x03\x04", 4);
constexpr uint16_t kEncrypted = 1;
constexpr uint16_t kStored = 0;
constexpr uint16_t kDeflated = 8;

absl::Status NoZip(absl::string_view why) {
  return absl::InvalidArgumentError(
      absl::StrCat("is no zip file that can be read: ", why));
}

uint32_t Number(absl::string_view bytes, size_t at, size_t count) {
  uint32_t value = 0;
  for (size_t i = 0; i < count; ++i) {
    value |= uint32_t{static_cast<uint8_t>(bytes[at + i])} << (8 * i);
  }
  return value;
}

absl::StatusOr<std::string> BytesAt(const ZipArchive::ReadAt& read_at,
                                    uint64_t offset, uint64_t count) {
  std::string bytes(count, '\0');
  TL_RETURN_IF_ERROR(read_at(
      offset, {reinterpret_cast<uint8_t*>(bytes.data()), bytes.size()}));
  return bytes;
}

absl::StatusOr<std::string> Inflated(const std::string& packed, size_t size) {
  const std::unique_ptr<libdeflate_decompressor,
                        decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(),
                   &libdeflate_free_decompressor);
  std::string bytes(size, '\0');
  size_t written = 0;
  if (libdeflate_deflate_decompress(decompressor.get(), packed.data(),
                                    packed.size(), bytes.data(), size,
                                    &written) != LIBDEFLATE_SUCCESS ||
      written != size) {
    return absl::InvalidArgumentError("is damaged, or longer than it says");
  }
  return bytes;
}

}  // namespace

absl::StatusOr<ZipArchive> ZipArchive::OpenFile(const std::string& path) {
  TL_ASSIGN_OR_RETURN(base::InputFile opened, base::InputFile::Open(path));
  const auto file = std::make_shared<const base::InputFile>(std::move(opened));
  auto archive =
      Open([file](uint64_t offset,
                  std::span<uint8_t> out) { return file->ReadAt(offset, out); },
           file->size());
  if (!archive.ok()) return base::Annotate(archive.status(), path);
  return archive;
}

absl::StatusOr<ZipArchive> ZipArchive::Open(ReadAt read_at, uint64_t size) {
  if (size < kEndBytes) return NoZip("it is too short");
  const uint64_t tail_bytes = std::min(size, kEndBytes + kMaxCommentBytes);
  TL_ASSIGN_OR_RETURN(const std::string tail,
                      BytesAt(read_at, size - tail_bytes, tail_bytes));
  const size_t end = absl::string_view(tail).rfind(
      kEndMagic, tail.size() - static_cast<size_t>(kEndBytes));
  if (end == absl::string_view::npos) {
    return NoZip("it has no directory; was it copied completely?");
  }
  if (Number(tail, end + 4, 2) != 0 || Number(tail, end + 6, 2) != 0) {
    return NoZip("it is one part of several");
  }
  const uint32_t entries = Number(tail, end + 10, 2);
  const uint32_t directory_bytes = Number(tail, end + 12, 4);
  const uint32_t directory_offset = Number(tail, end + 16, 4);
  if (entries == 0xffff || directory_offset == 0xffffffff) {
    return NoZip("it is larger than 4 GiB; unpack it, and give the folder");
  }
  if (uint64_t{directory_offset} + directory_bytes > size) {
    return NoZip("its directory lies behind its end");
  }
  ZipArchive archive;
  TL_ASSIGN_OR_RETURN(const std::string directory,
                      BytesAt(read_at, directory_offset, directory_bytes));
  archive.read_at_ = std::move(read_at);
  archive.size_ = size;
  TL_RETURN_IF_ERROR(
      archive.ReadDirectory(directory, static_cast<int>(entries)));
  return archive;
}

absl::Status ZipArchive::ReadDirectory(absl::string_view directory,
                                       int entries) {
  for (int i = 0; i < entries; ++i) {
    if (directory.size() < kDirectoryEntryBytes ||
        directory.substr(0, 4) != kDirectoryMagic) {
      return NoZip("its directory is damaged");
    }
    const size_t name_bytes = Number(directory, 28, 2);
    const size_t length = kDirectoryEntryBytes + name_bytes +
                          Number(directory, 30, 2) + Number(directory, 32, 2);
    if (directory.size() < length) return NoZip("its directory is damaged");
    const std::string name(directory.substr(kDirectoryEntryBytes, name_bytes));
    const bool is_new =
        entries_
            .emplace(
                name,
                Entry{.flags = static_cast<uint16_t>(Number(directory, 8, 2)),
                      .method = static_cast<uint16_t>(Number(directory, 10, 2)),
                      .checksum = Number(directory, 16, 4),
                      .packed_bytes = Number(directory, 20, 4),
                      .bytes = Number(directory, 24, 4),
                      .header_offset = Number(directory, 42, 4)})
            .second;
    if (!is_new) return NoZip(absl::StrCat("it has '", name, "' twice"));
    directory.remove_prefix(length);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> ZipArchive::Read(const std::string& name) const {
  const auto found = entries_.find(name);
  if (found == entries_.end()) {
    return absl::NotFoundError(absl::StrCat("there is no ", name));
  }
  const Entry& entry = found->second;
  const auto damaged = [&](absl::string_view why) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", why));
  };
  if ((entry.flags & kEncrypted) != 0) return damaged("is encrypted");
  if (entry.method != kStored && entry.method != kDeflated) {
    return damaged("is packed in a way that is not supported; pack it anew");
  }
  if (entry.bytes > kMaxEntryBytes || entry.packed_bytes > kMaxEntryBytes) {
    return damaged(absl::StrCat("has ", entry.bytes, " bytes; at most ",
                                kMaxEntryBytes, " are read"));
  }
  if (uint64_t{entry.header_offset} + kLocalHeaderBytes > size_) {
    return damaged("lies behind the end");
  }
  TL_ASSIGN_OR_RETURN(
      const std::string header,
      BytesAt(read_at_, entry.header_offset, kLocalHeaderBytes));
  const uint64_t begin = uint64_t{entry.header_offset} + kLocalHeaderBytes +
                         Number(header, 26, 2) + Number(header, 28, 2);
  if (absl::string_view(header).substr(0, 4) != kLocalMagic ||
      begin + entry.packed_bytes > size_) {
    return damaged("is damaged");
  }
  TL_ASSIGN_OR_RETURN(std::string bytes,
                      BytesAt(read_at_, begin, entry.packed_bytes));
  if (entry.method == kDeflated) {
    auto inflated = Inflated(bytes, entry.bytes);
    if (!inflated.ok()) return damaged(inflated.status().message());
    bytes = *std::move(inflated);
  } else if (bytes.size() != entry.bytes) {
    return damaged("is damaged");
  }
  if (libdeflate_crc32(0, bytes.data(), bytes.size()) != entry.checksum) {
    return damaged("its checksum is wrong");
  }
  return bytes;
}

}  // namespace treeline::capture
