#include "server/tools/capture/stray_scanner.h"

#include <algorithm>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/picture_files.h"
#include "common/dataset/text_lines.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/picture_files.h"
#include "server/tools/capture/video_reader.h"

namespace treeline::capture {
namespace {

constexpr uint64_t kMaxCsvBytes = 256u << 20;

struct CsvLine {
  int number = 0;
  std::vector<absl::string_view> fields;
};

std::vector<CsvLine> CsvLinesOf(absl::string_view text) {
  std::vector<CsvLine> lines;
  int number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty()) continue;
    CsvLine& added = lines.emplace_back();
    added.number = number;
    for (const absl::string_view field : absl::StrSplit(line, ',')) {
      added.fields.push_back(absl::StripAsciiWhitespace(field));
    }
  }
  return lines;
}

// Where each column is, by its name.
using Columns = std::map<absl::string_view, size_t>;

// The header's columns, or those of the version without one.
absl::StatusOr<Columns> ColumnsOf(const CsvLine& first, const std::string& file,
                                  bool& has_header) {
  constexpr const char* kPose[] = {"x", "y", "z", "qx", "qy", "qz", "qw"};
  double number = 0;
  has_header = !absl::SimpleAtod(first.fields[0], &number);
  Columns columns;
  for (size_t i = 0; has_header && i < first.fields.size(); ++i) {
    columns.emplace(first.fields[i], i);
  }
  for (size_t i = 0; !has_header && i < std::size(kPose); ++i) {
    columns.emplace(kPose[i], i);
  }
  for (const char* name : kPose) {
    if (columns.find(name) == columns.end()) {
      return dataset::LineError(
          file, first.number,
          absl::StrCat("has no column '", name,
                       "'; expected 'timestamp, frame, x, y, z, qx, qy, qz, "
                       "qw', as Stray Scanner writes it"));
    }
  }
  return columns;
}

// The numbers of some columns of a line. False: one of them is missing, or is
// no finite number.
class Row {
 public:
  Row(const CsvLine& line, const Columns& columns)
      : line_(line), columns_(columns) {}

  absl::string_view Field(const char* name) const {
    const auto column = columns_.find(name);
    if (column == columns_.end() || column->second >= line_.fields.size()) {
      return "";
    }
    return line_.fields[column->second];
  }
  bool Numbers(std::span<const char* const> names,
               std::span<double> numbers) const {
    for (size_t i = 0; i < names.size(); ++i) {
      if (!absl::SimpleAtod(Field(names[i]), &numbers[i]) ||
          !std::isfinite(numbers[i])) {
        return false;
      }
    }
    return true;
  }

 private:
  const CsvLine& line_;
  const Columns& columns_;
};

bool IsFrameName(absl::string_view name) {
  return !name.empty() && name.size() <= 12 &&
         std::ranges::all_of(name, absl::ascii_isdigit);
}

// The pictures of a recording with a video.
class StrayPictures final : public PictureSource {
 public:
  StrayPictures(std::unique_ptr<VideoReader> video,
                std::vector<std::pair<int, FrameFiles>> frames,
                DepthRules rules)
      : video_(std::move(video)), frames_(std::move(frames)), rules_(rules) {}

  absl::StatusOr<Pictures> Load(size_t frame) override {
    const auto& [video_frame, files] = frames_[frame];
    Pictures pictures;
    TL_ASSIGN_OR_RETURN(pictures.color, video_->Read(video_frame));
    TL_ASSIGN_OR_RETURN(pictures.depth, ReadDepth_mm(files, rules_));
    return pictures;
  }

 private:
  const std::unique_ptr<VideoReader> video_;
  const std::vector<std::pair<int, FrameFiles>> frames_;
  const DepthRules rules_;
};

// The names of the files of depth and confidence, and of a picture.
FrameFiles FilesOf(const std::string& folder, const std::string& frame) {
  return {.color = FindPicture(absl::StrCat(folder, "/rgb/", frame)),
          .depth = IfFile(absl::StrCat(folder, "/depth/", frame, ".png")),
          .confidence =
              IfFile(absl::StrCat(folder, "/confidence/", frame, ".png"))};
}

absl::StatusOr<image::ImageSize> SizeOfFirstPicture(
    const std::string& folder, const std::vector<StrayRow>& rows) {
  for (const StrayRow& row : rows) {
    const std::string color = FilesOf(folder, row.frame).color;
    if (!color.empty()) return dataset::ReadPictureSize(color);
  }
  return absl::NotFoundError(absl::StrCat(
      folder,
      ": there is neither rgb.mp4 nor a picture rgb/NNNNNN.jpg (or .png); "
      "export the whole folder of the recording"));
}

}  // namespace

