// Zip files, LZFSE streams and .sens files, as arbitrary bytes: no crash, and
// never more bytes than were asked for.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "server/tools/capture/lzfse.h"
#include "server/tools/capture/sens_file.h"
#include "server/tools/capture/zip_archive.h"

namespace treeline {
namespace {

void ParseSens(absl::string_view bytes) {
  const auto sens = capture::ReadSens(
      [bytes](uint64_t offset, std::span<uint8_t> out) -> absl::Status {
        if (offset > bytes.size() || out.size() > bytes.size() - offset) {
          std::abort();  // it knows the size
        }
        std::copy_n(bytes.begin() + static_cast<ptrdiff_t>(offset), out.size(),
                    out.begin());
        return absl::OkStatus();
      },
      bytes.size());
  if (!sens.ok()) return;
  for (const capture::SensFrame& frame : sens->frames) {
    if (frame.depth_offset + frame.depth_bytes > bytes.size()) std::abort();
    const auto depth = capture::DecodeSensDepth(
        bytes.substr(frame.depth_offset, frame.depth_bytes), *sens);
    if (depth.ok() && (depth->width != sens->depth.width() ||
                       depth->height != sens->depth.height())) {
      std::abort();
    }
  }
}

void Parse(absl::string_view bytes) {
  ParseSens(bytes);
  for (const size_t size : {size_t{0}, size_t{100}, size_t{64 * 48 * 4}}) {
    const auto decoded = capture::DecodeLzfse(bytes, size);
    if (decoded.ok() && decoded->size() != size) std::abort();
  }
  const auto archive = capture::ZipArchive::Open(
      [bytes](uint64_t offset, std::span<uint8_t> out) -> absl::Status {
        if (offset > bytes.size() || out.size() > bytes.size() - offset) {
          std::abort();  // it knows the size
        }
        std::copy_n(bytes.begin() + static_cast<ptrdiff_t>(offset), out.size(),
                    out.begin());
        return absl::OkStatus();
      },
      bytes.size());
  if (!archive.ok()) return;
  for (const char* name : {"metadata", "rgbd/0.jpg", "rgbd/0.conf"}) {
    const auto entry = archive->Read(name);
    if (entry.ok() && entry->size() > capture::ZipArchive::kMaxEntryBytes) {
      std::abort();
    }
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Parse(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
