#include "server/tools/capture/testing_datasets.h"

#include <libdeflate.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/image/decode.h"

namespace treeline::capture {
namespace {

void Write(const std::string& path, absl::string_view bytes) {
  if (!base::MakeParentFolder(path).ok() ||
      !base::WriteNewFile(path, bytes).ok()) {
    std::abort();
  }
}

// On the little-endian machines that these tests run on.
template <typename T>
void Append(T value, std::string& out) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), &value, sizeof(T));
  out.append(bytes.data(), bytes.size());
}

void AppendMatrix(const std::array<double, 16>& matrix, std::string& out) {
  for (const double value : matrix) Append(static_cast<float>(value), out);
}

std::array<double, 16> MatrixOf(const geometry::Rigid3& pose) {
  const geometry::Mat3 r = pose.rotation.Matrix();
  const geometry::Vec3& t = pose.translation;
  return {r(0, 0), r(0, 1), r(0, 2), t.x, r(1, 0), r(1, 1), r(1, 2), t.y,
          r(2, 0), r(2, 1), r(2, 2), t.z, 0,       0,       0,       1};
}

std::array<double, 16> IntrinsicOf(const camera::Camera& c) {
  return {c.fx(), 0, c.cx(), 0, 0, c.fy(), c.cy(), 0, 0, 0, 1, 0, 0, 0, 0, 1};
}

std::string Zlib(const std::string& bytes) {
  libdeflate_compressor* const compressor = libdeflate_alloc_compressor(6);
  std::string packed(libdeflate_zlib_compress_bound(compressor, bytes.size()),
                     '\0');
  packed.resize(libdeflate_zlib_compress(compressor, bytes.data(), bytes.size(),
                                         packed.data(), packed.size()));
  libdeflate_free_compressor(compressor);
  return packed;
}

std::string Jpeg(const image::Frame& frame) {
  return *image::EncodeJpeg(frame.color, 98);
}

}  // namespace

std::string SensBytes(const TrueScene& scene) {
  constexpr std::array<double, 16> kIdentity{1, 0, 0, 0, 0, 1, 0, 0,
                                             0, 0, 1, 0, 0, 0, 0, 1};
  constexpr absl::string_view kSensor = "StructureSensor";
  const camera::Camera& color = scene.calibration.color;
  const camera::Camera& depth = scene.calibration.depth;
  std::string bytes;
  Append(uint32_t{4}, bytes);
  Append(uint64_t{kSensor.size()}, bytes);
  absl::StrAppend(&bytes, kSensor);
  AppendMatrix(IntrinsicOf(color), bytes);
  AppendMatrix(kIdentity, bytes);
  AppendMatrix(IntrinsicOf(depth), bytes);
  AppendMatrix(kIdentity, bytes);
  Append(int32_t{2}, bytes);  // JPEG
  Append(int32_t{1}, bytes);  // zlib
  for (const int side :
       {color.width(), color.height(), depth.width(), depth.height()}) {
    Append(static_cast<uint32_t>(side), bytes);
  }
  Append(1000.0F, bytes);
  Append(uint64_t{scene.frames.size()}, bytes);
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    std::string values;
    for (const uint16_t value : scene.frames[i].depth->values) {
      Append(value, values);
    }
    const std::string jpeg = Jpeg(scene.frames[i]);
    const std::string packed = Zlib(values);
    AppendMatrix(MatrixOf(scene.world_from_camera[i]), bytes);
    for (const uint64_t number :
         {uint64_t{33'000} * i, uint64_t{33'000} * i, uint64_t{jpeg.size()},
          uint64_t{packed.size()}}) {
      Append(number, bytes);
    }
    absl::StrAppend(&bytes, jpeg, packed);
  }
  Append(uint64_t{0}, bytes);  // of the inertial sensor
  return bytes;
}

void WriteSens(const TrueScene& scene, const std::string& path) {
  Write(path, SensBytes(scene));
}

void WriteReplica(const TrueScene& scene, const std::string& folder) {
  const camera::Camera& c = scene.calibration.color;
  std::string trajectory;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    for (const double value : MatrixOf(scene.world_from_camera[i])) {
      absl::StrAppendFormat(&trajectory, "%.18e ", value);
    }
    trajectory += "\n";
    Write(absl::StrFormat("%s/results/frame%06d.jpg", folder, i),
          Jpeg(scene.frames[i]));
    Write(absl::StrFormat("%s/results/depth%06d.png", folder, i),
          *image::EncodeDepthPng(*scene.frames[i].depth));
  }
  Write(folder + "/traj.txt", trajectory);
  Write(folder + "/cam_params.json",
        absl::StrFormat(R"({"camera": {"w": %d, "h": %d, "fx": %.15g, )"
                        R"("fy": %.15g, "cx": %.15g, "cy": %.15g, )"
                        R"("scale": 1000}})",
                        c.width(), c.height(), c.fx(), c.fy(), c.cx(), c.cy()));
}

void WriteOpen3d(const TrueScene& scene, const std::string& folder) {
  const camera::Camera& c = scene.calibration.color;
  // (x, y, z) with z up is (x, -z, y) with y down.
  const geometry::Rigid3 y_down_from_world{
      geometry::Rotation3::FromMatrix({{1, 0, 0, 0, 0, -1, 0, 1, 0}}), {}};
  std::string log;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const auto m = MatrixOf(y_down_from_world * scene.world_from_camera[i]);
    absl::StrAppend(&log, i, " ", i, " ", i + 1, "\n");
    for (size_t row = 0; row < 4; ++row) {
      absl::StrAppendFormat(&log, "%.8f %.8f %.8f %.8f\n", m[4 * row],
                            m[4 * row + 1], m[4 * row + 2], m[4 * row + 3]);
    }
    Write(absl::StrFormat("%s/color/%06d.jpg", folder, i),
          Jpeg(scene.frames[i]));
    Write(absl::StrFormat("%s/depth/%06d.png", folder, i),
          *image::EncodeDepthPng(*scene.frames[i].depth));
  }
  Write(folder + "/scene/trajectory.log", log);
  Write(folder + "/camera_intrinsic.json",
        absl::StrFormat(R"({"width": %d, "height": %d, "intrinsic_matrix": )"
                        R"([%.15g, 0, 0, 0, %.15g, 0, %.15g, %.15g, 1]})",
                        c.width(), c.height(), c.fx(), c.fy(), c.cx(), c.cy()));
}

}  // namespace treeline::capture
