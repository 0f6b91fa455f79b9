#include "server/tools/capture/sens_file.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/folder.h"
#include "common/base/input_file.h"
#include "common/base/status_macros.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/picture_files.h"

namespace treeline::capture {
namespace {

constexpr uint32_t kVersion = 4;
constexpr uint64_t kMaxName_bytes = 1 << 16;
// No picture of these sizes needs more.
constexpr uint64_t kMaxPicture_bytes = 128 << 20;
constexpr uint64_t kMaxFrames = 1 << 20;
constexpr size_t kMatrixFloats = 16;
constexpr int32_t kPng = 1;
constexpr int32_t kJpeg = 2;
constexpr int32_t kPlain = 0;
constexpr int32_t kZlib = 1;

using Matrix = std::array<double, kMatrixFloats>;

absl::Status Bad(absl::string_view what) {
  return absl::InvalidArgumentError(what);
}

// Reads on from one place to the next.
class Cursor {
 public:
  Cursor(const ReadBytes& read, uint64_t size) : read_(read), size_(size) {}

  uint64_t at() const { return at_; }
  uint64_t left() const { return size_ - at_; }
  absl::Status Skip(uint64_t bytes) {
    if (bytes > left()) return Bad("the file is cut off");
    at_ += bytes;
    return absl::OkStatus();
  }

  template <typename T>
  absl::StatusOr<T> Take() {
    std::array<uint8_t, sizeof(T)> raw{};
    const uint64_t from = at_;
    TL_RETURN_IF_ERROR(Skip(sizeof(T)));
    TL_RETURN_IF_ERROR(read_(from, raw));
    return std::bit_cast<T>(raw);
  }

  absl::StatusOr<Matrix> TakeMatrix() {
    std::array<uint8_t, 4 * kMatrixFloats> raw{};
    const uint64_t from = at_;
    TL_RETURN_IF_ERROR(Skip(raw.size()));
    TL_RETURN_IF_ERROR(read_(from, raw));
    const auto floats = std::bit_cast<std::array<float, kMatrixFloats>>(raw);
    Matrix matrix{};
    std::ranges::copy(floats, matrix.begin());
    return matrix;
  }

 private:
  const ReadBytes& read_;
  const uint64_t size_;
  uint64_t at_ = 0;
};

absl::StatusOr<camera::Camera> CameraOf(const Matrix& k, uint32_t width,
                                        uint32_t height) {
  const std::array<double, 4> pinhole{k[0], k[5], k[2], k[6]};
  const auto side = [](uint32_t pixels) {
    return static_cast<int>(std::min(pixels, 1U << 20));
  };
  return camera::Camera::Create(camera::CameraModel::kPinhole, side(width),
                                side(height), pinhole.data(), 4);
}

// Where the depth camera is, if the file says it. ScanNet's are identities.
geometry::Rigid3 ColorFromDepth(const Matrix& color, const Matrix& depth) {
  const auto base_from_color = geometry::RigidFromMatrix4(color);
  const auto base_from_depth = geometry::RigidFromMatrix4(depth);
  if (!base_from_color.ok() || !base_from_depth.ok()) return {};
  return base_from_color->Inverse() * *base_from_depth;
}

absl::Status TakeFrame(Cursor& file, SensContents& contents) {
  SensFrame frame;
  TL_ASSIGN_OR_RETURN(frame.world_from_camera, file.TakeMatrix());
  TL_RETURN_IF_ERROR(file.Skip(2 * sizeof(uint64_t)));  // times
  TL_ASSIGN_OR_RETURN(frame.color_bytes, file.Take<uint64_t>());
  TL_ASSIGN_OR_RETURN(frame.depth_bytes, file.Take<uint64_t>());
  frame.color_offset = file.at();
  TL_RETURN_IF_ERROR(file.Skip(frame.color_bytes));
  frame.depth_offset = file.at();
  TL_RETURN_IF_ERROR(file.Skip(frame.depth_bytes));
  contents.frames.push_back(frame);
  return absl::OkStatus();
}

absl::Status CheckPacking(int32_t color, int32_t depth,
                          SensContents& contents) {
  if (color != kPng && color != kJpeg) {
    return Bad(absl::StrCat("colour is packed in way ", color,
                            "; 1 (PNG) and 2 (JPEG) are read"));
  }
  if (depth != kPlain && depth != kZlib) {
    return Bad(absl::StrCat("depth is packed in way ", depth,
                            "; 0 (not) and 1 (zlib) are read: export it with "
                            "ScanNet's SensReader"));
  }
  contents.depth_is_packed = depth == kZlib;
  return absl::OkStatus();
}

class SensPictures final : public PictureSource {
 public:
  SensPictures(base::InputFile file, SensContents contents,
               std::vector<size_t> frames)
      : file_(std::move(file)),
        contents_(std::move(contents)),
        frames_(std::move(frames)) {}

