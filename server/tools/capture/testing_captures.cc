#include "server/tools/capture/testing_captures.h"

#include <libdeflate.h>

#include <array>
#include <bit>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/image/decode.h"
#include "server/core/training/box_room_recording.h"

namespace treeline::capture {
namespace {

using Matrix = std::array<double, 16>;

void Write(const std::string& path, absl::string_view bytes) {
  if (!base::MakeParentFolder(path).ok() ||
      !base::WriteNewFile(path, bytes).ok()) {
    std::abort();
  }
}

void WritePng(const std::string& path, const image::DepthImage& depth) {
  Write(path, *image::EncodeDepthPng(depth));
}

// What the confidence map of a whole frame is: one value.
void WriteConfidence(const std::string& path, const image::DepthImage& depth,
                     uint8_t value) {
  image::ColorImage map{depth.width, depth.height, {}};
  map.rgb.assign(depth.values.size() * 3, value);
  Write(path, *image::EncodePng(map));
}

// Writes the matrix of the track header (ISO 14496-12, 8.3.2): x' = a x + c y,
// y' = b x + d y. Where it moves the picture to matters to nobody here.
void AskForTurn(image::QuarterTurn turn, const std::string& path) {
  constexpr size_t kMatrix = 44;  // from the box's type on, in version 0
  constexpr std::array<std::array<int, 4>, 4> kTurns = {
      {{1, 0, 0, 1}, {0, 1, -1, 0}, {-1, 0, 0, -1}, {0, -1, 1, 0}}};
  const std::array<int, 4>& turned = kTurns[static_cast<size_t>(turn)];
  std::string bytes = *base::ReadFile(path);
  const size_t box = bytes.find("tkhd");
  if (box == std::string::npos || bytes[box + 4] != 0) std::abort();
  for (size_t i = 0; i < turned.size(); ++i) {
    // a, b, u, c, d: 16.16 bits, big-endian.
    const size_t at = box + kMatrix + 4 * (i < 2 ? i : i + 1);
    const char whole = static_cast<char>(turned[i]);
    const char sign = static_cast<char>(turned[i] < 0 ? -1 : 0);
    bytes[at] = sign;
    bytes[at + 1] = whole;
    bytes[at + 2] = bytes[at + 3] = 0;
  }
  std::filesystem::remove(path);
  Write(path, bytes);
}

std::string Jpeg(const image::Frame& frame) {
  return *image::EncodeJpeg(frame.color, 98);
}

// ARKit: x right, y up, z backwards; the world has y up. With z up, (x, y, z)
// of ARKit's world is (x, -z, y), so its rows are x, z and -y of ours.
Matrix Arkit(const geometry::Rigid3& pose) {
  const geometry::Mat3 r = pose.rotation.Matrix();
  const geometry::Vec3& t = pose.translation;
  Matrix m{};
  const int row_of[] = {0, 2, 1};
  const double sign_of[] = {1, 1, -1};
  for (int row = 0; row < 3; ++row) {
    const int from = row_of[row];
    const double sign = sign_of[row];
    double* const out = m.data() + 4 * row;
    out[0] = sign * r(from, 0);
    out[1] = -sign * r(from, 1);
    out[2] = -sign * r(from, 2);
    out[3] = sign * t[from];
  }
  m[15] = 1;
  return m;
}

// OpenGL's camera in a world with z up.
Matrix OpenGl(const geometry::Rigid3& pose) {
  const geometry::Mat3 r = pose.rotation.Matrix();
  const geometry::Vec3& t = pose.translation;
  Matrix m{};
  for (int row = 0; row < 3; ++row) {
    double* const out = m.data() + 4 * row;
    out[0] = r(row, 0);
    out[1] = -r(row, 1);
    out[2] = -r(row, 2);
    out[3] = t[row];
  }
  m[15] = 1;
  return m;
}

std::string Rows(const Matrix& m) {
  return absl::StrFormat(
      "[[%.15g,%.15g,%.15g,%.15g],[%.15g,%.15g,%.15g,%.15g],"
      "[%.15g,%.15g,%.15g,%.15g],[0,0,0,1]]",
      m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11]);
}

std::string Flat(const Matrix& m) {
  std::string text = "[";
  for (size_t i = 0; i < m.size(); ++i) {
    absl::StrAppendFormat(&text, "%s%.15g", i > 0 ? "," : "", m[i]);
  }
  return text + "]";
}

// The quaternion of a rotation whose matrix has these columns of a pose in
// ARKit's world: x, y and z of our camera.
geometry::Rotation3 CvRotationInArkitWorld(const geometry::Rigid3& pose) {
  const Matrix m = Arkit(pose);
  return geometry::Rotation3::FromMatrix(
      {{m[0], -m[1], -m[2], m[4], -m[5], -m[6], m[8], -m[9], -m[10]}});
}

void WriteStrayTables(const TrueScene& scene, const std::string& folder) {
  std::string csv = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const Matrix m = Arkit(scene.world_from_camera[i]);
    const geometry::Rotation3 q =
        CvRotationInArkitWorld(scene.world_from_camera[i]);
    absl::StrAppendFormat(
        &csv, "%.6f, %06d, %.12g, %.12g, %.12g, %.12g, %.12g, %.12g, %.12g\n",
        1000 + static_cast<double>(i) / 60, i, m[3], m[7], m[11], q.x, q.y, q.z,
        q.w);
    const std::string name = absl::StrFormat("%06d.png", i);
    WritePng(absl::StrCat(folder, "/depth/", name), *scene.frames[i].depth);
    WriteConfidence(absl::StrCat(folder, "/confidence/", name),
                    *scene.frames[i].depth, 2);
  }
  Write(folder + "/odometry.csv", csv);
  const camera::Camera& c = scene.calibration.color;
  Write(folder + "/camera_matrix.csv",
        absl::StrFormat("%.12g, 0.0, %.12g\n0.0, %.12g, %.12g\n0.0, 0.0, 1.0",
                        c.fx(), c.cx() + 0.5, c.fy(), c.cy() + 0.5));
}

