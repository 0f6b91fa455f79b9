#include "server/tools/capture/rtabmap_blobs.h"

#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/image/float_depth_png.h"
#include "common/image/rvl.h"
#include "common/ros2/conversions/camera_values.h"
#include "server/tools/capture/picture_files.h"

namespace treeline::capture {
namespace {

constexpr RtabmapVersion kBinaryCalibration{{0, 18, 0}};
constexpr RtabmapVersion kCalibrationWithSize{{0, 11, 2}};
constexpr size_t kPoseFloats = 12;
constexpr size_t kHeaderInts = 11;
constexpr size_t kMaxCameras = 16;
constexpr size_t kMaxDistortion = 14;
// OpenCV's types of one channel: CV_8UC1, CV_32SC1, CV_32FC1.
constexpr int kBytesType = 0;
constexpr int kIntsType = 4;
constexpr int kFloatsType = 5;
// Of a matrix that is unpacked: poses of a million nodes need less.
constexpr size_t kMaxMatrixBytes = 64 << 20;
constexpr absl::string_view kRvlMagic = "DEPTHRVL";

absl::Status Broken(absl::string_view what) {
  return absl::InvalidArgumentError(what);
}

absl::string_view TextOf(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Takes little-endian values off the front; the caller has checked the length.
template <typename T>
T Take(Bytes& bytes) {
  std::array<uint8_t, sizeof(T)> raw{};
  std::ranges::copy(bytes.first(sizeof(T)), raw.begin());
  bytes = bytes.subspan(sizeof(T));
  return std::bit_cast<T>(raw);
}

absl::StatusOr<geometry::Rigid3> TakePose(Bytes& bytes) {
  std::array<double, 16> matrix{};
  for (size_t i = 0; i < kPoseFloats; ++i) {
    matrix[i] = static_cast<double>(Take<float>(bytes));
  }
  matrix[15] = 1;
  return geometry::RigidFromMatrix4(matrix);
}

// Of one row, of values of `type`, each of `value_bytes`.
absl::StatusOr<std::vector<uint8_t>> Uncompressed(Bytes blob, int type,
                                                  size_t value_bytes) {
  constexpr size_t kFooterBytes = 12;
  if (blob.size() < kFooterBytes) return Broken("packed matrix is cut off");
  Bytes footer = blob.last(kFooterBytes);
  const auto rows = Take<int32_t>(footer);
  const auto columns = Take<int32_t>(footer);
  const auto found = Take<int32_t>(footer);
  if (found != type) {
    return Broken(absl::StrCat("packed matrix has OpenCV's type ", found,
                               ", not ", type));
  }
  if (rows < 1 || columns < 1 ||
      static_cast<size_t>(columns) >
          kMaxMatrixBytes / value_bytes / static_cast<size_t>(rows)) {
    return Broken(
        absl::StrCat("packed matrix says it has ", rows, " x ", columns));
  }
  std::vector<uint8_t> values(static_cast<size_t>(rows) *
                              static_cast<size_t>(columns) * value_bytes);
  const std::unique_ptr<libdeflate_decompressor,
                        decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(),
                   &libdeflate_free_decompressor);
  // Without a place for the true size, it must be just as large.
  if (decompressor == nullptr ||
      libdeflate_zlib_decompress(
          decompressor.get(), blob.data(), blob.size() - kFooterBytes,
          values.data(), values.size(), nullptr) != LIBDEFLATE_SUCCESS) {
    return Broken("packed matrix is broken, or is not as large as it says");
  }
  return values;
}

// The numbers of one camera in a calibration.
struct Calibration {
  image::ImageSize size;
  std::vector<double> k;
  std::vector<double> d;
  std::vector<double> p;
  std::optional<geometry::Rigid3> base_from_camera;
};

// Those that a program with OpenCV would take for K, row by row; the fisheye
// model has zeros between its coefficients (CameraModel.cpp, load()).
messages::CameraInfo InfoOf(const Calibration& from) {
  messages::CameraInfo info;
  info.width = static_cast<uint32_t>(from.size.width);
  info.height = static_cast<uint32_t>(from.size.height);
  std::ranges::copy(from.k, info.k.begin());
  std::ranges::copy(from.p, info.p.begin());
  info.d = from.d;
  info.distortion_model = "rational_polynomial";
  if (info.d.size() == 6) {
    info.distortion_model = "equidistant";
    info.d = {from.d[0], from.d[1], from.d[4], from.d[5]};
  }
  return info;
}

absl::StatusOr<RtabmapCamera> CameraFrom(const Calibration& from) {
  RtabmapCamera result;
  if (from.k.empty() && from.p.empty()) {
    return Broken("calibration has no camera matrix");
  }
  TL_ASSIGN_OR_RETURN(result.camera,
                      conversions::CameraOf(InfoOf(from), !from.p.empty()));
  if (!from.base_from_camera) {
    return Broken("calibration does not say where the camera is");
  }
  result.base_from_camera = *from.base_from_camera;
  return result;
}

absl::Status StereoError() {
  return absl::UnimplementedError("a stereo camera");
}

absl::StatusOr<Calibration> TakeBinary(Bytes& bytes, image::ImageSize picture) {
  if (bytes.size() < 4 * kHeaderInts) return Broken("calibration is cut off");
  std::array<int32_t, kHeaderInts> header{};
  for (int32_t& value : header) value = Take<int32_t>(bytes);
  const auto [major, minor, patch, kind, width, height, k, d, r, p, pose] =
      header;
  if (kind != 0) {
    return Broken(absl::StrCat("calibration is of the unknown kind ", kind));
  }
  const auto is_either = [](int32_t value, int32_t full) {
    return value == 0 || value == full;
  };
  if (!is_either(k, 9) || !is_either(r, 9) || !is_either(p, 12) ||
      !is_either(pose, kPoseFloats) || d < 0 ||
      d > static_cast<int32_t>(kMaxDistortion)) {
    return Broken("calibration has matrices of unknown sizes");
  }
  const auto count = [](int32_t value) { return static_cast<size_t>(value); };
  if (bytes.size() <
      8 * (count(k) + count(d) + count(r) + count(p)) + 4 * count(pose)) {
    return Broken("calibration is cut off");
  }
  Calibration result;
  result.size =
      width > 0 && height > 0 ? image::ImageSize{width, height} : picture;
  const auto take = [&bytes](int32_t values) {
    std::vector<double> taken;
    for (; values > 0; --values) taken.push_back(Take<double>(bytes));
    return taken;
  };
  result.k = take(k);
  result.d = take(d);
  take(r);
  result.p = take(p);
  if (pose == 0) return result;
  TL_ASSIGN_OR_RETURN(result.base_from_camera, TakePose(bytes));
  return result;
}

absl::StatusOr<Calibration> TakeFloats(Bytes& bytes, bool has_size,
                                       image::ImageSize picture) {
  Calibration result;
  const double fx = static_cast<double>(Take<float>(bytes));
  const double fy = static_cast<double>(Take<float>(bytes));
  const double cx = static_cast<double>(Take<float>(bytes));
  const double cy = static_cast<double>(Take<float>(bytes));
  result.k = {fx, 0, cx, 0, fy, cy, 0, 0, 1};
  result.size = picture;
  if (has_size) {
    constexpr float kMaxSide_px = 1 << 20;
    const auto width = Take<float>(bytes);
    const auto height = Take<float>(bytes);
    if (width >= 1 && height >= 1 && width < kMaxSide_px &&
        height < kMaxSide_px) {
      result.size = {static_cast<int>(width), static_cast<int>(height)};
    }
  }
  TL_ASSIGN_OR_RETURN(result.base_from_camera, TakePose(bytes));
  return result;
}

absl::StatusOr<std::vector<Calibration>> TakeAll(Bytes blob,
                                                 const RtabmapVersion& version,
                                                 image::ImageSize picture) {
  std::vector<Calibration> all;
  if (version >= kBinaryCalibration) {
    if (blob.size() >= 16) {
      Bytes kind = blob.subspan(12);
      if (Take<int32_t>(kind) == 1) return StereoError();
    }
    while (!blob.empty() && all.size() <= kMaxCameras) {
      TL_ASSIGN_OR_RETURN(Calibration one, TakeBinary(blob, picture));
      all.push_back(std::move(one));
    }
    return all;
  }
  const bool has_size = version >= kCalibrationWithSize;
  const size_t camera_bytes = 4 * ((has_size ? 6 : 4) + kPoseFloats);
  if (blob.size() % camera_bytes != 0) {
    // With a baseline, and with or without a size.
    if (blob.size() == 4 * (5 + kPoseFloats) ||
        blob.size() == 4 * (7 + kPoseFloats)) {
      return StereoError();
    }
    return Broken(absl::StrCat("calibration of ", blob.size(),
                               " bytes is none of version 0.10 to 0.17"));
  }
  while (!blob.empty() && all.size() <= kMaxCameras) {
    TL_ASSIGN_OR_RETURN(Calibration one, TakeFloats(blob, has_size, picture));
    all.push_back(std::move(one));
  }
  return all;
}

// The picture's part of one of so many cameras, beside each other.
image::ImageSize PartOf(image::ImageSize picture, size_t cameras) {
  return {picture.width / static_cast<int>(cameras), picture.height};
}

}  // namespace

absl::StatusOr<RtabmapVersion> ParseRtabmapVersion(absl::string_view text) {
  RtabmapVersion version{};
  const std::vector<absl::string_view> words = absl::StrSplit(text, '.');
  bool is_version = words.size() == version.size();
  for (size_t i = 0; is_version && i < words.size(); ++i) {
    is_version = absl::SimpleAtoi(words[i], &version[i]);
  }
  if (is_version) return version;
  return Broken(absl::StrCat("'", text.substr(0, 32), "' is no version"));
}

absl::StatusOr<std::vector<RtabmapCamera>> ParseRtabmapCalibration(
    Bytes blob, const RtabmapVersion& version, image::ImageSize picture) {
  if (blob.empty()) return Broken("there is no calibration");
  TL_ASSIGN_OR_RETURN(std::vector<Calibration> all,
                      TakeAll(blob, version, picture));
  if (all.size() > kMaxCameras ||
      picture.width % static_cast<int>(all.size()) != 0) {
    return Broken(absl::StrCat(all.size(), " cameras do not share a picture ",
                               picture.width, " pixels wide"));
  }
  const image::ImageSize part = PartOf(picture, all.size());
  std::vector<RtabmapCamera> cameras;
  for (Calibration& one : all) {
    if (one.size == picture) one.size = part;
    TL_ASSIGN_OR_RETURN(RtabmapCamera camera, CameraFrom(one));
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

absl::StatusOr<geometry::Rigid3> ParseRtabmapPose(Bytes blob) {
  if (blob.size() != 4 * kPoseFloats) {
    return Broken(
        absl::StrCat("pose of ", blob.size(), " bytes, not ", 4 * kPoseFloats));
  }
  return TakePose(blob);
}

absl::StatusOr<std::map<int, geometry::Rigid3>> ParseOptimizedPoses(
    Bytes ids, Bytes poses) {
  TL_ASSIGN_OR_RETURN(const std::vector<uint8_t> id_bytes,
                      Uncompressed(ids, kIntsType, 4));
  TL_ASSIGN_OR_RETURN(const std::vector<uint8_t> pose_bytes,
                      Uncompressed(poses, kFloatsType, 4));
  if (pose_bytes.size() != kPoseFloats * id_bytes.size()) {
    return Broken(absl::StrCat(id_bytes.size() / 4, " nodes do not fit ",
                               pose_bytes.size() / 4, " numbers of poses"));
  }
  std::map<int, geometry::Rigid3> result;
  Bytes ids_left = id_bytes;
  Bytes poses_left = pose_bytes;
  while (!ids_left.empty()) {
    const auto id = Take<int32_t>(ids_left);
    const auto pose = TakePose(poses_left);
    if (pose.ok()) result[id] = *pose;
  }
  return result;
}

absl::StatusOr<std::vector<uint8_t>> ParseDepthConfidence(
    Bytes blob, image::ImageSize size) {
  TL_ASSIGN_OR_RETURN(std::vector<uint8_t> values,
                      Uncompressed(blob, kBytesType, 1));
  if (values.size() !=
      static_cast<size_t>(size.width) * static_cast<size_t>(size.height)) {
    return Broken("the confidence map has not the size of the depth map");
  }
  return values;
}

absl::StatusOr<image::DepthImage> DecodeRtabmapDepth(Bytes blob,
                                                     double unit_m) {
  absl::string_view bytes = TextOf(blob);
  if (image::IsFloatDepthPng(bytes)) return image::DecodeFloatDepthPng(bytes);
  if (!absl::ConsumePrefix(&bytes, kRvlMagic)) {
    return DecodeDepth_mm(bytes, unit_m);
  }
  TL_ASSIGN_OR_RETURN(image::DepthImage depth, image::DecodeRvl(bytes, unit_m));
  return ToMillimetres(std::move(depth));
}

}  // namespace treeline::capture
