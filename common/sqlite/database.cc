#include "common/sqlite/database.h"

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"

namespace treeline::sqlite {
namespace {

constexpr absl::string_view kMagic("SQLite format 3\0", 16);

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

absl::Status Error(const std::string& path, sqlite3* database) {
  return absl::DataLossError(
      absl::StrCat(path, ": SQLite: ", sqlite3_errmsg(database)));
}

}  // namespace

void Statement::Bind(int parameter, int64_t value) {
  sqlite3_reset(statement_.get());
  sqlite3_bind_int64(statement_.get(), parameter, value);
}

absl::StatusOr<bool> Statement::Next() {
  const int result = sqlite3_step(statement_.get());
  if (result == SQLITE_ROW) return true;
  if (result == SQLITE_DONE) return false;
  return Error(path_, sqlite3_db_handle(statement_.get()));
}

int64_t Statement::Int64(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

double Statement::Double(int column) const {
  return sqlite3_column_double(statement_.get(), column);
}

absl::string_view Statement::Text(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_.get(), column);
  const int bytes = sqlite3_column_bytes(statement_.get(), column);
  if (text == nullptr || bytes <= 0) return "";
  return {reinterpret_cast<const char*>(text), static_cast<size_t>(bytes)};
}

std::span<const uint8_t> Statement::Blob(int column) const {
  const void* data = sqlite3_column_blob(statement_.get(), column);
  const int bytes = sqlite3_column_bytes(statement_.get(), column);
  if (data == nullptr || bytes <= 0) return {};
  return {static_cast<const uint8_t*>(data), static_cast<size_t>(bytes)};
}

absl::StatusOr<Database> Database::Open(const std::string& path) {
  // Without what a killed writer left beside the file, nothing need be written:
  // recordings lie on read-only disks, too.
  std::error_code error;
  const auto left = std::filesystem::file_size(path + "-wal", error);
  const bool is_whole = static_cast<bool>(error) || left == 0;
  sqlite3* raw = nullptr;
  const int result = sqlite3_open_v2(
      (UriOf(path) + (is_whole ? "?immutable=1" : "")).c_str(), &raw,
      SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
  Database database(raw, path);
  if (result != SQLITE_OK) {
    return absl::UnavailableError(
        absl::StrCat(path, ": SQLite: ", sqlite3_errstr(result)));
  }
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, kMaxValue_bytes);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  return database;
}

absl::StatusOr<Statement> Database::Prepare(const std::string& sql) const {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &statement,
                         nullptr) != SQLITE_OK) {
    return Error(path_, database_.get());
  }
  return Statement(statement, path_);
}

absl::StatusOr<int64_t> Database::Count(const std::string& sql,
                                        absl::string_view first,
                                        absl::string_view second) const {
  TL_ASSIGN_OR_RETURN(Statement statement, Prepare(sql));
  int parameter = 0;
  for (const absl::string_view value : {first, second}) {
    if (value.empty()) continue;
    sqlite3_bind_text(statement.statement_.get(), ++parameter, value.data(),
                      static_cast<int>(value.size()), SQLITE_TRANSIENT);
  }
  TL_RETURN_IF_ERROR(statement.Next().status());
  return statement.Int64(0);
}

absl::StatusOr<bool> Database::HasTable(const std::string& name) const {
  TL_ASSIGN_OR_RETURN(const int64_t count,
                      Count("SELECT count(*) FROM sqlite_master WHERE type = "
                            "'table' AND name = ?",
                            name, ""));
  return count > 0;
}

absl::StatusOr<bool> Database::HasColumn(const std::string& table,
                                         const std::string& column) const {
  TL_ASSIGN_OR_RETURN(
      const int64_t count,
      Count("SELECT count(*) FROM pragma_table_info(?) WHERE name = ?", table,
            column));
  return count > 0;
}

bool IsDatabase(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string start(kMagic.size(), '\0');
  return file.read(start.data(), static_cast<std::streamsize>(start.size())) &&
         start == kMagic;
}

}  // namespace treeline::sqlite
