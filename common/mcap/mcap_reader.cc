#include "common/mcap/mcap_reader.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/mcap/mcap_compression.h"
#include "common/mcap/mcap_format.h"

namespace treeline::mcap {
namespace {

// Larger chunks are refused: writers make them of one or a few megabytes.
constexpr uint64_t kMaxChunk = uint64_t{256} << 20;
constexpr size_t kFooterBytes = kRecordHead + 20 + kMagicBytes;

struct Record {
  uint8_t opcode = 0;
  absl::string_view content;
};

// False at the end, and where a record is cut off.
bool NextRecord(Cursor& cursor, Record& record) {
  record.opcode = cursor.Get<uint8_t>();
  record.content = cursor.GetBytes(cursor.Get<uint64_t>());
  return cursor.is_good;
}

McapMessage MessageOf(absl::string_view content, bool& is_good) {
  Cursor cursor = {.left = content};
  McapMessage message;
  message.channel = cursor.Get<uint16_t>();
  message.sequence = cursor.Get<uint32_t>();
  message.log_time_ns = cursor.Get<uint64_t>();
  message.publish_time_ns = cursor.Get<uint64_t>();
  message.bytes = cursor.left;
  is_good = cursor.is_good;
  return message;
}

bool Is(uint8_t opcode, Opcode kind) {
  return opcode == static_cast<uint8_t>(kind);
}

}  // namespace

absl::StatusOr<McapReader> McapReader::Open(absl::string_view bytes) {
  const absl::string_view magic(kMagic, kMagicBytes);
  if (bytes.substr(0, kMagicBytes) != magic) {
    return absl::DataLossError("this is no MCAP file");
  }
  McapReader reader(bytes);
  reader.has_summary_ = reader.ReadSummary();
  if (!reader.has_summary_) TL_RETURN_IF_ERROR(reader.Scan());
  return reader;
}

bool McapReader::ReadSummary() {
  if (bytes_.size() < kMagicBytes + kFooterBytes ||
      bytes_.substr(bytes_.size() - kMagicBytes) !=
          absl::string_view(kMagic, kMagicBytes)) {
    return false;
  }
  Cursor footer = {.left = bytes_.substr(bytes_.size() - kFooterBytes)};
  Record record;
  if (!NextRecord(footer, record) || !Is(record.opcode, Opcode::kFooter)) {
    return false;
  }
  Cursor content = {.left = record.content};
  const auto summary_at = content.Get<uint64_t>();
  content.Get<uint64_t>();
  const auto crc = content.Get<uint32_t>();
  const uint64_t end = bytes_.size() - kFooterBytes;
  if (summary_at == 0 || summary_at > end) return false;
  // As far as to the checksum itself.
  if (crc != 0 &&
      crc != Crc32(bytes_.substr(summary_at,
                                 end - summary_at + kRecordHead + 16))) {
    return false;
  }
  Cursor summary = {.left = bytes_.substr(summary_at, end - summary_at)};
  bool is_whole = true;
  uint64_t messages = 0;
  while (NextRecord(summary, record)) {
    if (Is(record.opcode, Opcode::kStatistics)) {
      messages = Cursor{.left = record.content}.Get<uint64_t>();
    }
    if (!Is(record.opcode, Opcode::kChunkIndex)) {
      is_whole &= Learn(record.opcode, record.content);
      continue;
    }
    Cursor index = {.left = record.content};
    Chunk chunk;
    chunk.first_ns = index.Get<uint64_t>();
    chunk.last_ns = index.Get<uint64_t>();
    const auto at = index.Get<uint64_t>();
    const auto size = index.Get<uint64_t>();
    if (!index.is_good || at > bytes_.size() || size > bytes_.size() - at) {
      is_whole = false;
      break;
    }
    Cursor place = {.left = bytes_.substr(at, size)};
    Record found;
    is_whole &= NextRecord(place, found) && Is(found.opcode, Opcode::kChunk);
    chunk.content = found.content;
    chunks_.push_back(chunk);
  }
  // Messages in no chunk are not in the summary; then all must be read.
  if (is_whole && !(chunks_.empty() && messages > 0)) return true;
  chunks_.clear();
  channels_.clear();
  schemas_.clear();
  return false;
}

absl::Status McapReader::Scan() {
  Cursor cursor = {.left = bytes_.substr(kMagicBytes)};
  Record record;
  while (NextRecord(cursor, record) && !Is(record.opcode, Opcode::kDataEnd)) {
    if (Is(record.opcode, Opcode::kMessage)) loose_.push_back(record.content);
    Learn(record.opcode, record.content);
    if (!Is(record.opcode, Opcode::kChunk)) continue;
    Cursor head = {.left = record.content};
    Chunk chunk;
    chunk.first_ns = head.Get<uint64_t>();
    chunk.last_ns = head.Get<uint64_t>();
    chunk.content = record.content;
    std::string records;
    // What is broken is told when it is read.
    if (Unpack(chunk, records).ok()) {
      Cursor inside = {.left = records};
      Record inner;
      while (NextRecord(inside, inner)) Learn(inner.opcode, inner.content);
    }
    chunks_.push_back(chunk);
  }
  return absl::OkStatus();
}

bool McapReader::Learn(uint8_t opcode, absl::string_view content) {
  Cursor cursor = {.left = content};
  if (Is(opcode, Opcode::kSchema)) {
    const auto id = cursor.Get<uint16_t>();
    Schema schema;
    schema.name = std::string(cursor.GetText());
    schema.encoding = std::string(cursor.GetText());
    schema.text = std::string(cursor.GetText());
    if (cursor.is_good) schemas_[id] = std::move(schema);
  } else if (Is(opcode, Opcode::kChannel)) {
    const auto id = cursor.Get<uint16_t>();
    const auto schema_id = cursor.Get<uint16_t>();
    McapChannel channel;
    channel.topic = std::string(cursor.GetText());
    channel.message_encoding = std::string(cursor.GetText());
    if (const auto schema = schemas_.find(schema_id);
        schema != schemas_.end()) {
      channel.schema_name = schema->second.name;
      channel.schema_encoding = schema->second.encoding;
      channel.schema_text = schema->second.text;
    }
    if (cursor.is_good) channels_[id] = std::move(channel);
  }
  return cursor.is_good;
}

absl::Status McapReader::Unpack(const Chunk& chunk,
                                std::string& records) const {
  Cursor cursor = {.left = chunk.content};
  cursor.GetBytes(16);
  const auto size = cursor.Get<uint64_t>();
  const auto crc = cursor.Get<uint32_t>();
  const absl::string_view name = cursor.GetText();
  const absl::string_view packed = cursor.GetBytes(cursor.Get<uint64_t>());
  if (!cursor.is_good) return absl::DataLossError("a chunk of MCAP is cut off");
  if (size > kMaxChunk) {
    return absl::DataLossError(absl::StrCat("a chunk of MCAP of ", size,
                                            " bytes; at most ", kMaxChunk,
                                            " are read"));
  }
  TL_ASSIGN_OR_RETURN(const Compression compression, ParseCompression(name));
  TL_ASSIGN_OR_RETURN(records, Decompress(compression, packed, size));
  if (crc != 0 && crc != Crc32(records)) {
    return absl::DataLossError("a chunk of MCAP does not have its checksum");
  }
  return absl::OkStatus();
}

absl::Status McapReader::Read(
    uint64_t from_ns, uint64_t to_ns,
    const std::function<absl::Status(const McapMessage&)>& take) {
  const auto hand_over = [&](absl::string_view content) -> absl::Status {
    bool is_good = true;
    const McapMessage message = MessageOf(content, is_good);
    if (!is_good) return absl::DataLossError("a message of MCAP is cut off");
    if (message.log_time_ns < from_ns || message.log_time_ns >= to_ns) {
      return absl::OkStatus();
    }
    return take(message);
  };
  for (const absl::string_view content : loose_) {
    TL_RETURN_IF_ERROR(hand_over(content));
  }
  std::string records;
  for (const Chunk& chunk : chunks_) {
    if (chunk.last_ns < from_ns || chunk.first_ns >= to_ns) continue;
    TL_RETURN_IF_ERROR(Unpack(chunk, records));
    Cursor cursor = {.left = records};
    Record record;
    while (NextRecord(cursor, record)) {
      if (!Is(record.opcode, Opcode::kMessage)) continue;
      TL_RETURN_IF_ERROR(hand_over(record.content));
    }
  }
  return absl::OkStatus();
}

}  // namespace treeline::mcap
