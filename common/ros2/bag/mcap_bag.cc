#include "common/ros2/bag/mcap_bag.h"

#include <limits>
#include <map>
#include <utility>

#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/mcap/mcap_reader.h"

namespace treeline::bag {
namespace {

std::span<const uint8_t> BytesOf(absl::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

Serialization SerializationOf(const mcap::McapChannel& channel) {
  if (channel.message_encoding == "cdr") return Serialization::kCdr;
  return channel.message_encoding == "ros1" ? Serialization::kRos1
                                            : Serialization::kOther;
}

class McapBag final : public Bag {
 public:
  McapBag(base::MappedFile file, std::string path, mcap::McapReader reader)
      : file_(std::move(file)),
        path_(std::move(path)),
        reader_(std::move(reader)) {
    for (const auto& [id, channel] : reader_.channels()) {
      topic_of_channel_[id] =
          AddTopic({channel.topic, Ros2TypeName(channel.schema_name),
                    SerializationOf(channel)});
    }
  }

  bool is_closed() const override { return reader_.is_closed(); }

  absl::Status Read(const TakeMessage& take) override {
    absl::Status taken;
    const absl::Status status = reader_.Read(
        0, std::numeric_limits<uint64_t>::max(),
        [&](const mcap::McapMessage& message) {
          const auto topic = topic_of_channel_.find(message.channel);
          // Nothing says what it is.
          if (topic == topic_of_channel_.end()) return absl::OkStatus();
          taken = take({.topic = topic->second,
                        .time_ns = static_cast<int64_t>(message.log_time_ns),
                        .bytes = BytesOf(message.bytes),
                        .place = {.file = 0,
                                  .chunk = message.place.chunk,
                                  .offset = message.place.offset}});
          return taken;
        });
    return taken.ok() ? base::Annotate(status, path_) : taken;
  }

  absl::StatusOr<std::span<const uint8_t>> Fetch(
      const BagPlace& place) override {
    const auto message =
        reader_.Fetch({.chunk = place.chunk, .offset = place.offset});
    if (!message.ok()) return base::Annotate(message.status(), path_);
    return BytesOf(message->bytes);
  }

 private:
  // Behind the reader's bytes.
  const base::MappedFile file_;
  const std::string path_;
  mcap::McapReader reader_;
  std::map<uint16_t, size_t> topic_of_channel_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Bag>> OpenMcapBag(const std::string& path) {
  TL_ASSIGN_OR_RETURN(base::MappedFile file, base::MappedFile::Open(path));
  auto reader = mcap::McapReader::Open(
      {reinterpret_cast<const char*>(file.data()), file.size()});
  if (!reader.ok()) return base::Annotate(reader.status(), path);
  return std::make_unique<McapBag>(std::move(file), path, *std::move(reader));
}

}  // namespace treeline::bag
