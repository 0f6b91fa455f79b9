#include "common/mcap/mcap_writer.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/mcap/mcap_format.h"

namespace treeline::mcap {
namespace {

// "sensor_msgs/msg/LaserScan" and so on are what ros2msg schemas are called.
std::string SchemaRecord(uint16_t id, const std::string& name,
                         const std::string& text) {
  std::string content;
  Put(content, id);
  PutText(content, name);
  PutText(content, "ros2msg");
  PutText(content, text);
  std::string record;
  PutRecord(record, Opcode::kSchema, content);
  return record;
}

std::string ChannelRecord(uint16_t id, const std::string& topic) {
  std::string content;
  Put(content, id);
  Put(content, id);
  PutText(content, topic);
  PutText(content, "cdr");
  PutText(content, "");  // no metadata
  std::string record;
  PutRecord(record, Opcode::kChannel, content);
  return record;
}

}  // namespace

absl::StatusOr<std::unique_ptr<McapWriter>> McapWriter::Open(
    const std::string& path, const McapWriterOptions& options) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) {
    return absl::UnavailableError(absl::StrCat("cannot write ", path));
  }
  auto writer =
      absl::WrapUnique(new McapWriter(std::move(file), path, options));
  std::string content;
  PutText(content, options.profile);
  PutText(content, absl::StrCat("treeline ", base::Version()));
  std::string begin(kMagic, kMagicBytes);
  PutRecord(begin, Opcode::kHeader, content);
  TL_RETURN_IF_ERROR(writer->Append(begin));
  return writer;
}

McapWriter::McapWriter(std::ofstream file, std::string path,
                       const McapWriterOptions& options)
    : file_(std::move(file)), path_(std::move(path)), options_(options) {}

absl::Status McapWriter::Append(const std::string& bytes) {
  file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file_) {
    return absl::UnavailableError(
        absl::StrCat("cannot write ", path_, ": is the disk full?"));
  }
  at_ += bytes.size();
  return absl::OkStatus();
}

uint16_t McapWriter::AddChannel(const std::string& topic,
                                const std::string& message_name,
                                const std::string& schema_text) {
  const auto id = static_cast<uint16_t>(channels_.size() + 1);
  Channel channel;
  channel.schema_record = SchemaRecord(id, message_name, schema_text);
  channel.channel_record = ChannelRecord(id, topic);
  channels_.push_back(std::move(channel));
  return id;
}

absl::Status McapWriter::Write(uint16_t channel, uint64_t log_time_ns,
                               std::span<const uint8_t> bytes) {
  Channel& of = channels_.at(channel - size_t{1});
  // Before its first message, wherever a reader begins.
  if (!of.is_written) {
    chunk_ += of.schema_record;
    chunk_ += of.channel_record;
    of.is_written = true;
  }
  chunk_first_ns_ = std::min(chunk_first_ns_, log_time_ns);
  chunk_last_ns_ = std::max(chunk_last_ns_, log_time_ns);
  of.index.emplace_back(log_time_ns, chunk_.size());
  std::string head;
  Put(head, channel);
  Put(head, of.messages++);
  Put(head, log_time_ns);
  Put(head, log_time_ns);
  Put(chunk_, Opcode::kMessage);
  Put(chunk_, static_cast<uint64_t>(head.size() + bytes.size()));
  chunk_ += head;
  chunk_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  ++messages_;
  return chunk_.size() >= options_.chunk_bytes ? CloseChunk()
                                               : absl::OkStatus();
}

absl::Status McapWriter::CloseChunk() {
  if (chunk_.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string packed,
                      Compress(options_.compression, chunk_));
  ChunkIndex index = {.first_ns = chunk_first_ns_,
                      .last_ns = chunk_last_ns_,
                      .at = at_,
                      .index_at = {},
                      .compressed = packed.size(),
                      .uncompressed = chunk_.size()};
  std::string content;
  Put(content, chunk_first_ns_);
  Put(content, chunk_last_ns_);
  Put(content, static_cast<uint64_t>(chunk_.size()));
  Put(content, Crc32(chunk_));
  PutText(content, CompressionName(options_.compression));
  Put(content, static_cast<uint64_t>(packed.size()));
  content += packed;
  std::string record;
  PutRecord(record, Opcode::kChunk, content);
  TL_RETURN_IF_ERROR(Append(record));
  index.bytes = record.size();
  for (size_t i = 0; i < channels_.size(); ++i) {
    Channel& channel = channels_[i];
    if (channel.index.empty()) continue;
    const auto id = static_cast<uint16_t>(i + 1);
    index.index_at[id] = at_;
    std::string entries;
    Put(entries, id);
    Put(entries, static_cast<uint32_t>(16 * channel.index.size()));
    for (const auto& [time_ns, offset] : channel.index) {
      Put(entries, time_ns);
      Put(entries, offset);
    }
    channel.index.clear();
    record.clear();
    PutRecord(record, Opcode::kMessageIndex, entries);
    TL_RETURN_IF_ERROR(Append(record));
    index.index_bytes += record.size();
  }
  chunks_.push_back(std::move(index));
  chunk_.clear();
  chunk_first_ns_ = UINT64_MAX;
  chunk_last_ns_ = 0;
  return absl::OkStatus();
}