void AppendLittleEndian(uint32_t value, int bytes, std::string& out) {
  for (int i = 0; i < bytes; ++i) {
    out.push_back(static_cast<char>(value >> (8 * i)));
  }
}

// A stream of one block that is not compressed.
std::string RawLzfse(const std::string& bytes) {
  std::string stream = "bvx-";
  AppendLittleEndian(static_cast<uint32_t>(bytes.size()), 4, stream);
  return absl::StrCat(stream, bytes, "bvx$");
}

}  // namespace

TrueScene MakeTrueScene(int frames) {
  TrueScene scene;
  camera::RgbdCalibration& calibration = scene.calibration;
  calibration.color =
      *camera::Camera::Parse("PINHOLE,200,201,127.25,95.75", 256, 192);
  // A quarter of it, by the centres of the pixels: (x + 0.5) / 4 - 0.5.
  calibration.depth =
      *camera::Camera::Parse("PINHOLE,50,50.25,31.4375,23.5625", 64, 48);
  calibration.pose_sensor = camera::RgbdSensor::kColor;
  // The room's own world has y down.
  const geometry::Rigid3 world_from_room{
      geometry::Rotation3::FromAxisAngle({-std::numbers::pi / 2, 0, 0}),
      {0.25, -0.5, 1.5}};
  for (const geometry::Rigid3& pose : training::BoxRoomPoses(frames)) {
    scene.frames.push_back(training::RenderBoxRoom(calibration, pose));
    scene.world_from_camera.push_back(world_from_room * pose);
  }
  return scene;
}

void WriteNerfstudio(const TrueScene& scene, const std::string& folder) {
  const camera::Camera& c = scene.calibration.color;
  std::string json = absl::StrFormat(
      R"({"camera_model":"OPENCV","fl_x":%.15g,"fl_y":%.15g,"cx":%.15g,)"
      R"("cy":%.15g,"w":%d,"h":%d,"k1":0,"applied_transform":)"
      R"([[1,0,0,0],[0,1,0,0],[0,0,1,0]],"frames":[)",
      c.fx(), c.fy(), c.cx() + 0.5, c.cy() + 0.5, c.width(), c.height());
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const std::string name = absl::StrFormat("frame_%d", i + 1);
    absl::StrAppend(&json, i > 0 ? "," : "", R"({"file_path":"./images/)", name,
                    R"(.jpg","depth_file_path":"./depths/)", name,
                    R"(.png","transform_matrix":)",
                    Rows(OpenGl(scene.world_from_camera[i])), "}");
    Write(absl::StrCat(folder, "/images/", name, ".jpg"),
          Jpeg(scene.frames[i]));
    WritePng(absl::StrCat(folder, "/depths/", name, ".png"),
             *scene.frames[i].depth);
  }
  Write(folder + "/transforms.json", json + "]}");
}

