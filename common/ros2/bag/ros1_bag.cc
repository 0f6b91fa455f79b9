#include "common/ros2/bag/ros1_bag.h"

#include <bzlib.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/mcap/mcap_compression.h"
#include "common/mcap/mcap_format.h"

namespace treeline::bag {
namespace {

using mcap::Cursor;

constexpr char kMagic[] = "#ROSBAG V2.0\n";
constexpr size_t kMagicBytes = sizeof(kMagic) - 1;
// rosbag makes them of 768 KiB.
constexpr uint32_t kMaxChunk_bytes = uint32_t{256} << 20;
constexpr size_t kFirstRoom = size_t{1} << 20;
constexpr uint32_t kNoChunk = UINT32_MAX;

enum Op : uint8_t { kMessage = 2, kBagHeader = 3, kChunk = 5, kConnection = 7 };

struct Record {
  absl::string_view header;
  absl::string_view data;

  // The value of a field; empty: it is not there.
  absl::string_view Field(absl::string_view name) const {
    Cursor cursor = {.left = header};
    while (!cursor.left.empty() && cursor.is_good) {
      const absl::string_view field = cursor.GetText();
      const size_t equals = field.find('=');
      if (equals != absl::string_view::npos &&
          field.substr(0, equals) == name) {
        return field.substr(equals + 1);
      }
    }
    return {};
  }
  template <typename T>
  std::optional<T> Number(absl::string_view name) const {
    Cursor value = {.left = Field(name)};
    const T number = value.Get<T>();
    if (!value.is_good || !value.left.empty()) return std::nullopt;
    return number;
  }
  uint8_t op() const { return Number<uint8_t>("op").value_or(0); }
};

// False at the end, and where a record is cut off.
bool NextRecord(Cursor& cursor, Record& record) {
  record.header = cursor.GetText();
  record.data = cursor.GetText();
  return cursor.is_good;
}

// Room grows with what was unpacked.
absl::StatusOr<std::string> UnpackBz2(absl::string_view packed, size_t size) {
  bz_stream stream = {};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) {
    return absl::InternalError("bz2: no context");
  }
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> closer(
      &stream, BZ2_bzDecompressEnd);
  std::string made(std::min(size, kFirstRoom), 0);
  size_t written = 0;
  // bzlib takes what it reads as not const, and does not write there.
  stream.next_in = const_cast<char*>(packed.data());
  stream.avail_in = static_cast<unsigned>(packed.size());
  while (true) {
    stream.next_out = made.data() + written;
    stream.avail_out = static_cast<unsigned>(made.size() - written);
    const int result = BZ2_bzDecompress(&stream);
    written = made.size() - stream.avail_out;
    if (result == BZ_STREAM_END) break;
    if (result != BZ_OK) return absl::DataLossError("its bz2 is broken");
    if (stream.avail_out == 0 && made.size() < size) {
      made.resize(std::min(size, 2 * made.size()));
    } else if (stream.avail_out == 0 || stream.avail_in == 0) {
      return absl::DataLossError("its bz2 ends too early, or too late");
    }
  }
  if (written != size) {
    return absl::DataLossError("it is of another size than told");
  }
  return made;
}

class Ros1Bag final : public Bag {
 public:
  Ros1Bag(base::MappedFile file, absl::string_view bytes, std::string name)
      : file_(std::move(file)), bytes_(bytes), name_(std::move(name)) {}

  absl::Status ReadChunksAndConnections() {
    Cursor cursor = {.left = bytes_.substr(kMagicBytes)};
    while (!cursor.left.empty()) {
      const uint64_t at = bytes_.size() - cursor.left.size();
      Record record;
      // A recording that was killed ends in the middle of a record.
      if (!NextRecord(cursor, record)) break;
      if (record.op() == kBagHeader && !record.Field("encryptor").empty()) {
        return absl::InvalidArgumentError(
            absl::StrCat(name_, ": is encrypted: rosbag decrypt"));
      }
      if (record.op() == kChunk) chunks_.push_back({at, record});
      if (record.op() == kConnection) AddConnection(record);
    }
    if (!topic_of_connection_.empty()) return absl::OkStatus();
    // It has no index; connections are in the chunks as well.
    std::string records;
    for (const Chunk& chunk : chunks_) {
      TL_RETURN_IF_ERROR(Unpack(chunk, records));
      Cursor inside = {.left = records};
      Record record;
      while (NextRecord(inside, record)) {
        if (record.op() == kConnection) AddConnection(record);
      }
    }
    return absl::OkStatus();
  }

