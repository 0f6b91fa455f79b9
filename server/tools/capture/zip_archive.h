// Zip files (PKWARE's APPNOTE.TXT 6.3.10), read entry by entry.
#ifndef SERVER_TOOLS_CAPTURE_ZIP_ARCHIVE_H_
#define SERVER_TOOLS_CAPTURE_ZIP_ARCHIVE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::capture {

// The names in an archive and where their bytes are. Entries are read into
// memory and nothing is written under their names, so that names which lead out
// of a folder do no harm. Safe on hostile bytes: an entry takes as much memory
// as it says, which is at most kMaxEntryBytes, and one that holds more is
// damaged.
class ZipArchive {
 public:
  static constexpr uint64_t kMaxEntryBytes = 128u << 20;

  // Fills `out` with the archive's bytes from `offset` on.
  using ReadAt =
      std::function<absl::Status(uint64_t offset, std::span<uint8_t> out)>;

  // INVALID_ARGUMENT: it is no zip file, or one of the kind for more than 4 GiB
  // or 65534 entries (ZIP64), of several files, or with a name twice.
  static absl::StatusOr<ZipArchive> Open(ReadAt read_at, uint64_t size);
  static absl::StatusOr<ZipArchive> OpenFile(const std::string& path);

  bool Has(const std::string& name) const { return entries_.contains(name); }
  // NOT_FOUND; INVALID_ARGUMENT: it is encrypted, too large, damaged, or packed
  // otherwise than by Deflate or not at all.
  absl::StatusOr<std::string> Read(const std::string& name) const;

 private:
  struct Entry {
    uint16_t flags = 0;
    uint16_t method = 0;
    uint32_t checksum = 0;
    uint32_t packed_bytes = 0;
    uint32_t bytes = 0;
    uint32_t header_offset = 0;
  };

  absl::Status ReadDirectory(absl::string_view directory, int entries);

  ReadAt read_at_;
  uint64_t size_ = 0;
  std::map<std::string, Entry> entries_;
};

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_ZIP_ARCHIVE_H_
