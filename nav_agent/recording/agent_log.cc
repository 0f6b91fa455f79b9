#include "nav_agent/recording/agent_log.h"

#include <fcntl.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/recording/log_payload.h"

namespace treeline::recording {
namespace {

constexpr absl::string_view kMagic = "TREELOG\n";
constexpr size_t kFileHeader_bytes = 16;
constexpr absl::string_view kSync = "TLrc";
constexpr size_t kRecordHeader_bytes = 32;
constexpr size_t kChecksumAt = 24;
constexpr uint16_t kFrameKind = 18;
constexpr size_t kFlushFrom_bytes = size_t{1} << 20;
constexpr std::chrono::milliseconds kFlushEvery(900);

template <typename T>
void Put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <typename T>
T At(absl::string_view bytes, size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

uint64_t ChecksumOf(absl::string_view record) {
  return XXH3_64bits_withSeed(record.data() + kRecordHeader_bytes,
                              record.size() - kRecordHeader_bytes,
                              XXH3_64bits(record.data(), kChecksumAt));
}

// The length of the whole record that begins at `bytes`; 0 if none does.
size_t WholeRecordAt(absl::string_view bytes) {
  if (bytes.size() < kRecordHeader_bytes ||
      bytes.substr(0, kSync.size()) != kSync) {
    return 0;
  }
  const uint64_t payload = At<uint32_t>(bytes, 8);
  if (payload > kMaxLogPayload_bytes ||
      payload > bytes.size() - kRecordHeader_bytes) {
    return 0;
  }
  const size_t length = kRecordHeader_bytes + static_cast<size_t>(payload);
  const uint64_t checksum = At<uint64_t>(bytes, kChecksumAt);
  return ChecksumOf(bytes.substr(0, length)) == checksum ? length : 0;
}

absl::Status SystemError(absl::string_view what, const std::string& path) {
  const std::string message =
      absl::StrCat(what, " ", path, ": ", std::strerror(errno));
  switch (errno) {
    case ENOENT:
      return absl::NotFoundError(message);
    case EEXIST:
      return absl::AlreadyExistsError(message);
    case EACCES:
      return absl::PermissionDeniedError(message);
    default:
      return absl::UnavailableError(message);
  }
}

// Where a log that goes on is to be continued.
absl::StatusOr<size_t> EndOfWholeEntries(const std::string& path) {
  TL_ASSIGN_OR_RETURN(AgentLogReader reader, AgentLogReader::Open(path));
  while (reader.Next().has_value()) {
  }
  return reader.end_of_last_entry();
}

}  // namespace

std::string AgentLogHeader() {
  std::string header(kMagic);
  Put(header, kAgentLogVersion);
  Put(header, uint32_t{0});
  return header;
}

std::string EncodeLogRecord(const LogEntry& entry) {
  const LogPayload payload = EncodeLogPayload(entry);
  std::string record(kSync);
  Put(record, payload.kind);
  Put(record, uint16_t{0});
  Put(record, static_cast<uint32_t>(payload.bytes.size()));
  Put(record, uint32_t{0});
  Put(record, payload.stamp_ns);
  Put(record, uint64_t{0});
  record += payload.bytes;
  const uint64_t checksum = ChecksumOf(record);
  std::memcpy(record.data() + kChecksumAt, &checksum, sizeof(checksum));
  return record;
}

absl::StatusOr<LogFrame> EncodeLogFrame(const core::RgbdFrame& frame,
                                        int jpeg_quality) {
  LogFrame encoded = {.stamp = frame.stamp, .sequence = frame.sequence};
  if (jpeg_quality < 1) {
    TL_ASSIGN_OR_RETURN(encoded.color, image::EncodePng(frame.frame.color));
  } else {
    TL_ASSIGN_OR_RETURN(encoded.color,
                        image::EncodeJpeg(frame.frame.color, jpeg_quality));
  }
  if (frame.frame.depth.has_value()) {
    encoded.depth_unit_m = frame.frame.depth->unit_m;
    TL_ASSIGN_OR_RETURN(encoded.depth,
                        image::EncodeDepthPng(*frame.frame.depth));
  }
  return encoded;
}

absl::StatusOr<core::RgbdFrame> DecodeLogFrame(const LogFrame& frame) {
  core::RgbdFrame decoded;
  decoded.stamp = frame.stamp;
  decoded.sequence = frame.sequence;
  TL_ASSIGN_OR_RETURN(decoded.frame.color, image::DecodeColor(frame.color));
  if (!frame.depth.empty()) {
    TL_ASSIGN_OR_RETURN(decoded.frame.depth,
                        image::DecodeDepthPng(frame.depth, frame.depth_unit_m));
  }
  return decoded;
}

absl::StatusOr<std::unique_ptr<AgentLogWriter>> AgentLogWriter::Open(
    const std::string& path, bool append, const base::Clock& clock) {
  size_t end = 0;
  bool is_new = true;
  if (append && access(path.c_str(), F_OK) == 0) {
    TL_ASSIGN_OR_RETURN(end, EndOfWholeEntries(path));
    is_new = false;
  }
  const int flags = O_WRONLY | O_CLOEXEC | (is_new ? O_CREAT | O_EXCL : 0);
  const int fd = open(path.c_str(), flags, 0644);
  if (fd < 0) return SystemError("cannot write", path);
  std::unique_ptr<AgentLogWriter> writer(new AgentLogWriter(fd, path, clock));
  const auto offset = static_cast<off_t>(end);
  if (!is_new &&
      (ftruncate(fd, offset) != 0 || lseek(fd, offset, SEEK_SET) < 0)) {
    return SystemError("cannot go on with", path);
  }
  writer->bytes_ = static_cast<int64_t>(end);
  if (is_new) {
    writer->buffer_ = AgentLogHeader();
    writer->bytes_ = static_cast<int64_t>(writer->buffer_.size());
    TL_RETURN_IF_ERROR(writer->Flush());
  }
  return writer;
}

AgentLogWriter::AgentLogWriter(int fd, std::string path,
                               const base::Clock& clock)
    : fd_(fd),
      path_(std::move(path)),
      clock_(&clock),
      last_flush_(clock.Now()) {}

AgentLogWriter::~AgentLogWriter() {
  Flush().IgnoreError();
  close(fd_);
}

absl::Status AgentLogWriter::Write(const LogEntry& entry) {
  const std::string record = EncodeLogRecord(entry);
  if (record.size() > kRecordHeader_bytes + kMaxLogPayload_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("an entry of ", record.size(), " bytes for ", path_));
  }
  buffer_ += record;
  bytes_ += static_cast<int64_t>(record.size());
  if (buffer_.size() >= kFlushFrom_bytes ||
      clock_->Now() - last_flush_ >= kFlushEvery) {
    return Flush();
  }
  return absl::OkStatus();
}

absl::Status AgentLogWriter::Flush() {
  last_flush_ = clock_->Now();
  size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t n = write(fd_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      buffer_.erase(0, done);
      return SystemError("cannot write", path_);
    }
    done += static_cast<size_t>(n);
  }
  buffer_.clear();
  return absl::OkStatus();
}

