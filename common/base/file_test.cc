#include "common/base/file.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::base {
namespace {

using ::testing::HasSubstr;

class FileTest : public ::testing::Test {
 protected:
  FileTest() {
    std::string name = ::testing::TempDir() + "/file_test_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  ~FileTest() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const {
    return folder_ + "/" + name;
  }
  int FilesInFolder() const {
    int count = 0;
    for ([[maybe_unused]] const auto& entry :
         std::filesystem::directory_iterator(folder_)) {
      ++count;
    }
    return count;
  }

  std::string folder_;
};

// Makes every write beyond `bytes` fail, as a full disk would.
class ScopedFileSizeLimit {
 public:
  explicit ScopedFileSizeLimit(rlim_t bytes) {
    previous_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &previous_);
    rlimit limit = previous_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~ScopedFileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &previous_);
    std::signal(SIGXFSZ, previous_handler_);
  }

 private:
  rlimit previous_{};
  void (*previous_handler_)(int) = nullptr;
};

TEST_F(FileTest, ReadsBackExactlyWhatWasWritten) {
  const std::string bytes("a\0b\xff\n", 5);
  ASSERT_TRUE(WriteFileAtomically(Path("x"), bytes).ok());
  const absl::StatusOr<std::string> read = ReadFile(Path("x"));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, bytes);
}

TEST_F(FileTest, ReadsAnEmptyFile) {
  ASSERT_TRUE(WriteFileAtomically(Path("empty"), "").ok());
  const absl::StatusOr<std::string> read = ReadFile(Path("empty"));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, "");
}

TEST_F(FileTest, NamesTheMissingFile) {
  const absl::Status status = ReadFile(Path("absent")).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr(Path("absent")));
}

TEST_F(FileTest, RefusesToReadAFolder) {
  const absl::Status status = ReadFile(folder_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("not a file"));
}

TEST_F(FileTest, RefusesAFileLongerThanTheLimit) {
  ASSERT_TRUE(WriteFileAtomically(Path("x"), "12345").ok());
  EXPECT_TRUE(ReadFile(Path("x"), 5).ok());
  EXPECT_EQ(ReadFile(Path("x"), 4).status().code(),
            absl::StatusCode::kResourceExhausted);
}

TEST_F(FileTest, ReplacesAnExistingFileAndLeavesNothingElse) {
  ASSERT_TRUE(WriteFileAtomically(Path("x"), "a long first version").ok());
  ASSERT_TRUE(WriteFileAtomically(Path("x"), "short").ok());
  EXPECT_EQ(*ReadFile(Path("x")), "short");
  EXPECT_EQ(FilesInFolder(), 1);
}

TEST_F(FileTest, WritingIntoAMissingFolderNamesTheFile) {
  const std::string path = Path("no/such/x");
  const absl::Status status = WriteFileAtomically(path, "bytes");
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr(path));
}

TEST_F(FileTest, AFullDiskKeepsTheOldFileAndLeavesNoTemporary) {
  ASSERT_TRUE(WriteFileAtomically(Path("x"), "old").ok());
  absl::Status status;
  {
    const ScopedFileSizeLimit limit(4096);
    status = WriteFileAtomically(Path("x"), std::string(1 << 20, 'n'));
  }
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(std::string(status.message()), HasSubstr(Path("x")));
  EXPECT_EQ(*ReadFile(Path("x")), "old");
  EXPECT_EQ(FilesInFolder(), 1);
}

TEST_F(FileTest, AFailedRenameLeavesNoTemporary) {
  // A folder with an entry cannot be replaced by a file.
  ASSERT_EQ(mkdir(Path("target").c_str(), 0755), 0);
  ASSERT_TRUE(WriteFileAtomically(Path("target/entry"), "").ok());
  EXPECT_FALSE(WriteFileAtomically(Path("target"), "bytes").ok());
  EXPECT_EQ(FilesInFolder(), 1);
  EXPECT_TRUE(ReadFile(Path("target/entry")).ok());
}

