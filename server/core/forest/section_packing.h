// How a section of a model file is packed: its records as columns of bytes,
// each compressed by itself with zstd. Nothing is lost.
// docs/reference/model-format.md specifies it byte by byte.
#ifndef SERVER_CORE_FOREST_SECTION_PACKING_H_
#define SERVER_CORE_FOREST_SECTION_PACKING_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::forest {

// A field of a record: a little-endian whole number.
struct PackedField {
  uint8_t width = 1;  // bytes: 1, 2 or 4
  // Stored as the difference to the record before.
  bool is_delta = false;
};

// The fields of records of one kind, without gaps. None: nothing is packed.
using RecordFields = std::vector<PackedField>;

// `count` fields alike.
RecordFields FieldsAlike(size_t count, PackedField field);

// A packed section, or nothing where that is no shorter than the section, or
// where it is not a whole number of records. A function of its arguments and of
// the version of zstd.
std::string PackRecords(absl::string_view section, const RecordFields& fields);
// The same of the nodes of trees, one tree behind the other (Node): children's
// places follow from the order of the nodes. Where modes do not follow each
// other as leaves do, they are packed as records.
std::string PackNodes(absl::string_view section);

// What it takes unpacked. DATA_LOSS unless that is at most 32 times as much as
// `packed`, and 1 MiB: sections that could be shorter are not packed, so nobody
// can ask for much memory with a short file.
absl::StatusOr<uint64_t> UnpackedBytes(absl::string_view packed);

// `out` has UnpackedBytes(packed) bytes. DATA_LOSS: not what Pack... gives.
// RESOURCE_EXHAUSTED: no memory for as much again. Safe on hostile bytes.
absl::Status UnpackSection(absl::string_view packed, std::span<uint8_t> out);

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_SECTION_PACKING_H_