void WriteStray(const TrueScene& scene, const std::string& folder) {
  WriteStrayTables(scene, folder);
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    Write(absl::StrFormat("%s/rgb/%06d.jpg", folder, i), Jpeg(scene.frames[i]));
  }
}

void WriteStrayVideo(const TrueScene& scene, const std::string& folder) {
  WriteStrayTables(scene, folder);
  std::vector<image::ColorImage> pictures;
  for (const image::Frame& frame : scene.frames) {
    pictures.push_back(frame.color);
  }
  WriteVideo(pictures, image::QuarterTurn::kNone, folder + "/rgb.mp4");
}

void WriteVideo(const std::vector<image::ColorImage>& pictures,
                image::QuarterTurn shown_turn, const std::string& path) {
  cv::VideoWriter video(path, cv::CAP_FFMPEG,
                        cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 60,
                        cv::Size(pictures[0].width, pictures[0].height));
  if (!video.isOpened()) std::abort();
  for (const image::ColorImage& picture : pictures) {
    const cv::Mat rgb(picture.height, picture.width, CV_8UC3,
                      const_cast<uint8_t*>(picture.rgb.data()));
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    video.write(bgr);
  }
  video.release();
  if (shown_turn != image::QuarterTurn::kNone) AskForTurn(shown_turn, path);
}

void WritePolycam(const TrueScene& scene, const std::string& folder) {
  const camera::Camera& c = scene.calibration.color;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const Matrix m = Arkit(scene.world_from_camera[i]);
    const std::string time = absl::StrCat(5412300000 + 33333 * i);
    std::string json = absl::StrFormat(
        R"({"fx":%.15g,"fy":%.15g,"cx":%.15g,"cy":%.15g,"width":%d,)"
        R"("height":%d,"blur_score":90.5)",
        c.fx(), c.fy(), c.cx() + 0.5, c.cy() + 0.5, c.width(), c.height());
    for (size_t k = 0; k < 12; ++k) {
      absl::StrAppendFormat(&json, R"(,"t_%d%d":%.15g)", k / 4, k % 4, m[k]);
    }
    const std::string keyframes = folder + "/keyframes/";
    Write(absl::StrCat(keyframes, "corrected_cameras/", time, ".json"),
          json + "}");
    Write(absl::StrCat(keyframes, "corrected_images/", time, ".jpg"),
          Jpeg(scene.frames[i]));
    WritePng(absl::StrCat(keyframes, "depth/", time, ".png"),
             *scene.frames[i].depth);
    WriteConfidence(absl::StrCat(keyframes, "confidence/", time, ".png"),
                    *scene.frames[i].depth, 127);
  }
}

void WriteScannerApp(const TrueScene& scene, const std::string& folder) {
  const camera::Camera& c = scene.calibration.color;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    Write(absl::StrFormat("%s/frame_%05d.json", folder, i),
          absl::StrFormat(
              R"({"cameraPoseARFrame":%s,"intrinsics":[%.15g,0,%.15g,0,)"
              R"(%.15g,%.15g,0,0,1],"motionQuality":1,"time":%d})",
              Flat(Arkit(scene.world_from_camera[i])), c.fx(), c.cx() + 0.5,
              c.fy(), c.cy() + 0.5, i));
    Write(absl::StrFormat("%s/frame_%05d.jpg", folder, i),
          Jpeg(scene.frames[i]));
    WritePng(absl::StrFormat("%s/depth_%05d.png", folder, i),
             *scene.frames[i].depth);
    WriteConfidence(absl::StrFormat("%s/conf_%05d.png", folder, i),
                    *scene.frames[i].depth, 2);
  }
  Write(folder + "/info.json", R"({"device":"test"})");
}

