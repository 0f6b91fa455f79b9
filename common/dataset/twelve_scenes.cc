// Stanford's 4-Scenes (12-Scenes) recordings.
#include "common/dataset/twelve_scenes.h"

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/frame_files.h"
#include "common/dataset/text_lines.h"

namespace treeline::dataset {
namespace {

constexpr FrameFileFormat kFiles = {
    .color_endings = {".color.jpg", ".color.png"},
    .infinite_pose_is_none = true};

std::vector<ListedStem> ScanStems(const std::string& folder) {
  std::vector<ListedStem> stems;
  for (std::string& name : FrameNamesIn(folder, kFiles)) {
    stems.push_back({std::move(name), 0});
  }
  return stems;
}

// The values of "name = values", by name.
struct Entry {
  std::vector<absl::string_view> words;
  int line = 0;
};

class InfoText {
 public:
  InfoText(absl::string_view text, const std::string& file) : file_(file) {
    int number = 0;
    for (absl::string_view line : absl::StrSplit(text, '\n')) {
      ++number;
      const std::vector<absl::string_view> sides =
          absl::StrSplit(line, absl::MaxSplits('=', 1));
      if (sides.size() != 2) continue;
      entries_[std::string(absl::StripAsciiWhitespace(sides[0]))] = {
          absl::StrSplit(sides[1], absl::ByAnyChar(" \t\r"), absl::SkipEmpty()),
          number};
    }
  }

  absl::Status Numbers(const char* name, std::span<double> numbers) const {
    const auto entry = entries_.find(name);
    if (entry == entries_.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat(file_, ": has no line '", name, " = ...'"));
    }
    const auto& [words, line] = entry->second;
    if (words.size() != numbers.size()) {
      return LineError(file_, line,
                       absl::StrCat(name, " has ", words.size(),
                                    " numbers, not ", numbers.size()));
    }
    return ParseNumbers(words, file_, line, numbers);
  }

  // A pinhole from the size and the 4 x 4 matrix of intrinsics of a sensor.
  absl::StatusOr<camera::Camera> CameraOf(const std::string& sensor) const {
    std::array<double, 1> width{};
    std::array<double, 1> height{};
    std::array<double, 16> k{};
    TL_RETURN_IF_ERROR(
        Numbers(absl::StrCat("m_", sensor, "Width").c_str(), width));
    TL_RETURN_IF_ERROR(
        Numbers(absl::StrCat("m_", sensor, "Height").c_str(), height));
    const std::string name = absl::StrCat(
        "m_calibration", sensor == "color" ? "Color" : "Depth", "Intrinsic");
    TL_RETURN_IF_ERROR(Numbers(name.c_str(), k));
    const auto size = [](double pixels) {
      return static_cast<int>(std::clamp(pixels, 0.0, 1e6));
    };
    const double pinhole[] = {k[0], k[5], k[2], k[6]};
    const absl::StatusOr<camera::Camera> camera =
        camera::Camera::Create(camera::CameraModel::kPinhole, size(width[0]),
                               size(height[0]), pinhole, 4);
    if (!camera.ok()) {
      return base::Annotate(camera.status(), absl::StrCat(file_, ": ", name));
    }
    return camera;
  }

  absl::StatusOr<geometry::Rigid3> ExtrinsicOf(const char* name) const {
    std::array<double, 16> matrix{};
    TL_RETURN_IF_ERROR(Numbers(name, matrix));
    const absl::StatusOr<geometry::Rigid3> pose =
        geometry::RigidFromMatrix4(matrix);
    if (!pose.ok()) {
      return base::Annotate(pose.status(), absl::StrCat(file_, ": ", name));
    }
    return pose;
  }

  absl::StatusOr<double> DepthUnit_m() const {
    std::array<double, 1> shift{};
    TL_RETURN_IF_ERROR(Numbers("m_depthShift", shift));
    if (!(shift[0] > 0)) {
      return absl::InvalidArgumentError(
          absl::StrCat(file_, ": m_depthShift is not positive"));
    }
    return 1 / shift[0];
  }

 private:
  const std::string& file_;
  std::map<std::string, Entry> entries_;
};

}  // namespace

absl::StatusOr<TwelveScenesInfo> ParseTwelveScenesInfo(
    absl::string_view text, const std::string& file) {
  const InfoText entries(text, file);
  TwelveScenesInfo info;
  camera::RgbdCalibration& calibration = info.calibration;
  TL_ASSIGN_OR_RETURN(calibration.color, entries.CameraOf("color"));
  TL_ASSIGN_OR_RETURN(calibration.depth, entries.CameraOf("depth"));
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 rig_from_color,
                      entries.ExtrinsicOf("m_calibrationColorExtrinsic"));
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 rig_from_depth,
                      entries.ExtrinsicOf("m_calibrationDepthExtrinsic"));
  calibration.color_from_depth = rig_from_color.Inverse() * rig_from_depth;
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  TL_ASSIGN_OR_RETURN(info.depth_unit_m, entries.DepthUnit_m());
  return info;
}

absl::StatusOr<DatasetIndex> IndexTwelveScenes(const IndexRequest& request) {
  const std::string info_path = request.path + "/info.txt";
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(info_path, 1 << 20));
  TL_ASSIGN_OR_RETURN(const TwelveScenesInfo info,
                      ParseTwelveScenesInfo(text, info_path));
  DatasetIndex index;
  index.cameras = info.calibration;
  index.depth_unit_m = info.depth_unit_m;
  const std::string folder = request.path + "/data";
  const std::vector<ListedStem> stems =
      request.stems.empty() ? ScanStems(folder) : request.stems;
  if (stems.empty()) {
    return absl::NotFoundError(
        absl::StrCat(folder, ": no frames frame-*.color.jpg (or .png)"));
  }
  for (const ListedStem& listed : stems) {
    TL_ASSIGN_OR_RETURN(DatasetFrame frame,
                        IndexFrameFiles(request, folder, kFiles, listed));
    index.frames.push_back(std::move(frame));
  }
  return index;
}

}  // namespace treeline::dataset
