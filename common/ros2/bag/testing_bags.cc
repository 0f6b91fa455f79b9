#include "common/ros2/bag/testing_bags.h"

#include <bzlib.h>
#include <sqlite3.h>

#include <cstdlib>
#include <filesystem>
#include <map>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "common/mcap/mcap_compression.h"
#include "common/mcap/mcap_writer.h"

namespace treeline::bag {
namespace {

// Of a chunk, so that a bag has several.
constexpr size_t kChunk_bytes = 20'000;

void Must(bool is_good) {
  if (!is_good) std::abort();
}

std::string Text(const std::vector<uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

template <typename T>
std::string Raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof(T)};
}
std::string Sized(const std::string& text) {
  return Raw(static_cast<uint32_t>(text.size())) + text;
}

struct Fields {
  std::string bytes;
  Fields& Add(const std::string& name, const std::string& value) {
    bytes += Sized(absl::StrCat(name, "=", value));
    return *this;
  }
};
std::string Record(uint8_t op, const Fields& fields, const std::string& data) {
  return Sized(Fields().Add("op", Raw(op)).bytes + fields.bytes) + Sized(data);
}

std::string Packed(const std::string& bytes, const std::string& packing) {
  if (packing == "none") return bytes;
  if (packing == "lz4") {
    return mcap::Compress(mcap::Compression::kLz4, bytes).value();
  }
  std::string packed(bytes.size() + bytes.size() / 100 + 600, 0);
  auto size = static_cast<unsigned>(packed.size());
  Must(BZ2_bzBuffToBuffCompress(
           packed.data(), &size, const_cast<char*>(bytes.data()),
           static_cast<unsigned>(bytes.size()), 9, 0, 0) == BZ_OK);
  packed.resize(size);
  return packed;
}

// A connection's record: the same in chunks and at the end.
std::string Connection(uint32_t id, const TestingMessage& message) {
  return Record(
      7, Fields().Add("conn", Raw(id)).Add("topic", message.topic),
      Fields()
          .Add("topic", message.topic)
          .Add("type", absl::StrReplaceAll(message.type, {{"/msg/", "/"}}))
          .Add("md5sum", "*")
          .Add("message_definition", message.schema)
          .bytes);
}

}  // namespace

void WriteMcapBag(const std::vector<TestingMessage>& messages,
                  const std::string& packing, const std::string& path) {
  auto writer = mcap::McapWriter::Open(
      path, {.compression = mcap::ParseCompression(packing).value(),
             .chunk_bytes = kChunk_bytes});
  Must(writer.ok());
  std::map<std::string, uint16_t> channels;
  for (const TestingMessage& message : messages) {
    if (channels.count(message.topic) == 0) {
      channels[message.topic] =
          (*writer)->AddChannel(message.topic, message.type, message.schema);
    }
    Must((*writer)
             ->Write(channels[message.topic],
                     static_cast<uint64_t>(message.time_ns), message.cdr)
             .ok());
  }
  Must((*writer)->Close().ok());
}

void WriteSqliteBag(const std::vector<TestingMessage>& messages,
                    const std::string& path) {
  sqlite3* database = nullptr;
  Must(sqlite3_open(path.c_str(), &database) == SQLITE_OK);
  const auto run = [&](const std::string& sql) {
    Must(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) ==
         SQLITE_OK);
  };
  // As rosbag2_storage_default_plugins creates them.
  run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type "
      "TEXT NOT NULL, serialization_format TEXT NOT NULL, offered_qos_profiles "
      "TEXT NOT NULL); CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id "
      "INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL); "
      "CREATE INDEX timestamp_idx ON messages (timestamp ASC); BEGIN;");
  sqlite3_stmt* insert = nullptr;
  Must(sqlite3_prepare_v2(
           database,
           "INSERT INTO messages (timestamp, topic_id, data) VALUES (?, ?, ?)",
           -1, &insert, nullptr) == SQLITE_OK);
  std::map<std::string, int> ids;
  for (const TestingMessage& message : messages) {
    if (ids.count(message.topic) == 0) {
      const int id = static_cast<int>(ids.size()) + 1;
      ids[message.topic] = id;
      run(absl::StrCat("INSERT INTO topics VALUES (", id, ", '", message.topic,
                       "', '", message.type, "', 'cdr', '')"));
    }
    sqlite3_reset(insert);
    sqlite3_bind_int64(insert, 1, message.time_ns);
    sqlite3_bind_int(insert, 2, ids[message.topic]);
    sqlite3_bind_blob(insert, 3, message.cdr.data(),
                      static_cast<int>(message.cdr.size()), SQLITE_STATIC);
    Must(sqlite3_step(insert) == SQLITE_DONE);
  }
  sqlite3_finalize(insert);
  run("COMMIT");
  Must(sqlite3_close(database) == SQLITE_OK);
}

