// SQLite databases from outside, read without trust in them.
#ifndef COMMON_SQLITE_DATABASE_H_
#define COMMON_SQLITE_DATABASE_H_

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::sqlite {

// The rows of one query. Not thread-safe; the database must live on.
class Statement {
 public:
  // Values for "?", counted from 1; after this the rows begin anew.
  void Bind(int parameter, int64_t value);
  // True: there is a row. DATA_LOSS, naming the file: the database is broken.
  absl::StatusOr<bool> Next();

  // Of the row, columns counted from 0. What is NULL or of another type is 0 or
  // empty. Views are valid until the next row.
  int64_t Int64(int column) const;
  double Double(int column) const;
  absl::string_view Text(int column) const;
  std::span<const uint8_t> Blob(int column) const;

 private:
  friend class Database;
  struct Finalizer {
    void operator()(sqlite3_stmt* statement) const {
      sqlite3_finalize(statement);
    }
  };
  Statement(sqlite3_stmt* statement, std::string path)
      : statement_(statement), path_(std::move(path)) {}

  std::unique_ptr<sqlite3_stmt, Finalizer> statement_;
  std::string path_;
};

class Database {
 public:
  // No value of a row may be larger.
  static constexpr int kMaxValue_bytes = 256 << 20;

  // For reading alone; nothing is written beside the file unless a killed
  // writer left its log there. UNAVAILABLE: it cannot be opened.
  static absl::StatusOr<Database> Open(const std::string& path);

  // `sql` is ours and never of the file. DATA_LOSS: the file is no database,
  // or lacks a table or column.
  absl::StatusOr<Statement> Prepare(const std::string& sql) const;
  // Whether there is a table (not a view, which could compute for ever) of this
  // name. DATA_LOSS: the file is no database.
  absl::StatusOr<bool> HasTable(const std::string& name) const;
  // Whether the table has this column.
  absl::StatusOr<bool> HasColumn(const std::string& table,
                                 const std::string& column) const;

  const std::string& path() const { return path_; }

 private:
  struct Closer {
    void operator()(sqlite3* database) const { sqlite3_close(database); }
  };
  Database(sqlite3* database, std::string path)
      : path_(std::move(path)), database_(database) {}
  absl::StatusOr<int64_t> Count(const std::string& sql, absl::string_view first,
                                absl::string_view second) const;

  std::string path_;
  std::unique_ptr<sqlite3, Closer> database_;
};

// Whether a file begins as every database of SQLite 3 does.
bool IsDatabase(const std::string& path);

}  // namespace treeline::sqlite

#endif  // COMMON_SQLITE_DATABASE_H_
