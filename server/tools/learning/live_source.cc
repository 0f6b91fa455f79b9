#include "server/tools/learning/live_source.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"

namespace treeline::learning {
namespace {

constexpr int kStopPoll_ms = 50;
// Geocentric coordinates reach 6.4e6, projected ones 1e7.
constexpr double kMaxPosition_m = 2e7;
constexpr size_t kMaxLineBytes = 16384;
constexpr size_t kFields = 9;
constexpr const char* kPose = "pose";
constexpr const char* kEnd = "end";

class RecordingFrames final : public LiveSource {
 public:
  explicit RecordingFrames(const dataset::Dataset& dataset)
      : dataset_(dataset) {}

  absl::StatusOr<std::optional<LiveItem>> Next(
      const std::stop_token& stop) override {
    while (!stop.stop_requested() && next_ < dataset_.size()) {
      const dataset::DatasetFrame& frame = dataset_.frame(next_++);
      if (!frame.world_from_camera || frame.depth_path.empty()) continue;
      return LiveItem(LiveFrame{frame.color_path, frame.depth_path,
                                *frame.world_from_camera});
    }
    return std::nullopt;
  }

 private:
  const dataset::Dataset& dataset_;
  int next_ = 0;
};

class LineFrames final : public LiveSource {
 public:
  explicit LineFrames(int descriptor) : descriptor_(descriptor) {}

  absl::StatusOr<std::optional<LiveItem>> Next(
      const std::stop_token& stop) override {
    while (true) {
      TL_ASSIGN_OR_RETURN(const std::optional<std::string> line,
                          NextLine(stop));
      if (!line) return std::nullopt;
      absl::StatusOr<std::optional<LiveItem>> item = ParseLiveLine(*line);
      if (!item.ok()) {
        return base::Annotate(item.status(), absl::StrCat("line ", lines_));
      }
      if (*item) return item;
    }
  }

 private:
  // Without its end; nullopt: there are no more, or `stop`.
  absl::StatusOr<std::optional<std::string>> NextLine(
      const std::stop_token& stop) {
    while (true) {
      const size_t end = bytes_.find('\n');
      if (end != std::string::npos || (at_end_ && !bytes_.empty())) {
        std::string line = bytes_.substr(0, end);
        bytes_.erase(0, end == std::string::npos ? end : end + 1);
        ++lines_;
        return line;
      }
      if (at_end_) return std::nullopt;
      if (bytes_.size() > kMaxLineBytes) {
        bytes_.clear();
        return absl::InvalidArgumentError(
            absl::StrCat("a line of more than ", kMaxLineBytes, " bytes"));
      }
      if (!WaitForBytes(stop)) return std::nullopt;
      TL_RETURN_IF_ERROR(ReadSome());
    }
  }

  bool WaitForBytes(const std::stop_token& stop) const {
    pollfd waited{.fd = descriptor_, .events = POLLIN, .revents = 0};
    while (!stop.stop_requested()) {
      if (poll(&waited, 1, kStopPoll_ms) > 0) return true;
    }
    return false;
  }

  absl::Status ReadSome() {
    std::array<char, 4096> some;
    const ssize_t got = read(descriptor_, some.data(), some.size());
    if (got < 0 && errno == EINTR) return absl::OkStatus();
    if (got < 0) {
      return absl::UnavailableError(
          absl::StrCat("standard input: ", std::strerror(errno)));
    }
    at_end_ = got == 0;
    bytes_.append(some.data(), static_cast<size_t>(got));
    return absl::OkStatus();
  }

  const int descriptor_;
  std::string bytes_;
  bool at_end_ = false;
  int64_t lines_ = 0;
};

// The last seven fields.
absl::StatusOr<geometry::Rigid3> ParsePose(
    const std::vector<std::string>& fields) {
  std::array<double, 7> n{};
  for (size_t i = 0; i < n.size(); ++i) {
    if (!absl::SimpleAtod(fields[i + 2], &n[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat("\"", fields[i + 2], "\" is no number"));
    }
  }
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 pose,
                      geometry::RigidFromQuaternion(n[6], n[3], n[4], n[5],
                                                    {n[0], n[1], n[2]}));
  if (geometry::Norm(pose.translation) > kMaxPosition_m) {
    return absl::InvalidArgumentError(
        absl::StrCat("the camera's position, ", fields[2], " ", fields[3], " ",
                     fields[4], ", is no place on Earth in metres"));
  }
  return pose;
}

}  // namespace

absl::StatusOr<std::optional<LiveItem>> ParseLiveLine(absl::string_view line) {
  const absl::string_view text = absl::StripAsciiWhitespace(line);
  if (text.empty() || text[0] == '#') return std::nullopt;
  if (text == kEnd) return LiveItem(EndOfFrames());
  const std::vector<std::string> fields =
      absl::StrSplit(text, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  if (fields.size() != kFields) {
    return absl::InvalidArgumentError(
        absl::StrCat(fields.size(),
                     " fields; a frame is COLOR DEPTH tx ty tz qx qy qz qw: "
                     "two files and the camera's pose in the world"));
  }
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 pose, ParsePose(fields));
  if (fields[0] == kPose) return LiveItem(PoseCorrection{fields[1], pose});
  return LiveItem(LiveFrame{fields[0], fields[1], pose});
}

std::unique_ptr<LiveSource> FramesOfRecording(const dataset::Dataset& dataset) {
  return std::make_unique<RecordingFrames>(dataset);
}

std::unique_ptr<LiveSource> FramesByLine(int descriptor) {
  return std::make_unique<LineFrames>(descriptor);
}

}  // namespace treeline::learning