bool IsAgentLog(absl::string_view bytes) {
  return bytes.substr(0, kMagic.size()) == kMagic;
}

absl::StatusOr<AgentLogReader> AgentLogReader::Open(const std::string& path) {
  TL_ASSIGN_OR_RETURN(base::MappedFile file, base::MappedFile::Open(path));
  auto shared = std::make_shared<const base::MappedFile>(std::move(file));
  const absl::string_view bytes(reinterpret_cast<const char*>(shared->data()),
                                static_cast<size_t>(shared->size()));
  auto reader = Parse(bytes);
  if (!reader.ok()) return base::Annotate(reader.status(), path);
  reader->file_ = std::move(shared);
  return reader;
}

absl::StatusOr<AgentLogReader> AgentLogReader::Parse(absl::string_view bytes) {
  if (bytes.size() < kFileHeader_bytes || !IsAgentLog(bytes)) {
    return absl::DataLossError("not an agent log");
  }
  const uint32_t version = At<uint32_t>(bytes, kMagic.size());
  if (version != kAgentLogVersion) {
    return absl::FailedPreconditionError(
        absl::StrCat("an agent log of version ", version,
                     "; this program reads version ", kAgentLogVersion));
  }
  AgentLogReader reader;
  reader.bytes_ = bytes;
  reader.at_ = kFileHeader_bytes;
  reader.end_of_last_ = kFileHeader_bytes;
  return reader;
}

std::optional<LogEntry> AgentLogReader::Next() {
  while (at_ < bytes_.size()) {
    const absl::string_view rest = bytes_.substr(at_);
    const size_t length = WholeRecordAt(rest);
    if (length == 0) {
      // On to what may be the next one.
      const size_t next = rest.find(kSync, 1);
      const size_t skipped =
          next == absl::string_view::npos ? rest.size() : next;
      damaged_bytes_ += static_cast<int64_t>(skipped);
      at_ += skipped;
      continue;
    }
    at_ += length;
    end_of_last_ = at_;
    const auto kind = At<uint16_t>(rest, 4);
    if (skips_frames_ && kind == kFrameKind) {
      ++skipped_frames_;
      continue;
    }
    auto entry = DecodeLogPayload(
        kind, At<int64_t>(rest, 16),
        rest.substr(kRecordHeader_bytes, length - kRecordHeader_bytes));
    if (entry.has_value()) return entry;
  }
  return std::nullopt;
}

}  // namespace treeline::recording
