#include "server/tools/capture/posed_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_lines.h"
#include "server/tools/capture/conventions.h"

namespace treeline::capture {
namespace {

constexpr size_t kMatrixNumbers = 16;
constexpr double kMostFrames = 1 << 24;

// The lines with words in them, and their numbers in the file.
struct Line {
  int number = 0;
  std::vector<absl::string_view> words;
};

std::vector<Line> WordsOf(absl::string_view text) {
  std::vector<Line> lines;
  int number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    std::vector<absl::string_view> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (!words.empty()) lines.push_back({number, std::move(words)});
  }
  return lines;
}

// Lost frames have words in place of numbers.
bool HasLostPose(std::span<const absl::string_view> words) {
  return std::ranges::any_of(words, [](absl::string_view word) {
    const std::string lower = absl::AsciiStrToLower(word);
    return absl::StrContains(lower, "nan") || absl::StrContains(lower, "inf");
  });
}

absl::Status LostPose() { return absl::NotFoundError("tracking was lost"); }

}  // namespace

absl::StatusOr<ListedPoses> ParsePoseLines(absl::string_view text,
                                           const std::string& file) {
  ListedPoses poses;
  for (const Line& line : WordsOf(text)) {
    std::array<double, kMatrixNumbers> matrix{};
    if (line.words.size() != matrix.size()) {
      return dataset::LineError(file, line.number,
                                "expected the 16 numbers of a pose");
    }
    if (HasLostPose(line.words)) {
      poses.insert({poses.size(), LostPose()});
      continue;
    }
    TL_RETURN_IF_ERROR(
        dataset::ParseNumbers(line.words, file, line.number, matrix));
    poses.insert({poses.size(), geometry::RigidFromMatrix4(matrix)});
  }
  return poses;
}

absl::StatusOr<ListedPoses> ParsePoseLog(absl::string_view text,
                                         const std::string& file) {
  constexpr size_t kLinesOfPose = 5;
  const std::vector<Line> lines = WordsOf(text);
  ListedPoses poses;
  for (size_t at = 0; at < lines.size(); at += kLinesOfPose) {
    const Line& head = lines[at];
    std::array<double, 3> numbers{};
    if (head.words.size() != numbers.size() ||
        lines.size() - at < kLinesOfPose) {
      return dataset::LineError(
          file, head.number,
          "expected a line of 3 numbers and 4 lines of 4, for each frame");
    }
    TL_RETURN_IF_ERROR(
        dataset::ParseNumbers(head.words, file, head.number, numbers));
    if (!(numbers[0] >= 0) || numbers[0] > kMostFrames ||
        std::floor(numbers[0]) != numbers[0]) {
      return dataset::LineError(file, head.number, "is no number of a frame");
    }
    std::array<double, kMatrixNumbers> matrix{};
    bool is_lost = false;
    for (size_t row = 0; row < 4; ++row) {
      const Line& line = lines[at + 1 + row];
      if (line.words.size() != 4) {
        return dataset::LineError(file, line.number, "expected 4 numbers");
      }
      is_lost = is_lost || HasLostPose(line.words);
      if (is_lost) continue;
      TL_RETURN_IF_ERROR(
          dataset::ParseNumbers(line.words, file, line.number,
                                std::span(matrix).subspan(4 * row, 4)));
    }
    const auto frame = static_cast<size_t>(numbers[0]);
    const auto pose = is_lost ? absl::StatusOr<geometry::Rigid3>(LostPose())
                              : geometry::RigidFromMatrix4(matrix);
    if (!poses.insert({frame, pose}).second) {
      return dataset::LineError(file, head.number,
                                "has a pose for the same frame again");
    }
  }
  return poses;
}

Capture CaptureOf(PosedPictures pictures) {
  Capture capture;
  capture.format = std::move(pictures.format);
  capture.notes = std::move(pictures.notes);
  std::vector<FrameFiles> files;
  for (size_t i = 0; i < pictures.files.size(); ++i) {
    FrameFiles& of_frame = pictures.files[i];
    const auto pose = pictures.poses.find(i);
    if (pose == pictures.poses.end()) {
      capture.left_out.Add("there is no pose", of_frame.color);
      continue;
    }
    const auto& world_from_camera = pose->second;
    if (!world_from_camera.ok()) {
      capture.left_out.Add(absl::IsNotFound(world_from_camera.status())
                               ? "tracking was lost"
                               : "the pose is not rigid",
                           of_frame.color);
      continue;
    }
    capture.frames.push_back({of_frame.color, pictures.color,
                              Rotated(pictures.z_up, *world_from_camera)});
    files.push_back(std::move(of_frame));
  }
  capture.pictures = std::make_unique<PictureFiles>(
      std::move(files), DepthRules{.unit_m = pictures.depth_unit_m});
  return capture;
}

}  // namespace treeline::capture