  absl::StatusOr<Pictures> Load(size_t frame) override {
    const SensFrame& of_frame = contents_.frames[frames_.at(frame)];
    Pictures pictures;
    TL_ASSIGN_OR_RETURN(pictures.encoded_color,
                        Bytes(of_frame.color_offset, of_frame.color_bytes));
    TL_ASSIGN_OR_RETURN(pictures.color,
                        image::DecodeColor(pictures.encoded_color));
    if (of_frame.depth_bytes == 0) return pictures;
    TL_ASSIGN_OR_RETURN(const std::string depth,
                        Bytes(of_frame.depth_offset, of_frame.depth_bytes));
    TL_ASSIGN_OR_RETURN(pictures.depth, DecodeSensDepth(depth, contents_));
    return pictures;
  }

 private:
  absl::StatusOr<std::string> Bytes(uint64_t offset, uint64_t count) const {
    if (count > kMaxPicture_bytes) return Bad("a picture is too large");
    std::string bytes(count, '\0');
    TL_RETURN_IF_ERROR(file_.ReadAt(
        offset, {reinterpret_cast<uint8_t*>(bytes.data()), bytes.size()}));
    return bytes;
  }

  const base::InputFile file_;
  const SensContents contents_;
  const std::vector<size_t> frames_;  // of contents_
};

}  // namespace

absl::StatusOr<SensContents> ReadSens(const ReadBytes& read, uint64_t size) {
  Cursor file(read, size);
  TL_ASSIGN_OR_RETURN(const auto version, file.Take<uint32_t>());
  TL_ASSIGN_OR_RETURN(const auto name_bytes, file.Take<uint64_t>());
  if (version != kVersion || name_bytes > kMaxName_bytes) {
    return Bad(absl::StrCat("is no .sens file of version ", kVersion));
  }
  TL_RETURN_IF_ERROR(file.Skip(name_bytes));
  std::array<Matrix, 4> matrices{};
  for (Matrix& matrix : matrices) {
    TL_ASSIGN_OR_RETURN(matrix, file.TakeMatrix());
  }
  SensContents contents;
  TL_ASSIGN_OR_RETURN(const auto color_packing, file.Take<int32_t>());
  TL_ASSIGN_OR_RETURN(const auto depth_packing, file.Take<int32_t>());
  TL_RETURN_IF_ERROR(CheckPacking(color_packing, depth_packing, contents));
  std::array<uint32_t, 4> sides{};
  for (uint32_t& side : sides) {
    TL_ASSIGN_OR_RETURN(side, file.Take<uint32_t>());
  }
  TL_ASSIGN_OR_RETURN(contents.color,
                      CameraOf(matrices[0], sides[0], sides[1]));
  TL_ASSIGN_OR_RETURN(contents.depth,
                      CameraOf(matrices[2], sides[2], sides[3]));
  contents.color_from_depth = ColorFromDepth(matrices[1], matrices[3]);
  TL_ASSIGN_OR_RETURN(const auto units_in_metre, file.Take<float>());
  if (!(units_in_metre >= 1) || !std::isfinite(units_in_metre)) {
    return Bad(absl::StrCat("has ", units_in_metre, " units of depth a metre"));
  }
  contents.depth_unit_m = 1 / static_cast<double>(units_in_metre);
  TL_ASSIGN_OR_RETURN(const auto frames, file.Take<uint64_t>());
  for (uint64_t i = 0; i < std::min(frames, kMaxFrames); ++i) {
    if (TakeFrame(file, contents).ok()) continue;
    contents.cut_off = frames - i;
    break;
  }
  return contents;
}

absl::StatusOr<image::DepthImage> DecodeSensDepth(
    absl::string_view bytes, const SensContents& contents) {
  const auto width = static_cast<size_t>(contents.depth.width());
  const auto height = static_cast<size_t>(contents.depth.height());
  std::vector<uint8_t> values(2 * width * height);
  if (!contents.depth_is_packed) {
    if (bytes.size() != values.size()) return Bad("depth of another size");
    std::ranges::copy(bytes, values.begin());
  } else {
    const std::unique_ptr<libdeflate_decompressor,
                          decltype(&libdeflate_free_decompressor)>
        decompressor(libdeflate_alloc_decompressor(),
                     &libdeflate_free_decompressor);
    if (decompressor == nullptr ||
        libdeflate_zlib_decompress(decompressor.get(), bytes.data(),
                                   bytes.size(), values.data(), values.size(),
                                   nullptr) != LIBDEFLATE_SUCCESS) {
      return Bad("depth is broken, or has another size");
    }
  }
  image::DepthImage depth{.width = contents.depth.width(),
                          .height = contents.depth.height(),
                          .values = {},
                          .unit_m = contents.depth_unit_m};
  depth.values.reserve(width * height);
  for (size_t i = 0; i < values.size(); i += 2) {
    depth.values.push_back(
        static_cast<uint16_t>(values[i] | values[i + 1] << 8));
  }
  return ToMillimetres(std::move(depth));
}

bool IsSens(const std::string& path) {
  return absl::EndsWith(path, ".sens") && base::IsFile(path);
}

absl::StatusOr<Capture> OpenSens(const std::string& path,
                                 const OpenOptions& options) {
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "z"));
  TL_ASSIGN_OR_RETURN(base::InputFile file, base::InputFile::Open(path));
  auto read = ReadSens(
      [&file](uint64_t offset, std::span<uint8_t> out) {
        return file.ReadAt(offset, out);
      },
      file.size());
  if (!read.ok()) return base::Annotate(read.status(), path);
  SensContents contents = *std::move(read);
  if (options.depth_unit_m > 0) contents.depth_unit_m = options.depth_unit_m;
  Capture capture;
  capture.format = "sens";
  capture.depth = contents.depth;
  capture.color_from_depth = contents.color_from_depth;
  capture.notes = {"poses and cameras as they are; pixel centres at integers"};
  if (contents.cut_off > 0) {
    capture.notes.push_back(absl::StrCat("the file is cut off: its last ",
                                         contents.cut_off,
                                         " frames are not there"));
  }
  std::vector<size_t> frames;
  for (size_t i = 0; i < contents.frames.size(); ++i) {
    const std::string name = absl::StrCat("frame ", i);
    const Matrix& matrix = contents.frames[i].world_from_camera;
    if (std::isinf(matrix[0])) {
      capture.left_out.Add("tracking was lost", name);
      continue;
    }
    const auto pose = geometry::RigidFromMatrix4(matrix);
    if (!pose.ok()) {
      capture.left_out.Add("the pose is not rigid", name);
      continue;
    }
    capture.frames.push_back({name, contents.color, Rotated(z_up, *pose)});
    frames.push_back(i);
  }
  capture.pictures = std::make_unique<SensPictures>(
      std::move(file), std::move(contents), std::move(frames));
  return capture;
}

}  // namespace treeline::capture