void WriteRos1Bag(const std::vector<TestingMessage>& messages,
                  const std::string& packing, bool has_index,
                  const std::string& path) {
  std::string body;
  std::string connections;
  std::string chunk;
  uint32_t chunks = 0;
  std::map<std::string, uint32_t> ids;
  const auto close = [&] {
    if (chunk.empty()) return;
    body += Record(5,
                   Fields()
                       .Add("compression", packing)
                       .Add("size", Raw(static_cast<uint32_t>(chunk.size()))),
                   Packed(chunk, packing));
    // What is said of its messages by time is read over.
    body += Record(4, Fields().Add("ver", Raw(uint32_t{1})), "");
    chunk.clear();
    ++chunks;
  };
  for (const TestingMessage& message : messages) {
    if (ids.count(message.topic) == 0) {
      const auto id = static_cast<uint32_t>(ids.size());
      ids[message.topic] = id;
      chunk += Connection(id, message);
      connections += Connection(id, message);
    }
    const auto seconds = static_cast<uint32_t>(message.time_ns / 1'000'000'000);
    const auto rest = static_cast<uint32_t>(message.time_ns % 1'000'000'000);
    chunk += Record(2,
                    Fields()
                        .Add("conn", Raw(ids[message.topic]))
                        .Add("time", Raw(seconds) + Raw(rest)),
                    Text(message.ros1));
    if (chunk.size() > kChunk_bytes) close();
  }
  close();
  const Fields header =
      Fields()
          .Add("index_pos", Raw(uint64_t{has_index ? 4117 + body.size() : 0}))
          .Add("conn_count", Raw(static_cast<uint32_t>(ids.size())))
          .Add("chunk_count", Raw(chunks));
  std::string file = "#ROSBAG V2.0\n";
  // Padded to 4096 bytes behind the first line.
  const size_t used = Record(3, header, "").size();
  file += Record(3, header, std::string(4096 - used, ' '));
  file += body;
  if (has_index) file += connections;
  Must(base::WriteNewFile(path, file).ok());
}

void WriteBagFolder(const std::vector<TestingMessage>& messages,
                    const std::string& storage, const std::string& folder) {
  std::filesystem::create_directories(folder);
  const std::string name = std::filesystem::path(folder).filename().string();
  const std::string ending = storage == "mcap" ? "mcap" : "db3";
  const auto half =
      messages.begin() + static_cast<std::ptrdiff_t>(messages.size() / 2);
  std::string files;
  for (int i = 0; i < 2; ++i) {
    const std::string file = absl::StrCat(name, "_", i, ".", ending);
    absl::StrAppend(&files, "    - ", file, "\n");
    const std::vector<TestingMessage> own(i == 0 ? messages.begin() : half,
                                          i == 0 ? half : messages.end());
    const std::string path = absl::StrCat(folder, "/", file);
    if (storage == "mcap") {
      WriteMcapBag(own, "zstd", path);
    } else {
      WriteSqliteBag(own, path);
    }
  }
  Must(base::WriteNewFile(
           folder + "/metadata.yaml",
           absl::StrCat("rosbag2_bagfile_information:\n  version: 5\n"
                        "  storage_identifier: ",
                        storage, "\n  relative_file_paths:\n", files,
                        "  duration:\n    nanoseconds: 1000\n"
                        "  message_count: ",
                        messages.size(),
                        "\n  topics_with_message_count: []\n"
                        "  compression_format: \"\"\n"
                        "  compression_mode: \"\"\n"))
           .ok());
}

}  // namespace treeline::bag