absl::StatusOr<StrayOdometry> ParseStrayOdometry(absl::string_view text,
                                                 const std::string& file) {
  const std::vector<CsvLine> lines = CsvLinesOf(text);
  if (lines.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(file, ": is empty; the recording has no poses"));
  }
  bool has_header = false;
  TL_ASSIGN_OR_RETURN(const Columns columns,
                      ColumnsOf(lines.front(), file, has_header));
  constexpr const char* kPose[] = {"qw", "qx", "qy", "qz", "x", "y", "z"};
  constexpr const char* kIntrinsics[] = {"fx", "fy", "cx", "cy"};
  constexpr const char* kTime[] = {"timestamp"};
  StrayOdometry odometry;
  std::optional<double> last_time_s;
  for (size_t i = has_header ? 1 : 0; i < lines.size(); ++i) {
    const Row row(lines[i], columns);
    const std::string where = absl::StrCat(file, ":", lines[i].number);
    StrayRow parsed;
    parsed.video_frame = static_cast<int>(has_header ? i - 1 : i);
    parsed.frame = std::string(row.Field("frame"));
    if (parsed.frame.empty()) {
      parsed.frame = absl::StrFormat("%06d", parsed.video_frame);
    }
    if (!IsFrameName(parsed.frame)) {
      return dataset::LineError(
          file, lines[i].number,
          absl::StrCat("frame '", parsed.frame, "' is no number"));
    }
    std::array<double, 7> p{};
    if (!row.Numbers(kPose, p)) {
      odometry.left_out.Add("the pose has a NaN, or numbers are missing",
                            where);
      continue;
    }
    const auto pose = geometry::RigidFromQuaternion(p[0], p[1], p[2], p[3],
                                                    {p[4], p[5], p[6]});
    if (!pose.ok()) {
      odometry.left_out.Add("the quaternion is not of unit length", where);
      continue;
    }
    std::array<double, 1> time_s{};
    if (row.Numbers(kTime, time_s)) {
      if (last_time_s && time_s[0] <= *last_time_s) {
        odometry.left_out.Add(
            "its time is not later than that of the frame "
            "before",
            where);
        continue;
      }
      last_time_s = time_s[0];
    }
    parsed.world_from_camera = *pose;
    std::array<double, 4> k{};
    if (row.Numbers(kIntrinsics, k)) parsed.intrinsics = k;
    odometry.rows.push_back(std::move(parsed));
  }
  return odometry;
}

absl::StatusOr<std::array<double, 4>> ParseStrayCameraMatrix(
    absl::string_view text, const std::string& file) {
  const std::vector<CsvLine> lines = CsvLinesOf(text);
  std::array<double, 9> k{};
  if (lines.size() != 3) {
    return absl::InvalidArgumentError(
        absl::StrCat(file, ": has ", lines.size(), " lines, not 3"));
  }
  for (size_t i = 0; i < 3; ++i) {
    if (lines[i].fields.size() != 3) {
      return dataset::LineError(file, lines[i].number, "expected 3 numbers");
    }
    TL_RETURN_IF_ERROR(dataset::ParseNumbers(lines[i].fields, file,
                                             lines[i].number,
                                             std::span(k).subspan(3 * i, 3)));
  }
  return std::array<double, 4>{k[0], k[4], k[2], k[5]};
}

bool IsStrayScanner(const std::string& folder) {
  return base::IsFile(folder + "/odometry.csv");
}

absl::StatusOr<Capture> OpenStrayScanner(const std::string& folder,
                                         const OpenOptions& options) {
  const std::string odometry_path = folder + "/odometry.csv";
  TL_ASSIGN_OR_RETURN(const std::string csv,
                      base::ReadFile(odometry_path, kMaxCsvBytes));
  TL_ASSIGN_OR_RETURN(StrayOdometry odometry,
                      ParseStrayOdometry(csv, odometry_path));
  const std::string matrix_path = folder + "/camera_matrix.csv";
  TL_ASSIGN_OR_RETURN(const std::string matrix,
                      base::ReadFile(matrix_path, 1u << 16));
  TL_ASSIGN_OR_RETURN(const auto shared_k,
                      ParseStrayCameraMatrix(matrix, matrix_path));
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "y"));
  std::unique_ptr<VideoReader> video;
  image::ImageSize size;
  if (base::IsFile(folder + "/rgb.mp4")) {
    TL_ASSIGN_OR_RETURN(video, VideoReader::Open(folder + "/rgb.mp4"));
    size = video->size();
  } else {
    TL_ASSIGN_OR_RETURN(size, SizeOfFirstPicture(folder, odometry.rows));
  }
  Capture capture;
  capture.format = "stray";
  capture.left_out = std::move(odometry.left_out);
  capture.notes = {
      "world turned from ARKit's (y up); principal point half a pixel less"};
  std::vector<std::pair<int, FrameFiles>> frames;
  std::vector<FrameFiles> files;
  for (const StrayRow& row : odometry.rows) {
    const std::string name = absl::StrCat("frame ", row.frame);
    const auto [fx, fy, cx, cy] = row.intrinsics.value_or(shared_k);
    const auto camera = PinholeFromCorner(size, fx, fy, cx, cy);
    if (!camera.ok()) {
      capture.left_out.Add("its camera is none",
                           absl::StrCat(name, ": ", camera.status().message()));
      continue;
    }
    FrameFiles of_frame = FilesOf(folder, row.frame);
    if (video == nullptr && of_frame.color.empty()) {
      capture.left_out.Add("there is no picture in rgb/", name);
      continue;
    }
    capture.frames.push_back(
        {name, *camera, Rotated(z_up, row.world_from_camera)});
    files.push_back(of_frame);
    frames.emplace_back(row.video_frame, std::move(of_frame));
  }
  if (base::IsFile(folder + "/depth/000000.npy")) {
    capture.notes.push_back(
        "depth/*.npy, of an old version of the app, is not read; record anew "
        "with a newer one for depth");
  }
  const DepthRules rules{
      .unit_m = options.depth_unit_m > 0 ? options.depth_unit_m : 0.001,
      .min_confidence_value = options.min_confidence};
  if (video != nullptr) {
    capture.pictures = std::make_unique<StrayPictures>(
        std::move(video), std::move(frames), rules);
  } else {
    capture.pictures = std::make_unique<PictureFiles>(std::move(files), rules);
  }
  return capture;
}

}  // namespace treeline::capture