std::string McapWriter::Summary(uint64_t at) const {
  std::string summary;
  std::string offsets;
  // A group of records of one kind.
  const auto group = [&](Opcode opcode, const auto& write) {
    const size_t before = summary.size();
    write();
    if (summary.size() == before) return;
    std::string content;
    Put(content, opcode);
    Put(content, at + before);
    Put(content, static_cast<uint64_t>(summary.size() - before));
    PutRecord(offsets, Opcode::kSummaryOffset, content);
  };
  group(Opcode::kSchema, [&] {
    for (const Channel& channel : channels_) summary += channel.schema_record;
  });
  group(Opcode::kChannel, [&] {
    for (const Channel& channel : channels_) summary += channel.channel_record;
  });
  group(Opcode::kStatistics, [&] {
    std::string content;
    Put(content, messages_);
    Put(content, static_cast<uint16_t>(channels_.size()));
    Put(content, static_cast<uint32_t>(channels_.size()));
    Put(content, uint32_t{0});  // attachments
    Put(content, uint32_t{0});  // metadata
    Put(content, static_cast<uint32_t>(chunks_.size()));
    uint64_t first_ns = chunks_.empty() ? 0 : UINT64_MAX;
    uint64_t last_ns = 0;
    for (const ChunkIndex& chunk : chunks_) {
      first_ns = std::min(first_ns, chunk.first_ns);
      last_ns = std::max(last_ns, chunk.last_ns);
    }
    Put(content, first_ns);
    Put(content, last_ns);
    Put(content, static_cast<uint32_t>(10 * channels_.size()));
    for (size_t i = 0; i < channels_.size(); ++i) {
      Put(content, static_cast<uint16_t>(i + 1));
      Put(content, uint64_t{channels_[i].messages});
    }
    PutRecord(summary, Opcode::kStatistics, content);
  });
  group(Opcode::kChunkIndex, [&] {
    for (const ChunkIndex& chunk : chunks_) {
      std::string content;
      Put(content, chunk.first_ns);
      Put(content, chunk.last_ns);
      Put(content, chunk.at);
      Put(content, chunk.bytes);
      Put(content, static_cast<uint32_t>(10 * chunk.index_at.size()));
      for (const auto& [id, index_at] : chunk.index_at) {
        Put(content, id);
        Put(content, index_at);
      }
      Put(content, chunk.index_bytes);
      PutText(content, CompressionName(options_.compression));
      Put(content, chunk.compressed);
      Put(content, chunk.uncompressed);
      PutRecord(summary, Opcode::kChunkIndex, content);
    }
  });
  const uint64_t offsets_at = at + summary.size();
  summary += offsets;
  // The checksum is of all of this, and of the footer as far as to itself.
  Put(summary, Opcode::kFooter);
  Put(summary, uint64_t{8 + 8 + 4});
  Put(summary, at);
  Put(summary, offsets_at);
  Put(summary, Crc32(summary));
  summary.append(kMagic, kMagicBytes);
  return summary;
}

absl::Status McapWriter::Close() {
  TL_RETURN_IF_ERROR(CloseChunk());
  std::string content;
  Put(content, uint32_t{0});  // no checksum of the whole file
  std::string record;
  PutRecord(record, Opcode::kDataEnd, content);
  TL_RETURN_IF_ERROR(Append(record));
  TL_RETURN_IF_ERROR(Append(Summary(at_)));
  file_.close();
  if (!file_) {
    return absl::UnavailableError(
        absl::StrCat("cannot write ", path_, ": is the disk full?"));
  }
  return absl::OkStatus();
}

}  // namespace treeline::mcap
