#include "common/mcap/mcap_reader.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/mcap/mcap_compression.h"
#include "common/mcap/mcap_format.h"

namespace treeline::mcap {
namespace {

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

bool Is(uint8_t opcode, Opcode kind) {
  return opcode == static_cast<uint8_t>(kind);
}

}  // namespace

absl::StatusOr<McapReader> McapReader::Open(absl::string_view bytes) {
  const absl::string_view magic(kMagic, kMagicBytes);
  if (bytes.substr(0, kMagicBytes) != magic) {
    return absl::DataLossError(
        "this is no MCAP file: it does not begin as one");
  }
  McapReader reader(bytes);
  reader.has_summary_ = reader.ReadSummary();
  if (!reader.has_summary_) reader.Scan();
  return reader;
}

bool McapReader::is_closed() const {
  return bytes_.size() >= kMagicBytes + kFooterBytes &&
         bytes_.substr(bytes_.size() - kMagicBytes) ==
             absl::string_view(kMagic, kMagicBytes);
}

bool McapReader::ReadSummary() {
  if (!is_closed()) return false;
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
    chunk.at = index.Get<uint64_t>();
    const auto size = index.Get<uint64_t>();
    if (!index.is_good || chunk.at > bytes_.size() ||
        size > bytes_.size() - chunk.at) {
      is_whole = false;
      break;
    }
    Cursor place = {.left = bytes_.substr(chunk.at, size)};
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

void McapReader::Scan() {
  Cursor cursor = {.left = bytes_.substr(kMagicBytes)};
  Record record;
  while (true) {
    const uint64_t at = bytes_.size() - cursor.left.size();
    if (!NextRecord(cursor, record) || Is(record.opcode, Opcode::kDataEnd)) {
      return;
    }
    if (Is(record.opcode, Opcode::kMessage)) loose_.push_back(at);
    Learn(record.opcode, record.content);
    if (!Is(record.opcode, Opcode::kChunk)) continue;
    Cursor head = {.left = record.content};
    Chunk chunk;
    chunk.at = at;
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
  if (!cursor.is_good) return ErrorAt(chunk.at, "a chunk is cut off");
  if (size > kMaxMcapChunk_bytes) {
    return ErrorAt(chunk.at,
                   absl::StrCat("a chunk of ", size, " bytes; at most ",
                                kMaxMcapChunk_bytes, " are read"));
  }
  const auto compression = ParseCompression(name);
  if (!compression.ok()) {
    return ErrorAt(chunk.at, compression.status().message());
  }
  auto unpacked = Decompress(*compression, packed, size);
  if (!unpacked.ok()) return ErrorAt(chunk.at, unpacked.status().message());
  records = *std::move(unpacked);
  if (crc != 0 && crc != Crc32(records)) {
    return ErrorAt(chunk.at, "a chunk does not have its checksum");
  }
  return absl::OkStatus();
}

absl::Status McapReader::ErrorAt(uint64_t at, absl::string_view what) const {
  return absl::DataLossError(
      absl::StrCat("MCAP: at byte ", at, " of ", bytes_.size(), ": ", what));
}

absl::StatusOr<McapMessage> McapReader::MessageIn(
    absl::string_view content, const McapPlace& place) const {
  Cursor cursor = {.left = content};
  McapMessage message;
  message.channel = cursor.Get<uint16_t>();
  message.sequence = cursor.Get<uint32_t>();
  message.log_time_ns = cursor.Get<uint64_t>();
  message.publish_time_ns = cursor.Get<uint64_t>();
  message.bytes = cursor.left;
  message.place = place;
  if (cursor.is_good) return message;
  const bool is_loose = place.chunk == McapPlace::kInNoChunk;
  return ErrorAt(is_loose ? place.offset : chunks_[place.chunk].at,
                 "a message is cut off");
}

absl::Status McapReader::Read(
    uint64_t from_ns, uint64_t to_ns,
    const std::function<absl::Status(const McapMessage&)>& take) {
  const auto hand_over = [&](absl::string_view content,
                             const McapPlace& place) -> absl::Status {
    TL_ASSIGN_OR_RETURN(const McapMessage message, MessageIn(content, place));
    if (message.log_time_ns < from_ns || message.log_time_ns >= to_ns) {
      return absl::OkStatus();
    }
    return take(message);
  };
  for (const uint64_t at : loose_) {
    Cursor cursor = {.left = bytes_.substr(at)};
    Record record;
    NextRecord(cursor, record);
    TL_RETURN_IF_ERROR(hand_over(record.content, {McapPlace::kInNoChunk, at}));
  }
  std::string records;
  for (uint32_t i = 0; i < chunks_.size(); ++i) {
    const Chunk& chunk = chunks_[i];
    if (chunk.last_ns < from_ns || chunk.first_ns >= to_ns) continue;
    TL_RETURN_IF_ERROR(Unpack(chunk, records));
    Cursor cursor = {.left = records};
    Record record;
    while (!cursor.left.empty()) {
      const uint64_t offset = records.size() - cursor.left.size();
      if (!NextRecord(cursor, record)) {
        return ErrorAt(chunk.at, absl::StrCat("a record at byte ", offset,
                                              " of a chunk is cut off"));
      }
      if (!Is(record.opcode, Opcode::kMessage)) continue;
      TL_RETURN_IF_ERROR(hand_over(record.content, {i, offset}));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<McapMessage> McapReader::Fetch(const McapPlace& place) {
  absl::string_view records = bytes_;
  if (place.chunk != McapPlace::kInNoChunk) {
    if (place.chunk >= chunks_.size()) {
      return absl::OutOfRangeError("MCAP: no such chunk");
    }
    if (unpacked_[0].chunk != place.chunk) {
      std::swap(unpacked_[0], unpacked_[1]);
    }
    if (unpacked_[0].chunk != place.chunk) {
      unpacked_[0].chunk = McapPlace::kInNoChunk;
      TL_RETURN_IF_ERROR(Unpack(chunks_[place.chunk], unpacked_[0].records));
      unpacked_[0].chunk = place.chunk;
    }
    records = unpacked_[0].records;
  }
  if (place.offset > records.size()) {
    return absl::OutOfRangeError("MCAP: no such message");
  }
  Cursor cursor = {.left = records.substr(place.offset)};
  Record record;
  if (!NextRecord(cursor, record) || !Is(record.opcode, Opcode::kMessage)) {
    return absl::OutOfRangeError("MCAP: no message is there");
  }
  return MessageIn(record.content, place);
}

}  // namespace treeline::mcap
