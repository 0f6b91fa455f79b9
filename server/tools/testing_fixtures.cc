#include "server/tools/testing_fixtures.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "absl/strings/str_format.h"
#include "common/image/decode.h"

namespace treeline::tools {
namespace {

constexpr int kWidth = 8;
constexpr int kHeight = 6;

std::string Stem(int i) { return absl::StrFormat("seq-01/frame-%06d", i); }

void WriteBytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

void WritePose(const std::string& path, const geometry::Rigid3& pose) {
  const geometry::Mat3 r = pose.rotation.Matrix();
  std::ofstream file(path);
  file.precision(17);
  for (int row = 0; row < 3; ++row) {
    file << r(row, 0) << ' ' << r(row, 1) << ' ' << r(row, 2) << ' '
         << pose.translation[row] << '\n';
  }
  file << "0 0 0 1\n";
}

}  // namespace

SmallRecording::SmallRecording(int frames,
                               const std::vector<geometry::Rigid3>& poses) {
  std::string name =
      (std::filesystem::temp_directory_path() / "recording_XXXXXX").string();
  folder_ = mkdtemp(name.data());
  std::filesystem::create_directory(folder_ + "/seq-01");
  for (int i = 0; i < frames; ++i) {
    image::ColorImage color{kWidth, kHeight, {}};
    color.rgb.assign(3 * kWidth * kHeight, 100);
    color.rgb[0] = static_cast<uint8_t>(i);
    WriteBytes(ColorPath(i), image::EncodePng(color).value());
    image::DepthImage depth{kWidth, kHeight, {}, 0.001};
    depth.values.assign(kWidth * kHeight, 2000);
    const std::string base = folder_ + "/" + Stem(i);
    WriteBytes(base + ".depth.png", image::EncodeDepthPng(depth).value());
    if (static_cast<size_t>(i) < poses.size()) {
      WritePose(base + ".pose.txt", poses[static_cast<size_t>(i)]);
    }
  }
}

SmallRecording::~SmallRecording() { std::filesystem::remove_all(folder_); }

dataset::DatasetOptions SmallRecording::options() const {
  dataset::DatasetOptions options;
  options.uri = "7scenes:" + folder_;
  options.color_camera = "PINHOLE,10,10,4,3";
  options.depth_camera = "PINHOLE,11,11,4,3";
  return options;
}

dataset::Dataset SmallRecording::Open() const {
  return dataset::Dataset::Open(options()).value();
}

std::string SmallRecording::ColorPath(int i) const {
  return folder_ + "/" + Stem(i) + ".color.png";
}

TestFolder::TestFolder() {
  std::string name =
      (std::filesystem::temp_directory_path() / "treeline_XXXXXX").string();
  path_ = mkdtemp(name.data());
}

TestFolder::~TestFolder() { std::filesystem::remove_all(path_); }

std::string TestFolder::operator/(const std::string& name) const {
  return path_ + "/" + name;
}

dataset::DatasetOptions BoxRoomOptions(const std::string& folder) {
  dataset::DatasetOptions options;
  options.uri = "7scenes:" + folder;
  options.color_camera = options.depth_camera = "PINHOLE,145,145,100,75";
  options.pose_file = folder + "/poses.txt";
  return options;
}

localizer::PoseEstimate LocalizedAt(const geometry::Rigid3& world_from_camera) {
  localizer::PoseEstimate estimate;
  estimate.outcome = localizer::Outcome::kLocalized;
  estimate.reason = localizer::NotLocalizedReason::kNone;
  estimate.world_from_camera = world_from_camera;
  estimate.inliers = 40;
  estimate.samples = 50;
  estimate.inlier_ratio = 0.8;
  return estimate;
}

}  // namespace treeline::tools
