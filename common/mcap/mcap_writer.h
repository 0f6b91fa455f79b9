// Writes MCAP: chunks that are compressed, an index of messages behind each,
// and a summary at the end by which readers find their way.
#ifndef COMMON_MCAP_MCAP_WRITER_H_
#define COMMON_MCAP_MCAP_WRITER_H_

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/mcap/mcap_compression.h"

namespace treeline::mcap {

struct McapWriterOptions {
  Compression compression = Compression::kZstd;
  // A chunk is closed once it holds so much (bytes, at least 1).
  size_t chunk_bytes = size_t{1} << 20;
  // "ros2" makes tools of ROS 2 read it as one of their bags.
  std::string profile = "ros2";
};

// Not thread-safe.
class McapWriter {
 public:
  // Begins a file anew. UNAVAILABLE with the reason.
  static absl::StatusOr<std::unique_ptr<McapWriter>> Open(
      const std::string& path, const McapWriterOptions& options);

  // Messages of a topic: in CDR, by a schema in "ros2msg". At most 65535.
  uint16_t AddChannel(const std::string& topic, const std::string& message_name,
                      const std::string& schema_text);
  // `bytes` are CDR with their encoding in front. Times: ns since 1970 or of
  // any other beginning. UNAVAILABLE: the disk is full.
  absl::Status Write(uint16_t channel, uint64_t log_time_ns,
                     std::span<const uint8_t> bytes);
  // Writes what waits and the summary; nothing may follow. A file that was not
  // closed is read without one.
  absl::Status Close();

 private:
  struct Channel {
    std::string schema_record;
    std::string channel_record;
    bool is_written = false;
    uint32_t messages = 0;
    // Time and place in the chunk.
    std::vector<std::pair<uint64_t, uint64_t>> index;
  };
  struct ChunkIndex {
    uint64_t first_ns = 0;
    uint64_t last_ns = 0;
    uint64_t at = 0;
    uint64_t bytes = 0;
    std::map<uint16_t, uint64_t> index_at;
    uint64_t index_bytes = 0;
    uint64_t compressed = 0;
    uint64_t uncompressed = 0;
  };

  McapWriter(std::ofstream file, std::string path,
             const McapWriterOptions& options);
  absl::Status Append(const std::string& bytes);
  absl::Status CloseChunk();
  std::string Summary(uint64_t at) const;

  std::ofstream file_;
  const std::string path_;
  const McapWriterOptions options_;
  uint64_t at_ = 0;
  // The id of a channel, and of its schema, is its place here plus one.
  std::vector<Channel> channels_;
  std::string chunk_;
  uint64_t chunk_first_ns_ = UINT64_MAX;
  uint64_t chunk_last_ns_ = 0;
  std::vector<ChunkIndex> chunks_;
  uint64_t messages_ = 0;
};

}  // namespace treeline::mcap

#endif  // COMMON_MCAP_MCAP_WRITER_H_
