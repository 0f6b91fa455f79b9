#include "common/dataset/tum.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <tuple>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/dataset_cameras.h"
#include "common/dataset/dataset_index.h"

namespace treeline::dataset {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxTextBytes = 256u << 20;
// Ground truth comes at 100 Hz; in longer gaps the camera went unseen.
constexpr Time_ns kMaxPoseGap = 100'000'000;

// The turn rate is a mean over so long before and after a frame: what rows are
// read in.
constexpr Time_ns kTurnTime = 15'000'000;
constexpr double kNanosecond_s = 1e-9;

struct NamedCamera {
  const char* long_name;
  const char* short_name;
  const char* camera;
};

// https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
constexpr NamedCamera kCameras[] = {
    {"freiburg1", "fr1",
     "FULL_OPENCV,517.3,516.5,318.6,255.3,"
     "0.2624,-0.9531,-0.0054,0.0026,1.1633,0,0,0"},
    {"freiburg2", "fr2",
     "FULL_OPENCV,520.9,521.0,325.1,249.7,"
     "0.2312,-0.7849,-0.0033,-0.0001,0.9172,0,0,0"},
    {"freiburg3", "fr3", "PINHOLE,535.4,539.2,320.1,247.6"},
};
constexpr const char* kDefaultCamera = "PINHOLE,525,525,319.5,239.5";

std::vector<Time_ns> Times(const std::vector<TimedFile>& files) {
  std::vector<Time_ns> times;
  times.reserve(files.size());
  for (const TimedFile& file : files) times.push_back(file.time);
  return times;
}

// The path of a listed file, which must be there.
absl::StatusOr<std::string> ExistingPath(const std::string& folder,
                                         const std::string& list,
                                         const TimedFile& entry) {
  std::string path = absl::StrCat(folder, "/", entry.path);
  if (!base::IsFile(path)) {
    return absl::NotFoundError(
        absl::StrCat(list, ":", entry.line, ": there is no file ", path));
  }
  return path;
}

std::vector<std::string> StemsOf(const std::vector<TimedFile>& files) {
  std::vector<std::string> stems;
  stems.reserve(files.size());
  for (const TimedFile& file : files) stems.push_back(file.stem);
  return stems;
}

// What rgb.txt or depth.txt lists.
absl::StatusOr<std::vector<TimedFile>> ReadList(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(path, kMaxTextBytes));
  return ParseTimedFiles(text, path);
}

absl::StatusOr<std::vector<TimedPose>> ReadGroundTruth(
    const IndexRequest& request) {
  const std::string path = request.path + "/groundtruth.txt";
  if (!request.read_poses) return std::vector<TimedPose>();
  absl::StatusOr<std::string> text = base::ReadFile(path, kMaxTextBytes);
  // A recording without ground truth can still be localized.
  if (absl::IsNotFound(text.status())) return std::vector<TimedPose>();
  if (!text.ok()) return text.status();
  return ParseTimedPoses(*text, path);
}

// A ground truth of other times than the images': of another clock, say.
absl::Status CheckTimesMeet(const std::vector<TimedFile>& colors,
                            const std::vector<TimedPose>& poses,
                            const std::string& folder) {
  const auto has_pose = [&](const TimedFile& color) {
    return InterpolatePose(poses, color.time, kMaxPoseGap).has_value();
  };
  if (poses.empty() || std::ranges::any_of(colors, has_pose)) {
    return absl::OkStatus();
  }
  constexpr double kSecond_ns = 1e9;
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s/groundtruth.txt: has poses from %.3f to %.3f s, and images are of "
      "%.3f to %.3f s: none is between two poses that are at most 0.1 s apart",
      folder, static_cast<double>(poses.front().time) / kSecond_ns,
      static_cast<double>(poses.back().time) / kSecond_ns,
      static_cast<double>(colors.front().time) / kSecond_ns,
      static_cast<double>(colors.back().time) / kSecond_ns));
}

// How the pose sensor turned about `time`, about its own axes (rad/s).
std::optional<geometry::Vec3> TurnRateAt(std::span<const TimedPose> poses,
                                         Time_ns time) {
  const auto before = InterpolatePose(poses, time - kTurnTime, kMaxPoseGap);
  const auto after = InterpolatePose(poses, time + kTurnTime, kMaxPoseGap);
  if (!before || !after) return std::nullopt;
  return 1 / (2 * kNanosecond_s * static_cast<double>(kTurnTime)) *
         geometry::ToAxisAngle(before->rotation.Inverse() * after->rotation);
}

}  // namespace

