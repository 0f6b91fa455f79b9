#include "server/app/failed_query_recorder.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <regex>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::server_app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLongestReason = 40;
constexpr const char* kSuffixes[] = {".json", ".binpb"};

uint64_t SizeOf(const FailedQuery& query) {
  return query.request.size() + query.json.size();
}

// Only letters that file names and shells do not mind.
std::string AsFileName(absl::string_view reason) {
  std::string name(reason.substr(0, kLongestReason));
  for (char& c : name) {
    if (!absl::ascii_isalnum(static_cast<unsigned char>(c)) && c != '_') {
      c = '_';
    }
  }
  return name.empty() ? "UNKNOWN" : name;
}

// Our own files: the stem, and whether it is one that was not finished.
struct OurFile {
  std::string stem;
  bool unfinished = false;
};

bool IsOurs(const std::string& name, OurFile& file) {
  static const std::regex ours(
      "(\\d{8}T\\d{6}\\.\\d{3}Z-\\d{6,}-[A-Za-z0-9_]+)\\.(json|binpb)"
      "(\\.tmp-\\d+)?");
  std::smatch match;
  if (!std::regex_match(name, match, ours)) return false;
  file = {match[1].str(), match[3].matched};
  return true;
}

}  // namespace

bool IsFailedQueryName(const std::string& name) {
  OurFile file;
  return IsOurs(name + ".json", file) && file.stem == name;
}

absl::StatusOr<std::unique_ptr<FailedQueryRecorder>> FailedQueryRecorder::Start(
    RecorderOptions options, WallClock wall_clock, OnHealth on_health) {
  if (mkdir(options.folder.c_str(), 0700) != 0 && errno != EEXIST) {
    return absl::ErrnoToStatus(
        errno, absl::StrCat("cannot make the folder ", options.folder));
  }
  TL_RETURN_IF_ERROR(base::CheckWritable(options.folder + "/probe"));
  std::unique_ptr<FailedQueryRecorder> recorder(new FailedQueryRecorder(
      std::move(options), std::move(wall_clock), std::move(on_health)));
  TL_RETURN_IF_ERROR(recorder->Adopt());
  recorder->thread_ = std::thread([self = recorder.get()] { self->Run(); });
  return recorder;
}

FailedQueryRecorder::FailedQueryRecorder(RecorderOptions options,
                                         WallClock wall_clock,
                                         OnHealth on_health)
    : options_(std::move(options)),
      wall_clock_(std::move(wall_clock)),
      on_health_(std::move(on_health)) {}

FailedQueryRecorder::~FailedQueryRecorder() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

bool FailedQueryRecorder::Fits(uint64_t bytes) const {
  return bytes <= options_.max_bytes &&
         pending_.size() < options_.max_pending &&
         pending_bytes_ + bytes <= options_.max_pending_bytes;
}

bool FailedQueryRecorder::HasRoomFor(uint64_t bytes) {
  absl::MutexLock lock(&mutex_);
  if (Fits(bytes)) return true;
  ++dropped_;
  return false;
}

void FailedQueryRecorder::Offer(FailedQuery query) {
  absl::MutexLock lock(&mutex_);
  if (!Fits(SizeOf(query))) {
    ++dropped_;
    return;
  }
  pending_bytes_ += SizeOf(query);
  pending_.push_back(std::move(query));
}

void FailedQueryRecorder::WaitUntilIdle() {
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &FailedQueryRecorder::IsIdle));
}

absl::Status FailedQueryRecorder::Adopt() {
  std::error_code error;
  for (fs::directory_iterator entry(options_.folder, error), end;
       !error && entry != end; entry.increment(error)) {
    OurFile file;
    std::error_code ignored;
    if (!IsOurs(entry->path().filename().string(), file) ||
        !entry->is_regular_file(ignored)) {
      continue;
    }
    if (file.unfinished) {
      fs::remove(entry->path(), ignored);
      continue;
    }
    const uint64_t bytes = entry->file_size(ignored);
    if (ignored) continue;
    kept_[file.stem] += bytes;
    bytes_on_disk_ += bytes;
  }
  if (error) {
    return absl::ErrnoToStatus(error.value(),
                               absl::StrCat("reading ", options_.folder));
  }
  // The bound may have been lowered.
  while (bytes_on_disk_ > options_.max_bytes && !kept_.empty()) DeleteOldest();
  return absl::OkStatus();
}

void FailedQueryRecorder::Run() {
  while (true) {
    FailedQuery query;
    {
      absl::MutexLock lock(&mutex_);
      mutex_.Await(absl::Condition(this, &FailedQueryRecorder::HasWorkOrStops));
      if (pending_.empty()) return;
      query = std::move(pending_.front());
      pending_.pop_front();
      pending_bytes_ -= SizeOf(query);
      writing_ = true;
    }
    const absl::Status status = Write(query);
    ++(status.ok() ? written_ : failed_);
    if (status.ok() != std::exchange(healthy_, status.ok())) on_health_(status);
    absl::MutexLock lock(&mutex_);
    writing_ = false;
  }
}

absl::Status FailedQueryRecorder::Write(const FailedQuery& query) {
  const uint64_t bytes = SizeOf(query);
  while (bytes_on_disk_ + bytes > options_.max_bytes && !kept_.empty()) {
    DeleteOldest();
  }
  const std::string stem = NextStem(query.reason);
  const std::string path = absl::StrCat(options_.folder, "/", stem);
  // What is large comes last: where it is, everything is.
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(path + ".json", query.json));
  if (absl::Status status =
          base::WriteFileAtomically(path + ".binpb", query.request);
      !status.ok()) {
    std::error_code ignored;
    fs::remove(path + ".json", ignored);
    return status;
  }
  kept_[stem] = bytes;
  bytes_on_disk_ += bytes;
  return absl::OkStatus();
}

void FailedQueryRecorder::DeleteOldest() {
  const auto oldest = kept_.begin();
  for (const char* suffix : kSuffixes) {
    // Whoever deleted it before us is welcome.
    std::error_code ignored;
    fs::remove(absl::StrCat(options_.folder, "/", oldest->first, suffix),
               ignored);
  }
  bytes_on_disk_ -= oldest->second;
  kept_.erase(oldest);
}

std::string FailedQueryRecorder::NextStem(const std::string& reason) {
  const absl::Time now = absl::FromChrono(wall_clock_());
  return absl::StrCat(
      absl::FormatTime("%Y%m%dT%H%M%E3S", now, absl::UTCTimeZone()), "Z-",
      absl::StrFormat("%06d", next_number_++), "-", AsFileName(reason));
}

void AddRecorderMetrics(metrics::Registry& registry,
                        const FailedQueryRecorder& recorder) {
  registry.AddSource([&recorder](metrics::Exposition& out) {
    out.Family("treeline_recorded_queries_total",
               "Failed queries to be kept, by result: written, dropped, "
               "failed.",
               metrics::MetricType::kCounter);
    out.Sample({{"result", "written"}},
               static_cast<double>(recorder.written()));
    out.Sample({{"result", "dropped"}},
               static_cast<double>(recorder.dropped()));
    out.Sample({{"result", "failed"}}, static_cast<double>(recorder.failed()));
    out.Family("treeline_recorded_bytes",
               "What the kept failed queries take on disk.",
               metrics::MetricType::kGauge);
    out.Sample({}, static_cast<double>(recorder.bytes_on_disk()));
  });
}

}  // namespace treeline::server_app