TEST_F(FileTest, APipeStaysOneAndGetsTheBytes) {
  const std::string path = Path("pipe");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  const int reader = open(path.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  EXPECT_EQ(CheckWritable(path), absl::OkStatus());
  EXPECT_EQ(WriteFileAtomically(path, "bytes"), absl::OkStatus());
  char bytes[16];
  EXPECT_EQ(read(reader, bytes, sizeof(bytes)), 5);
  close(reader);
  EXPECT_TRUE(std::filesystem::is_fifo(path));
  EXPECT_EQ(FilesInFolder(), 1);
}

// As a shell's `program --json /dev/stdout > out` has it.
TEST_F(FileTest, StandardOutputThatIsAFileGetsBytesBehindWhatWasPrinted) {
  std::fflush(stdout);
  const int saved = dup(STDOUT_FILENO);
  const std::string path = Path("out");
  const int out = open(path.c_str(), O_WRONLY | O_CREAT, 0600);
  dup2(out, STDOUT_FILENO);
  std::printf("before ");
  const absl::Status written = WriteFileAtomically("/dev/stdout", "bytes");
  std::printf(" after");
  std::fflush(stdout);
  dup2(saved, STDOUT_FILENO);
  close(saved);
  close(out);
  EXPECT_EQ(written, absl::OkStatus());
  EXPECT_EQ(*ReadFile(path), "before bytes after");
}

TEST_F(FileTest, ChecksAheadWhetherAPathCanBeWritten) {
  EXPECT_TRUE(CheckWritable(Path("new")).ok());
  EXPECT_EQ(FilesInFolder(), 0) << "checking must not leave a file";
  EXPECT_EQ(CheckWritable(Path("no/such")).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(CheckWritable(folder_).code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(FileTest, CheckWritableAcceptsABareNameInTheWorkingFolder) {
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder_);
  EXPECT_TRUE(CheckWritable("result.json").ok());
  std::filesystem::current_path(before);
}

TEST_F(FileTest, CheckWritableRefusesAProtectedFolder) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  ASSERT_EQ(chmod(folder_.c_str(), 0555), 0);
  EXPECT_EQ(CheckWritable(Path("x")).code(),
            absl::StatusCode::kPermissionDenied);
  chmod(folder_.c_str(), 0755);
}

TEST_F(FileTest, MapsTheBytesOfAFile) {
  ASSERT_TRUE(WriteFileAtomically(Path("x"), "mapped bytes").ok());
  const absl::StatusOr<MappedFile> mapped = MappedFile::Open(Path("x"));
  ASSERT_TRUE(mapped.ok()) << mapped.status();
  mapped->Prefetch();
  EXPECT_EQ(std::string(mapped->data(), mapped->data() + mapped->size()),
            "mapped bytes");
}

TEST_F(FileTest, AMappingOutlivesItsReplacedFile) {
  ASSERT_TRUE(WriteFileAtomically(Path("x"), "old").ok());
  const absl::StatusOr<MappedFile> mapped = MappedFile::Open(Path("x"));
  ASSERT_TRUE(mapped.ok()) << mapped.status();
  ASSERT_TRUE(WriteFileAtomically(Path("x"), "new").ok());
  EXPECT_EQ(std::string(mapped->data(), mapped->data() + mapped->size()),
            "old");
}

TEST_F(FileTest, MapsAnEmptyFileAsNoBytes) {
  ASSERT_TRUE(WriteFileAtomically(Path("empty"), "").ok());
  const absl::StatusOr<MappedFile> mapped = MappedFile::Open(Path("empty"));
  ASSERT_TRUE(mapped.ok()) << mapped.status();
  mapped->Prefetch();
  EXPECT_EQ(mapped->size(), 0u);
}

TEST_F(FileTest, MappingAMissingFileOrAFolderFails) {
  EXPECT_EQ(MappedFile::Open(Path("absent")).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(MappedFile::Open(folder_).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(FileTest, AMovedMappingKeepsItsBytes) {
  ASSERT_TRUE(WriteFileAtomically(Path("x"), "bytes").ok());
  absl::StatusOr<MappedFile> opened = MappedFile::Open(Path("x"));
  ASSERT_TRUE(opened.ok()) << opened.status();
  MappedFile moved(std::move(*opened));
  MappedFile assigned;
  assigned = std::move(moved);
  EXPECT_EQ(std::string(assigned.data(), assigned.data() + assigned.size()),
            "bytes");
}

}  // namespace
}  // namespace treeline::base
