#include "server/core/training/sample_memory.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::training {
namespace {

constexpr const char* kName = "/.samples-XXXXXX";

static_assert(std::is_trivially_copyable_v<Label>);
static_assert(std::is_trivially_copyable_v<features::WhtDescriptor>);

absl::Status WriteAt(int file, const char* bytes, size_t count,
                     int64_t offset) {
  while (count > 0) {
    const ssize_t written = pwrite(file, bytes, count, offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      return absl::UnavailableError(
          absl::StrCat("keeping samples: ", std::strerror(errno)));
    }
    bytes += written;
    count -= static_cast<size_t>(written);
    offset += written;
  }
  return absl::OkStatus();
}

absl::Status ReadAt(int file, char* bytes, size_t count, int64_t offset) {
  while (count > 0) {
    const ssize_t got = pread(file, bytes, count, offset);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return absl::DataLossError("samples that were kept are gone");
    bytes += got;
    count -= static_cast<size_t>(got);
    offset += got;
  }
  return absl::OkStatus();
}

template <typename T>
absl::Status Append(int file, const std::vector<T>& values, int64_t& end) {
  const size_t bytes = values.size() * sizeof(T);
  TL_RETURN_IF_ERROR(
      WriteAt(file, reinterpret_cast<const char*>(values.data()), bytes, end));
  end += static_cast<int64_t>(bytes);
  return absl::OkStatus();
}

template <typename T>
absl::Status Take(int file, size_t count, int64_t& offset,
                  std::vector<T>& values) {
  values.resize(count);
  const size_t bytes = count * sizeof(T);
  TL_RETURN_IF_ERROR(
      ReadAt(file, reinterpret_cast<char*>(values.data()), bytes, offset));
  offset += static_cast<int64_t>(bytes);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<SampleMemory>> SampleMemory::Open(
    const std::string& folder) {
  std::string name = folder + kName;
  const int file = mkostemp(name.data(), O_CLOEXEC);
  if (file < 0) {
    return absl::UnavailableError(
        absl::StrCat(folder, ": a file for samples: ", std::strerror(errno)));
  }
  unlink(name.c_str());
  return std::unique_ptr<SampleMemory>(new SampleMemory(file));
}

absl::Status SampleMemory::Add(std::span<const RoutedSamples> by_tree) {
  // What does not fit is written over by the next.
  int64_t end = end_;
  std::vector<Place> places;
  for (const RoutedSamples& samples : by_tree) {
    places.push_back({.offset = end, .samples = samples.size()});
    TL_RETURN_IF_ERROR(Append(file_.get(), samples.leaf, end));
    TL_RETURN_IF_ERROR(Append(file_.get(), samples.point, end));
    TL_RETURN_IF_ERROR(Append(file_.get(), samples.descriptor, end));
  }
  end_ = end;
  frames_.push_back(std::move(places));
  return absl::OkStatus();
}

absl::StatusOr<RoutedSamples> SampleMemory::Read(size_t i, int tree) const {
  const Place& place = frames_[i][static_cast<size_t>(tree)];
  int64_t offset = place.offset;
  RoutedSamples samples;
  TL_RETURN_IF_ERROR(Take(file_.get(), place.samples, offset, samples.leaf));
  TL_RETURN_IF_ERROR(Take(file_.get(), place.samples, offset, samples.point));
  TL_RETURN_IF_ERROR(
      Take(file_.get(), place.samples, offset, samples.descriptor));
  return samples;
}

}  // namespace treeline::training