  absl::Status Read(const TakeMessage& take) override {
    std::string records;
    for (uint32_t i = 0; i < chunks_.size(); ++i) {
      TL_RETURN_IF_ERROR(Unpack(chunks_[i], records));
      Cursor cursor = {.left = records};
      while (!cursor.left.empty()) {
        const uint64_t offset = records.size() - cursor.left.size();
        Record record;
        if (!NextRecord(cursor, record)) {
          return ErrorAt(chunks_[i].at, "a record of a chunk is cut off");
        }
        if (record.op() != kMessage) continue;
        const auto time = record.Number<uint64_t>("time");
        const auto topic = topic_of_connection_.find(
            record.Number<uint32_t>("conn").value_or(UINT32_MAX));
        if (!time || topic == topic_of_connection_.end()) continue;
        // Seconds, then nanoseconds.
        const auto seconds = static_cast<int64_t>(*time & 0xffffffff);
        const auto rest = static_cast<int64_t>(*time >> 32);
        TL_RETURN_IF_ERROR(
            take({.topic = topic->second,
                  .time_ns = seconds * 1'000'000'000 + rest,
                  .bytes = BytesOf(record.data),
                  .place = {.file = 0, .chunk = i, .offset = offset}}));
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::span<const uint8_t>> Fetch(
      const BagPlace& place) override {
    if (place.chunk >= chunks_.size()) {
      return absl::OutOfRangeError(absl::StrCat(name_, ": no such chunk"));
    }
    if (unpacked_[0].chunk != place.chunk) {
      std::swap(unpacked_[0], unpacked_[1]);
    }
    if (unpacked_[0].chunk != place.chunk) {
      unpacked_[0].chunk = kNoChunk;
      TL_RETURN_IF_ERROR(Unpack(chunks_[place.chunk], unpacked_[0].records));
      unpacked_[0].chunk = place.chunk;
    }
    const absl::string_view records = unpacked_[0].records;
    Record record;
    if (place.offset <= records.size()) {
      Cursor cursor = {.left = records.substr(place.offset)};
      if (NextRecord(cursor, record) && record.op() == kMessage) {
        return BytesOf(record.data);
      }
    }
    return absl::OutOfRangeError(absl::StrCat(name_, ": no such message"));
  }

 private:
  struct Chunk {
    uint64_t at = 0;
    Record record;
  };
  struct Unpacked {
    uint32_t chunk = kNoChunk;
    std::string records;
  };

  static std::span<const uint8_t> BytesOf(absl::string_view text) {
    return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
  }

  absl::Status ErrorAt(uint64_t at, absl::string_view what) const {
    return absl::DataLossError(absl::StrCat(name_, ": at byte ", at, " of ",
                                            bytes_.size(), ": ", what));
  }

  void AddConnection(const Record& record) {
    const auto id = record.Number<uint32_t>("conn");
    const Record described = {.header = record.data, .data = {}};
    const absl::string_view topic = record.Field("topic");
    if (!id || topic.empty()) return;
    topic_of_connection_[*id] =
        AddTopic({std::string(topic), Ros2TypeName(described.Field("type")),
                  Serialization::kRos1});
  }

  absl::Status Unpack(const Chunk& chunk, std::string& records) const {
    const Record& record = chunk.record;
    const uint32_t size = record.Number<uint32_t>("size").value_or(0);
    const absl::string_view packing = record.Field("compression");
    if (size > kMaxChunk_bytes) {
      return ErrorAt(chunk.at, absl::StrCat("a chunk of ", size, " bytes; ",
                                            kMaxChunk_bytes, " are read"));
    }
    if (packing == "none") {
      records.assign(record.data.data(), record.data.size());
      return absl::OkStatus();
    }
    if (packing != "bz2" && packing != "lz4") {
      return ErrorAt(chunk.at, absl::StrCat("the compression \"", packing,
                                            "\" is not known"));
    }
    auto unpacked = packing == "bz2" ? UnpackBz2(record.data, size)
                                     : mcap::Decompress(mcap::Compression::kLz4,
                                                        record.data, size);
    if (!unpacked.ok()) return ErrorAt(chunk.at, unpacked.status().message());
    records = *std::move(unpacked);
    return absl::OkStatus();
  }

  // Behind the bytes, if it was opened as a file.
  const base::MappedFile file_;
  const absl::string_view bytes_;
  const std::string name_;
  std::vector<Chunk> chunks_;
  std::map<uint32_t, size_t> topic_of_connection_;
  // The one used last stands in front.
  std::array<Unpacked, 2> unpacked_;
};

absl::StatusOr<std::unique_ptr<Bag>> Opened(base::MappedFile file,
                                            absl::string_view bytes,
                                            const std::string& name) {
  if (!absl::StartsWith(bytes, kMagic)) {
    return absl::InvalidArgumentError(absl::StrCat(
        name, ": is no bag of format 2.0: rosbag migrates older ones"));
  }
  auto bag = std::make_unique<Ros1Bag>(std::move(file), bytes, name);
  TL_RETURN_IF_ERROR(bag->ReadChunksAndConnections());
  return bag;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Bag>> OpenRos1Bag(const std::string& path) {
  TL_ASSIGN_OR_RETURN(base::MappedFile file, base::MappedFile::Open(path));
  const absl::string_view bytes(reinterpret_cast<const char*>(file.data()),
                                file.size());
  return Opened(std::move(file), bytes, path);
}

absl::StatusOr<std::unique_ptr<Bag>> ParseRos1Bag(absl::string_view bytes,
                                                  const std::string& name) {
  return Opened(base::MappedFile(), bytes, name);
}

}  // namespace treeline::bag
