#include "simulation/recorder/record_files.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::recorder {
namespace {

constexpr char kSequence[] = "seq-01";
// TUM: five thousand to the metre.
constexpr int kTumPerMillimetre = 5;

std::string FrameName(int frame) {
  return absl::StrFormat("frame-%06d", frame);
}

// Between the two qualities, by chance of seed and frame.
int QualityOf(const RecordOptions& options, int frame) {
  base::Random random(options.seed ^ 0x19e6, static_cast<uint64_t>(frame));
  const int span = options.jpeg_quality - options.lowest_jpeg_quality + 1;
  return options.lowest_jpeg_quality +
         static_cast<int>(random.NextBelow(static_cast<uint32_t>(span)));
}

// In fifths of a millimetre; what does not fit (13 m) is not measured.
image::DepthImage InTumUnits(image::DepthImage depth) {
  depth.unit_m = 0.001 / kTumPerMillimetre;
  for (uint16_t& value : depth.values) {
    const int scaled = image::IsMeasured(value) ? value * kTumPerMillimetre : 0;
    value = static_cast<uint16_t>(scaled < 65535 ? scaled : 0);
  }
  return depth;
}

}  // namespace

std::string TimeText(dataset::Time_ns time) {
  const dataset::Time_ns microseconds = (time + 500) / 1000;
  return absl::StrFormat("%d.%06d", microseconds / 1000000,
                         microseconds % 1000000);
}

std::string StemOf(const RecordOptions& options, int frame,
                   dataset::Time_ns time) {
  return options.format == RecordFormat::kTum
             ? TimeText(time)
             : absl::StrCat(kSequence, "/", FrameName(frame));
}

std::vector<std::string> FoldersOf(const RecordOptions& options) {
  std::vector<std::string> folders = {kSequence};
  if (options.format == RecordFormat::kTum) folders = {"rgb", "depth"};
  if (options.has_truth) folders.push_back("truth");
  return folders;
}

absl::Status WriteFrameFiles(const RecordOptions& options,
                             const std::string& folder, int index,
                             dataset::Time_ns time, const image::Frame& frame,
                             const geometry::Rigid3& world_from_camera) {
  TL_ASSIGN_OR_RETURN(
      const std::string color,
      image::EncodeJpeg(frame.color, QualityOf(options, index)));
  if (options.format == RecordFormat::kTum) {
    TL_ASSIGN_OR_RETURN(const std::string depth,
                        image::EncodeDepthPng(InTumUnits(*frame.depth)));
    const std::string name = TimeText(time);
    TL_RETURN_IF_ERROR(
        base::WriteNewFile(absl::StrCat(folder, "/rgb/", name, ".jpg"), color));
    return base::WriteNewFile(absl::StrCat(folder, "/depth/", name, ".png"),
                              depth);
  }
  const std::string base =
      absl::StrCat(folder, "/", kSequence, "/", FrameName(index));
  TL_ASSIGN_OR_RETURN(const std::string depth,
                      image::EncodeDepthPng(*frame.depth));
  TL_RETURN_IF_ERROR(base::WriteNewFile(base + ".color.jpg", color));
  TL_RETURN_IF_ERROR(base::WriteNewFile(base + ".depth.png", depth));
  return base::WriteNewFile(base + ".pose.txt",
                            dataset::FormatPoseMatrix(world_from_camera));
}

absl::Status WriteTruthFiles(const std::string& folder, int index,
                             const renderer::PixelRays& rays,
                             const std::vector<renderer::PixelTruth>& truth) {
  constexpr uint32_t kFirstBody = 60000;
  image::ColorImage normals{
      .width = rays.width(), .height = rays.height(), .rgb = {}};
  image::DepthImage surfaces{
      .width = rays.width(), .height = rays.height(), .values = {}};
  image::DepthImage kinds = surfaces;
  const auto byte = [](float component) {
    return static_cast<uint8_t>(
        std::lround(127.5f * (std::clamp(component, -1.0f, 1.0f) + 1)));
  };
  for (const renderer::PixelTruth& pixel : truth) {
    const bool is_seen = pixel.surface != renderer::RayHit::kNothing;
    const worlds::Float3& n = pixel.normal_in_camera;
    for (const float component : {n.x, n.y, n.z}) {
      normals.rgb.push_back(is_seen ? byte(component) : uint8_t{0});
    }
    const uint32_t id =
        pixel.instance == renderer::RayHit::kFixed
            ? std::min(pixel.surface, kFirstBody - 2) + 1
            : std::min(kFirstBody + static_cast<uint32_t>(pixel.instance),
                       65535u);
    surfaces.values.push_back(is_seen ? static_cast<uint16_t>(id)
                                      : uint16_t{0});
    kinds.values.push_back(static_cast<uint16_t>(
        is_seen ? static_cast<unsigned>(pixel.kind) + 1 : 0u));
  }
  const std::string base = absl::StrFormat("%s/truth/%06d", folder, index);
  TL_ASSIGN_OR_RETURN(const std::string normal_png, image::EncodePng(normals));
  TL_ASSIGN_OR_RETURN(const std::string surface_png,
                      image::EncodeDepthPng(surfaces));
  TL_ASSIGN_OR_RETURN(const std::string kind_png, image::EncodeDepthPng(kinds));
  TL_RETURN_IF_ERROR(base::WriteNewFile(base + ".normal.png", normal_png));
  TL_RETURN_IF_ERROR(base::WriteNewFile(base + ".surface.png", surface_png));
  return base::WriteNewFile(base + ".kind.png", kind_png);
}

std::vector<NamedText> TumLists(const std::vector<dataset::TimedPose>& frames,
                                const std::string& world) {
  std::string colors = absl::StrCat("# color images\n# world: ", world,
                                    "\n# timestamp filename\n");
  std::string depths = absl::StrCat("# depth maps\n# world: ", world,
                                    "\n# timestamp filename\n");
  std::string poses =
      absl::StrCat("# ground truth trajectory\n# world: ", world,
                   "\n# timestamp tx ty tz qx qy qz qw\n");
  for (const dataset::TimedPose& frame : frames) {
    const std::string time = TimeText(frame.time);
    absl::StrAppend(&colors, time, " rgb/", time, ".jpg\n");
    absl::StrAppend(&depths, time, " depth/", time, ".png\n");
    const geometry::Vec3& t = frame.world_from_camera.translation;
    const geometry::Rotation3 q = Normalized(frame.world_from_camera.rotation);
    absl::StrAppendFormat(&poses, "%s %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n",
                          time, t.x, t.y, t.z, q.x, q.y, q.z, q.w);
  }
  return {{"rgb.txt", std::move(colors)},
          {"depth.txt", std::move(depths)},
          {"groundtruth.txt", std::move(poses)}};
}

}  // namespace treeline::recorder
