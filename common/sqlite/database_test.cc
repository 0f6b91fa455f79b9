#include "common/sqlite/database.h"

#include <sqlite3.h>

#include <cstdlib>
#include <string>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gtest/gtest.h"

namespace treeline::sqlite {
namespace {

void Execute(const std::string& path, const char* sql) {
  sqlite3* database = nullptr;
  if (sqlite3_open(path.c_str(), &database) != SQLITE_OK ||
      sqlite3_exec(database, sql, nullptr, nullptr, nullptr) != SQLITE_OK) {
    std::abort();
  }
  sqlite3_close(database);
}

class DatabaseTest : public testing::Test {
 protected:
  const base::TestingFolder folder_;
  // With what means something in a URI.
  const std::string path_ = folder_.Path("a walk?#%41.db");
};

TEST_F(DatabaseTest, ReadsRowsAndTheirTypes) {
  Execute(
      path_,
      "CREATE TABLE t(a INTEGER, b FLOAT, c TEXT, d BLOB);"
      "INSERT INTO t VALUES(7, 0.5, 'x', x'0102'), (NULL, NULL, NULL, NULL);");
  ASSERT_TRUE(IsDatabase(path_));
  const auto database = Database::Open(path_);
  ASSERT_TRUE(database.ok()) << database.status();
  auto rows = database->Prepare("SELECT a, b, c, d FROM t ORDER BY rowid");
  ASSERT_TRUE(rows.ok()) << rows.status();
  ASSERT_TRUE(*rows->Next());
  EXPECT_EQ(rows->Int64(0), 7);
  EXPECT_EQ(rows->Double(1), 0.5);
  EXPECT_EQ(rows->Text(2), "x");
  ASSERT_EQ(rows->Blob(3).size(), 2);
  EXPECT_EQ(rows->Blob(3)[1], 2);
  ASSERT_TRUE(*rows->Next());
  EXPECT_EQ(rows->Int64(0), 0);
  EXPECT_EQ(rows->Text(2), "");
  EXPECT_TRUE(rows->Blob(3).empty());
  EXPECT_FALSE(*rows->Next());
}

TEST_F(DatabaseTest, BoundRowsBeginAnew) {
  Execute(path_,
          "CREATE TABLE t(a INTEGER); INSERT INTO t VALUES(1), (2), (3);");
  const auto database = Database::Open(path_);
  ASSERT_TRUE(database.ok()) << database.status();
  auto row = database->Prepare("SELECT a FROM t WHERE rowid = ?");
  ASSERT_TRUE(row.ok()) << row.status();
  for (const int64_t id : {3, 1, 2}) {
    row->Bind(1, id);
    ASSERT_TRUE(*row->Next());
    EXPECT_EQ(row->Int64(0), id);
  }
}

// A view can compute for ever.
TEST_F(DatabaseTest, ViewsAreNoTables) {
  Execute(path_,
          "CREATE TABLE t(a INTEGER); CREATE VIEW v AS SELECT a FROM t;");
  const auto database = Database::Open(path_);
  ASSERT_TRUE(database.ok()) << database.status();
  EXPECT_TRUE(*database->HasTable("t"));
  EXPECT_FALSE(*database->HasTable("v"));
  EXPECT_FALSE(*database->HasTable("u"));
  EXPECT_TRUE(*database->HasColumn("t", "a"));
  EXPECT_FALSE(*database->HasColumn("t", "b"));
}

TEST_F(DatabaseTest, WhatIsNoDatabaseIsSaid) {
  folder_.Write("text.db", "no database, and longer than sixteen bytes");
  EXPECT_FALSE(IsDatabase(folder_.Path("text.db")));
  EXPECT_FALSE(IsDatabase(folder_.Path("nowhere.db")));
  EXPECT_FALSE(IsDatabase(folder_.Path("")));
  const auto text = Database::Open(folder_.Path("text.db"));
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_EQ(text->HasTable("t").status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(Database::Open(folder_.Path("nowhere.db")).status().code(),
            absl::StatusCode::kUnavailable);
}

TEST_F(DatabaseTest, AFileThatIsCutOffIsAnError) {
  Execute(path_,
          "CREATE TABLE t(a BLOB); WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL "
          "SELECT i + 1 FROM n WHERE i < 50) INSERT INTO t SELECT "
          "randomblob(10000) FROM n;");
  const std::string bytes = *base::ReadFile(path_);
  folder_.Write("cut.db", bytes.substr(0, bytes.size() / 2));
  const auto database = Database::Open(folder_.Path("cut.db"));
  ASSERT_TRUE(database.ok()) << database.status();
  // Which step finds it is SQLite's affair.
  auto rows = database->Prepare("SELECT a FROM t");
  absl::Status status = rows.status();
  for (bool is_row = true; status.ok() && is_row;) {
    const absl::StatusOr<bool> next = rows->Next();
    status = next.status();
    is_row = next.ok() && *next;
  }
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace treeline::sqlite
