// Reads MCAP, by its summary where there is one, else from the beginning to
// where it breaks off.
#ifndef COMMON_MCAP_MCAP_READER_H_
#define COMMON_MCAP_MCAP_READER_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::mcap {

// Larger chunks are refused: writers make them of one or a few megabytes.
inline constexpr uint64_t kMaxMcapChunk_bytes = uint64_t{256} << 20;

struct McapChannel {
  std::string topic;
  // "cdr"; bytes of other encodings are handed over as they are.
  std::string message_encoding;
  // "sensor_msgs/msg/LaserScan", "ros2msg" and its text.
  std::string schema_name;
  std::string schema_encoding;
  std::string schema_text;
};

// Where a message is, for reading it again.
struct McapPlace {
  // kInNoChunk: the offset is of the file.
  static constexpr uint32_t kInNoChunk = UINT32_MAX;
  uint32_t chunk = 0;
  uint64_t offset = 0;
};

struct McapMessage {
  uint16_t channel = 0;
  uint32_t sequence = 0;
  uint64_t log_time_ns = 0;
  uint64_t publish_time_ns = 0;
  // Valid during the call that hands it over, or until the next Fetch.
  absl::string_view bytes;
  McapPlace place;
};

// Safe on any bytes: a chunk is at most kMaxMcapChunk_bytes, and no more is
// allocated than it unpacks to. Errors name the byte of the file. Not
// thread-safe.
class McapReader {
 public:
  // `bytes` are the file and must outlive the reader. DATA_LOSS: it is none.
  static absl::StatusOr<McapReader> Open(absl::string_view bytes);

  // By id; without a summary, those that came before the file breaks off.
  const std::map<uint16_t, McapChannel>& channels() const { return channels_; }
  // The file was closed by its writer, and its summary is whole.
  bool has_summary() const { return has_summary_; }
  // It ends as files do that their writer closed, with a summary or without.
  bool is_closed() const;
  size_t chunks() const { return chunks_.size(); }

  // Hands over the messages with from_ns <= log time < to_ns, in the order of
  // the file; chunks that hold none are not unpacked. DATA_LOSS for a chunk
  // that is broken; what `take` returns, if it is an error.
  absl::Status Read(
      uint64_t from_ns, uint64_t to_ns,
      const std::function<absl::Status(const McapMessage&)>& take);

  // The message at a place that Read has told. The chunks of the last two
  // calls stay unpacked, so that topics may be read side by side. DATA_LOSS as
  // of Read; OUT_OF_RANGE for any other place.
  absl::StatusOr<McapMessage> Fetch(const McapPlace& place);

 private:
  struct Chunk {
    // Of its record in the file.
    uint64_t at = 0;
    uint64_t first_ns = 0;
    uint64_t last_ns = 0;
    // The content of its record.
    absl::string_view content;
  };
  struct Schema {
    std::string name;
    std::string encoding;
    std::string text;
  };

  explicit McapReader(absl::string_view bytes) : bytes_(bytes) {}
  bool ReadSummary();
  // Also messages that are in no chunk.
  void Scan();
  // A schema or channel; false: the record is broken.
  bool Learn(uint8_t opcode, absl::string_view content);
  absl::Status Unpack(const Chunk& chunk, std::string& records) const;
  // Of a message's record.
  absl::StatusOr<McapMessage> MessageIn(absl::string_view content,
                                        const McapPlace& place) const;
  absl::Status ErrorAt(uint64_t at, absl::string_view what) const;

  absl::string_view bytes_;
  bool has_summary_ = false;
  std::map<uint16_t, Schema> schemas_;
  std::map<uint16_t, McapChannel> channels_;
  std::vector<Chunk> chunks_;
  // Messages outside of chunks: offsets of their records.
  std::vector<uint64_t> loose_;
  struct Unpacked {
    uint32_t chunk = McapPlace::kInNoChunk;
    std::string records;
  };
  // The one used last stands in front.
  std::array<Unpacked, 2> unpacked_;
};

}  // namespace treeline::mcap

#endif  // COMMON_MCAP_MCAP_READER_H_