void WriteRecord3d(const TrueScene& scene, const std::string& folder) {
  const camera::Camera& c = scene.calibration.color;
  std::string poses;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    // OpenGL's camera in ARKit's world: the columns of y and z change signs.
    const Matrix m = Arkit(scene.world_from_camera[i]);
    const geometry::Rotation3 q = geometry::Rotation3::FromMatrix(
        {{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}});
    absl::StrAppendFormat(
        &poses, "%s[%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g]",
        i > 0 ? "," : "", q.x, q.y, q.z, q.w, m[3], m[7], m[11]);
    const std::string base = absl::StrCat(folder, "/rgbd/", i);
    Write(base + ".jpg", Jpeg(scene.frames[i]));
    std::string floats;
    for (const uint16_t depth_mm : scene.frames[i].depth->values) {
      AppendLittleEndian(std::bit_cast<uint32_t>(0.001f * depth_mm), 4, floats);
    }
    Write(base + ".depth", RawLzfse(floats));
    Write(base + ".conf", RawLzfse(std::string(floats.size() / 4, 2)));
  }
  Write(folder + "/metadata",
        absl::StrFormat(
            R"({"w":%d,"h":%d,"dw":%d,"dh":%d,"fps":60,)"
            R"("K":[%.15g,0,0,0,%.15g,0,%.15g,%.15g,1],"poses":[%s]})",
            c.width(), c.height(), scene.calibration.depth.width(),
            scene.calibration.depth.height(), c.fx(), c.fy(), c.cx() + 0.5,
            c.cy() + 0.5, poses));
}

std::string ZipOf(
    const std::vector<std::pair<std::string, std::string>>& files) {
  std::string zip;
  std::string directory;
  for (const auto& [name, contents] : files) {
    std::string packed(contents.size() + 100, '\0');
    libdeflate_compressor* const compressor = libdeflate_alloc_compressor(6);
    packed.resize(libdeflate_deflate_compress(compressor, contents.data(),
                                              contents.size(), packed.data(),
                                              packed.size()));
    libdeflate_free_compressor(compressor);
    // Version, flags, method, time, date, checksum, sizes, lengths of names.
    std::string common;
    AppendLittleEndian(20, 2, common);
    AppendLittleEndian(0, 2, common);
    AppendLittleEndian(8, 2, common);
    AppendLittleEndian(0, 4, common);
    AppendLittleEndian(libdeflate_crc32(0, contents.data(), contents.size()), 4,
                       common);
    AppendLittleEndian(static_cast<uint32_t>(packed.size()), 4, common);
    AppendLittleEndian(static_cast<uint32_t>(contents.size()), 4, common);
    AppendLittleEndian(static_cast<uint32_t>(name.size()), 2, common);
    AppendLittleEndian(0, 2, common);
    absl::StrAppend(&directory, "PK\x01\x02");
    AppendLittleEndian(20, 2, directory);
    absl::StrAppend(&directory, common, std::string(10, '\0'));
    AppendLittleEndian(static_cast<uint32_t>(zip.size()), 4, directory);
    absl::StrAppend(&directory, name);
    absl::StrAppend(&zip, "PK\x03\x04", common, name, packed);
  }
  const auto offset = static_cast<uint32_t>(zip.size());
  absl::StrAppend(&zip, directory, "PK\x05\x06", std::string(4, '\0'));
  AppendLittleEndian(static_cast<uint32_t>(files.size()), 2, zip);
  AppendLittleEndian(static_cast<uint32_t>(files.size()), 2, zip);
  AppendLittleEndian(static_cast<uint32_t>(directory.size()), 4, zip);
  AppendLittleEndian(offset, 4, zip);
  AppendLittleEndian(0, 2, zip);
  return zip;
}

void WriteScanNet(const TrueScene& scene, const std::string& folder) {
  const auto intrinsic = [](const camera::Camera& c) {
    return absl::StrFormat(
        "%.12f 0 %.12f 0\n0 %.12f %.12f 0\n0 0 1 0\n0 0 0 1\n", c.fx(), c.cx(),
        c.fy(), c.cy());
  };
  Write(folder + "/intrinsic/intrinsic_color.txt",
        intrinsic(scene.calibration.color));
  Write(folder + "/intrinsic/intrinsic_depth.txt",
        intrinsic(scene.calibration.depth));
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    const geometry::Rigid3& pose = scene.world_from_camera[i];
    const geometry::Mat3 r = pose.rotation.Matrix();
    std::string text;
    for (int row = 0; row < 3; ++row) {
      absl::StrAppendFormat(&text, "%.12f %.12f %.12f %.12f\n", r(row, 0),
                            r(row, 1), r(row, 2), pose.translation[row]);
    }
    Write(absl::StrCat(folder, "/pose/", i, ".txt"), text + "0 0 0 1\n");
    Write(absl::StrCat(folder, "/color/", i, ".jpg"), Jpeg(scene.frames[i]));
    WritePng(absl::StrCat(folder, "/depth/", i, ".png"),
             *scene.frames[i].depth);
  }
}

}  // namespace treeline::capture
