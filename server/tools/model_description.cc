#include "server/tools/model_description.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace treeline::tools {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;
constexpr double kMillisecondsPerSecond = 1000;

std::string OrUnknown(const std::string& text) {
  return text.empty() ? "unknown" : text;
}

std::string FormatVector(geometry::Vec3 v, const char* unit) {
  return absl::StrFormat("%.3f  %.3f  %.3f %s", v.x, v.y, v.z, unit);
}

// Six digits say all that a calibration knows.
std::string FormatCamera(const camera::Camera& camera) {
  std::string text(camera::CameraModelName(camera.model()));
  for (int i = 0; i < camera::CameraParameterCount(camera.model()); ++i) {
    absl::StrAppendFormat(&text, " %.6g",
                          camera.parameters()[static_cast<size_t>(i)]);
  }
  return absl::StrCat(text, ", ", camera.width(), " x ", camera.height());
}

DescriptionSection Origin(const forest::ModelInfo& model) {
  DescriptionSection section{"Origin", {}};
  section.rows = {
      {"method", OrUnknown(model.method)},
      {"dataset", OrUnknown(model.dataset)},
      {"created", OrUnknown(model.created_utc)},
      {"by", absl::StrCat("treeline ", OrUnknown(model.software_version))},
      {"seed", absl::StrCat(model.seed)},
  };
  if (model.part) {
    section.rows.push_back(
        {"part", absl::StrCat("tree ", model.part->tree, " of ",
                              model.part->trees, ", for `treeline merge`")});
  }
  // A baseline is no file.
  if (model.format_version > 0) {
    section.rows.push_back({"checksum", OrUnknown(model.checksum)});
    section.rows.push_back(
        {"format version", absl::StrCat(model.format_version)});
  }
  return section;
}

DescriptionSection Size(const forest::ModelInfo& model) {
  DescriptionSection section{"Size", {}};
  const char* place = model.format_version > 0 ? "file" : "memory";
  section.rows.push_back({place, FormatBytes(model.file_bytes)});
  if (model.memory_bytes > 0) {
    section.rows.push_back({"memory", FormatBytes(model.memory_bytes)});
  }
  if (model.trees > 0) {
    section.rows.push_back({"trees", FormatCount(model.trees)});
    section.rows.push_back({"nodes", FormatCount(model.nodes)});
    section.rows.push_back({"leaves", FormatCount(model.leaves)});
  }
  const geometry::Vec3& low = model.bounds_min_in_world;
  const geometry::Vec3& high = model.bounds_max_in_world;
  section.rows.insert(
      section.rows.end(),
      {{"training frames", FormatCount(model.training_frames)},
       {"training samples", FormatCount(model.training_samples)},
       {"training time", FormatNumber("%.1f s", model.training_s)},
       {"bounds, lowest", FormatVector(low, "m")},
       {"bounds, highest", FormatVector(high, "m")},
       {"extent", FormatVector(high - low, "m")}});
  return section;
}

DescriptionSection Calibration(const camera::RgbdCalibration& calibration) {
  DescriptionSection section{"Calibration", {}};
  const geometry::Rigid3& color_from_depth = calibration.color_from_depth;
  const double angle_deg =
      geometry::Norm(geometry::ToAxisAngle(color_from_depth.rotation)) *
      kDegreesPerRadian;
  section.rows = {
      {"colour camera", FormatCamera(calibration.color)},
      {"depth camera", FormatCamera(calibration.depth)},
      {"depth camera in colour camera",
       FormatVector(100 * color_from_depth.translation, "cm")},
      {"rotation between them", FormatNumber("%.3f deg", angle_deg)},
      {"depth scale",
       FormatNumber("%.5f world units a metre", calibration.depth_scale)},
      {"poses are of the", calibration.pose_sensor == camera::RgbdSensor::kColor
                               ? "colour camera"
                               : "depth camera"},
  };
  return section;
}

DescriptionRow Shutter(const image::RollingShutter& shutter) {
  return {"rolling shutter",
          absl::StrFormat("rows are read in %.1f ms, the middle one %.1f ms "
                          "after the time stamp",
                          kMillisecondsPerSecond * shutter.readout_s,
                          kMillisecondsPerSecond * shutter.offset_s)};
}

}  // namespace

std::vector<DescriptionSection> DescribeModel(const forest::ModelInfo& model) {
  std::vector<DescriptionSection> sections{Origin(model), Size(model),
                                           Calibration(model.calibration)};
  if (model.shutter) sections.back().rows.push_back(Shutter(*model.shutter));
  if (!model.options.empty()) {
    sections.push_back({"Options", {}});
    for (const auto& [name, value] : model.options) {
      sections.back().rows.emplace_back(name, value.empty() ? "-" : value);
    }
  }
  return sections;
}

DescriptionSection DescribeSizes(
    std::span<const forest::SectionSize> sections) {
  // The number of each kind is docs/reference/model-format.md's.
  struct Group {
    const char* name;
    std::vector<uint32_t> kinds;
    uint64_t file_bytes = 0;
    uint64_t memory_bytes = 0;
  };
  std::vector<Group> groups = {{"splits of trees", {3, 4}},
                               {"descriptors of leaves", {5, 7}},
                               {"positions of leaves", {2, 6, 14}},
                               {"points of keyframes", {8, 9}},
                               {"features of keyframes", {10, 12, 13}},
                               {"appearance", {11}},
                               {"information", {}}};
  for (const forest::SectionSize& section : sections) {
    const auto group = std::ranges::find_if(groups, [&](const Group& g) {
      return g.kinds.empty() || std::ranges::count(g.kinds, section.kind) > 0;
    });
    group->file_bytes += section.file_bytes;
    group->memory_bytes += section.memory_bytes;
  }
  DescriptionSection described{"What takes it", {}};
  for (const Group& group : groups) {
    if (group.file_bytes == 0) continue;
    std::string size = FormatBytes(group.file_bytes);
    if (group.memory_bytes != group.file_bytes) {
      absl::StrAppend(&size, ", in memory ", FormatBytes(group.memory_bytes));
    }
    described.rows.emplace_back(group.name, std::move(size));
  }
  return described;
}

std::string DescriptionText(const std::vector<DescriptionSection>& sections) {
  size_t width = 0;
  for (const DescriptionSection& section : sections) {
    for (const DescriptionRow& row : section.rows) {
      width = std::max(width, row.first.size());
    }
  }
  std::string text;
  for (const DescriptionSection& section : sections) {
    absl::StrAppend(&text, text.empty() ? "" : "\n", section.title, "\n");
    for (const auto& [name, value] : section.rows) {
      absl::StrAppend(&text, "  ", name,
                      std::string(width - name.size() + 2, ' '), value, "\n");
    }
  }
  return text;
}

std::string FormatBytes(uint64_t bytes) {
  constexpr std::array<const char*, 4> kUnits{"B", "kB", "MB", "GB"};
  auto value = static_cast<double>(bytes);
  size_t unit = 0;
  while (value >= 999.5 && unit + 1 < kUnits.size()) {
    value /= 1000;
    ++unit;
  }
  return unit == 0 ? absl::StrCat(bytes, " B")
                   : absl::StrFormat("%.1f %s", value, kUnits[unit]);
}

std::string FormatCount(int64_t count) {
  std::string digits = absl::StrCat(count);
  const size_t first = count < 0 ? 1 : 0;
  for (size_t i = digits.size(); i > first + 3;) {
    i -= 3;
    digits.insert(i, ",");
  }
  return digits;
}

std::string FormatNumber(const char* format, double value) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

}  // namespace treeline::tools
