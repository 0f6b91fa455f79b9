#include "common/ros2/bag/sqlite_bag.h"

#include <map>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/sqlite/database.h"

namespace treeline::bag {
namespace {

class SqliteBag final : public Bag {
 public:
  explicit SqliteBag(sqlite::Database database)
      : database_(std::move(database)) {}

  absl::Status ReadTopics() {
    for (const char* table : {"topics", "messages"}) {
      TL_ASSIGN_OR_RETURN(const bool is_there, database_.HasTable(table));
      if (is_there) continue;
      return absl::InvalidArgumentError(absl::StrCat(
          database_.path(),
          ": is no bag of ROS 2: it has no tables topics and messages"));
    }
    TL_ASSIGN_OR_RETURN(
        sqlite::Statement rows,
        database_.Prepare(
            "SELECT id, name, type, serialization_format FROM topics"));
    while (true) {
      TL_ASSIGN_OR_RETURN(const bool is_row, rows.Next());
      if (!is_row) break;
      const BagTopic topic = {.name = std::string(rows.Text(1)),
                              .type = Ros2TypeName(std::string(rows.Text(2))),
                              .serialization = rows.Text(3) == "cdr"
                                                   ? Serialization::kCdr
                                                   : Serialization::kOther};
      topic_of_id_[rows.Int64(0)] = AddTopic(topic);
    }
    TL_ASSIGN_OR_RETURN(
        one_message_,
        database_.Prepare("SELECT data FROM messages WHERE rowid = ?"));
    return absl::OkStatus();
  }

  absl::Status Read(const TakeMessage& take) override {
    TL_ASSIGN_OR_RETURN(
        sqlite::Statement rows,
        database_.Prepare(
            "SELECT rowid, topic_id, timestamp, data FROM messages "
            "ORDER BY timestamp, rowid"));
    while (true) {
      TL_ASSIGN_OR_RETURN(const bool is_row, rows.Next());
      if (!is_row) return absl::OkStatus();
      const auto topic = topic_of_id_.find(rows.Int64(1));
      if (topic == topic_of_id_.end()) continue;
      TL_RETURN_IF_ERROR(
          take({.topic = topic->second,
                .time_ns = rows.Int64(2),
                .bytes = rows.Blob(3),
                .place = {.file = 0,
                          .chunk = 0,
                          .offset = static_cast<uint64_t>(rows.Int64(0))}}));
    }
  }

  absl::StatusOr<std::span<const uint8_t>> Fetch(
      const BagPlace& place) override {
    one_message_->Bind(1, static_cast<int64_t>(place.offset));
    TL_ASSIGN_OR_RETURN(const bool is_row, one_message_->Next());
    if (is_row) return one_message_->Blob(0);
    return absl::OutOfRangeError(
        absl::StrCat(database_.path(), ": no such message"));
  }

 private:
  sqlite::Database database_;
  std::map<int64_t, size_t> topic_of_id_;
  std::optional<sqlite::Statement> one_message_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Bag>> OpenSqliteBag(const std::string& path) {
  TL_ASSIGN_OR_RETURN(sqlite::Database database, sqlite::Database::Open(path));
  auto bag = std::make_unique<SqliteBag>(std::move(database));
  TL_RETURN_IF_ERROR(bag->ReadTopics());
  return bag;
}

}  // namespace treeline::bag
