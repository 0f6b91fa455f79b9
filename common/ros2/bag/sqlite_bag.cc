#include "common/ros2/bag/sqlite_bag.h"

#include <sqlite3.h>

#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"

namespace treeline::bag {
namespace {

// Of a message, or any other value.
constexpr int kMaxValue_bytes = 256 << 20;

struct Closer {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const {
    sqlite3_finalize(statement);
  }
};
using Database = std::unique_ptr<sqlite3, Closer>;
using Statement = std::unique_ptr<sqlite3_stmt, Closer>;

// Characters that mean something in a URI become %XX.
std::string UriOf(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) {
    if (absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '/' ||
        c == '.' || c == '-' || c == '_') {
      uri.push_back(c);
    } else {
      absl::StrAppendFormat(&uri, "%%%02X", static_cast<unsigned char>(c));
    }
  }
  return uri;
}

std::string TextAt(sqlite3_stmt* statement, int column) {
  const unsigned char* text = sqlite3_column_text(statement, column);
  const int bytes = sqlite3_column_bytes(statement, column);
  if (text == nullptr || bytes <= 0) return "";
  return {reinterpret_cast<const char*>(text), static_cast<size_t>(bytes)};
}

class SqliteBag final : public Bag {
 public:
  SqliteBag(Database database, std::string path)
      : path_(std::move(path)), database_(std::move(database)) {}

  absl::Status ReadTopics() {
    // Views could compute for ever.
    TL_ASSIGN_OR_RETURN(
        const Statement tables,
        Prepared("SELECT count(*) FROM sqlite_master WHERE type = 'table' AND "
                 "name IN ('topics', 'messages')"));
    if (sqlite3_step(tables.get()) != SQLITE_ROW) return Error();
    if (sqlite3_column_int(tables.get(), 0) != 2) {
      return absl::InvalidArgumentError(absl::StrCat(
          path_, ": is no bag of ROS 2: it has no tables topics and messages"));
    }
    TL_ASSIGN_OR_RETURN(
        const Statement rows,
        Prepared("SELECT id, name, type, serialization_format FROM topics"));
    int result = SQLITE_ROW;
    while ((result = sqlite3_step(rows.get())) == SQLITE_ROW) {
      const BagTopic topic = {.name = TextAt(rows.get(), 1),
                              .type = Ros2TypeName(TextAt(rows.get(), 2)),
                              .serialization = TextAt(rows.get(), 3) == "cdr"
                                                   ? Serialization::kCdr
                                                   : Serialization::kOther};
      topic_of_id_[sqlite3_column_int64(rows.get(), 0)] = AddTopic(topic);
    }
    if (result != SQLITE_DONE) return Error();
    TL_ASSIGN_OR_RETURN(one_message_,
                        Prepared("SELECT data FROM messages WHERE rowid = ?"));
    return absl::OkStatus();
  }

  absl::Status Read(const TakeMessage& take) override {
    TL_ASSIGN_OR_RETURN(
        const Statement rows,
        Prepared("SELECT rowid, topic_id, timestamp, data FROM messages "
                 "ORDER BY timestamp, rowid"));
    int result = SQLITE_ROW;
    while ((result = sqlite3_step(rows.get())) == SQLITE_ROW) {
      const auto topic = topic_of_id_.find(sqlite3_column_int64(rows.get(), 1));
      if (topic == topic_of_id_.end()) continue;
      TL_RETURN_IF_ERROR(
          take({.topic = topic->second,
                .time_ns = sqlite3_column_int64(rows.get(), 2),
                .bytes = BlobAt(rows.get(), 3),
                .place = {.file = 0,
                          .chunk = 0,
                          .offset = static_cast<uint64_t>(
                              sqlite3_column_int64(rows.get(), 0))}}));
    }
    return result == SQLITE_DONE ? absl::OkStatus() : Error();
  }

  absl::StatusOr<std::span<const uint8_t>> Fetch(
      const BagPlace& place) override {
    sqlite3_reset(one_message_.get());
    sqlite3_bind_int64(one_message_.get(), 1,
                       static_cast<int64_t>(place.offset));
    const int result = sqlite3_step(one_message_.get());
    if (result == SQLITE_ROW) return BlobAt(one_message_.get(), 0);
    if (result != SQLITE_DONE) return Error();
    return absl::OutOfRangeError(absl::StrCat(path_, ": no such message"));
  }

 private:
  static std::span<const uint8_t> BlobAt(sqlite3_stmt* statement, int column) {
    const void* data = sqlite3_column_blob(statement, column);
    const int bytes = sqlite3_column_bytes(statement, column);
    if (data == nullptr || bytes <= 0) return {};
    return {static_cast<const uint8_t*>(data), static_cast<size_t>(bytes)};
  }

  absl::StatusOr<Statement> Prepared(const char* sql) const {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), sql, -1, &statement, nullptr) !=
        SQLITE_OK) {
      return Error();
    }
    return Statement(statement);
  }

  absl::Status Error() const {
    return absl::DataLossError(
        absl::StrCat(path_, ": SQLite: ", sqlite3_errmsg(database_.get())));
  }

  const std::string path_;
  Database database_;
  std::map<int64_t, size_t> topic_of_id_;
  Statement one_message_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Bag>> OpenSqliteBag(const std::string& path) {
  // Without what a killed recorder left beside the file, nothing need be
  // written: bags lie on read-only disks, too.
  std::error_code error;
  const auto left = std::filesystem::file_size(path + "-wal", error);
  const bool is_whole = static_cast<bool>(error) || left == 0;
  sqlite3* raw = nullptr;
  const int result = sqlite3_open_v2(
      (UriOf(path) + (is_whole ? "?immutable=1" : "")).c_str(), &raw,
      SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
  Database database(raw);
  if (result != SQLITE_OK) {
    return absl::UnavailableError(
        absl::StrCat(path, ": SQLite: ", sqlite3_errstr(result)));
  }
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, kMaxValue_bytes);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  auto bag = std::make_unique<SqliteBag>(std::move(database), path);
  TL_RETURN_IF_ERROR(bag->ReadTopics());
  return bag;
}

}  // namespace treeline::bag