std::vector<int> AssociateByTime(std::span<const Time_ns> a,
                                 std::span<const Time_ns> b,
                                 Time_ns max_difference) {
  std::vector<std::tuple<Time_ns, size_t, size_t>> pairs;
  for (size_t i = 0; i < a.size(); ++i) {
    auto first = std::upper_bound(b.begin(), b.end(), a[i] - max_difference);
    for (; first != b.end() && *first < a[i] + max_difference; ++first) {
      pairs.emplace_back(std::abs(*first - a[i]), i,
                         static_cast<size_t>(first - b.begin()));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<int> partner_of(a.size(), -1);
  std::vector<bool> taken(b.size(), false);
  for (const auto& [difference, i, j] : pairs) {
    if (partner_of[i] >= 0 || taken[j]) continue;
    partner_of[i] = static_cast<int>(j);
    taken[j] = true;
  }
  return partner_of;
}

std::optional<geometry::Rigid3> InterpolatePose(
    std::span<const TimedPose> poses, Time_ns time, Time_ns max_gap) {
  const auto after = std::lower_bound(
      poses.begin(), poses.end(), time,
      [](const TimedPose& pose, Time_ns t) { return pose.time < t; });
  if (after == poses.end()) return std::nullopt;
  if (after->time == time) return after->world_from_camera;
  if (after == poses.begin()) return std::nullopt;
  const TimedPose& from = *(after - 1);
  const Time_ns gap = after->time - from.time;
  if (gap > max_gap) return std::nullopt;
  const double t =
      static_cast<double>(time - from.time) / static_cast<double>(gap);
  const geometry::Rigid3& a = from.world_from_camera;
  const geometry::Rigid3& b = after->world_from_camera;
  return geometry::Rigid3{geometry::Slerp(a.rotation, b.rotation, t),
                          (1 - t) * a.translation + t * b.translation};
}

std::string TumColorCamera(const std::string& folder) {
  std::error_code error;
  const fs::path absolute = fs::absolute(folder, error).lexically_normal();
  const std::vector<std::string> names = absl::StrSplit(absolute.string(), '/');
  for (auto name = names.rbegin(); name != names.rend(); ++name) {
    for (const NamedCamera& entry : kCameras) {
      if (absl::StrContains(*name, entry.long_name) ||
          absl::StrContains(*name, entry.short_name)) {
        return entry.camera;
      }
    }
  }
  return kDefaultCamera;
}

absl::StatusOr<DatasetIndex> IndexTum(const IndexRequest& request) {
  DatasetIndex index;
  index.cameras = DefaultCameras{.color = TumColorCamera(request.path)};
  index.depth_unit_m = 1.0 / 5000;
  TL_RETURN_IF_ERROR(ReadCamerasFile(request.path, index));

  const std::string colors_path = request.path + "/rgb.txt";
  const absl::StatusOr<std::vector<TimedFile>> listed = ReadList(colors_path);
  if (absl::IsNotFound(listed.status())) {
    return absl::NotFoundError(
        absl::StrCat(request.path,
                     ": there is no rgb.txt; is this the folder of a "
                     "recording in the layout of TUM RGB-D?"));
  }
  TL_RETURN_IF_ERROR(listed.status());
  const std::vector<TimedFile>& colors = *listed;
  if (colors.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(colors_path, ": names no image"));
  }
  const std::string depths_path = request.path + "/depth.txt";
  std::vector<TimedFile> depths;
  // Without depth a recording can still be localized.
  if (absl::StatusOr<std::vector<TimedFile>> read = ReadList(depths_path);
      !absl::IsNotFound(read.status())) {
    TL_ASSIGN_OR_RETURN(depths, std::move(read));
  }
  TL_ASSIGN_OR_RETURN(const std::vector<TimedPose> poses,
                      ReadGroundTruth(request));
  TL_RETURN_IF_ERROR(CheckTimesMeet(colors, poses, request.path));

  const std::vector<int> depth_of = AssociateByTime(
      Times(colors), Times(depths),
      static_cast<Time_ns>(request.max_time_difference_s * 1e9));
  TL_ASSIGN_OR_RETURN(const std::vector<int32_t> selected,
                      SelectFrames(request, StemsOf(colors), colors_path));
  index.frames.reserve(selected.size());
  for (const int32_t number : selected) {
    const size_t i = static_cast<size_t>(number);
    DatasetFrame frame;
    frame.stem = colors[i].stem;
    TL_ASSIGN_OR_RETURN(frame.color_path,
                        ExistingPath(request.path, colors_path, colors[i]));
    if (depth_of[i] >= 0) {
      TL_ASSIGN_OR_RETURN(
          frame.depth_path,
          ExistingPath(request.path, depths_path,
                       depths[static_cast<size_t>(depth_of[i])]));
    }
    frame.world_from_camera =
        InterpolatePose(poses, colors[i].time, kMaxPoseGap);
    if (const auto turn_rate = TurnRateAt(poses, colors[i].time)) {
      frame.motion = {.turn_rate_rad_s = *turn_rate};
      if (depth_of[i] >= 0) {
        const Time_ns depth_time =
            depths[static_cast<size_t>(depth_of[i])].time;
        frame.motion->depth_delay_s =
            kNanosecond_s * static_cast<double>(depth_time - colors[i].time);
      }
    }
    index.frames.push_back(std::move(frame));
  }
  return index;
}

}  // namespace treeline::dataset
