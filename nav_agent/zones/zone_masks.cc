#include "nav_agent/zones/zone_masks.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"

namespace treeline::zones {
namespace {

constexpr int kMaxLevel = 1000;

absl::StatusOr<ZoneMask> ReadMask(const yaml::YamlNode& yaml,
                                  const std::filesystem::path& folder) {
  TL_RETURN_IF_ERROR(
      yaml.CheckKeys({"file", "filter", "level", "base", "multiplier"}));
  ZoneMask mask;
  TL_ASSIGN_OR_RETURN(mask.name, yaml.Text("file"));
  TL_ASSIGN_OR_RETURN(
      const int filter,
      yaml.Choice("filter", {"keep-out", "speed-percent", "speed-mps"}));
  mask.kind = filter == 0 ? ZoneKind::kKeepOut : ZoneKind::kSpeed;
  mask.is_percent = filter == 1;
  TL_ASSIGN_OR_RETURN(const int64_t level,
                      yaml.IntegerOr("level", 0, 0, kMaxLevel));
  mask.level = static_cast<int>(level);
  if (filter == 0 && (yaml.Has("base") || yaml.Has("multiplier"))) {
    return yaml.Error("base and multiplier are of speed filters alone");
  }
  TL_ASSIGN_OR_RETURN(mask.base, yaml.NumberOr("base", 0, -1e6, 1e6));
  TL_ASSIGN_OR_RETURN(mask.multiplier,
                      yaml.NumberOr("multiplier", 1, -1e6, 1e6));
  const std::string file = (folder / mask.name).string();
  TL_ASSIGN_OR_RETURN(core::ValueGrid values, core::ReadMapValues(file));
  mask.values = std::make_shared<const core::ValueGrid>(std::move(values));
  return mask;
}

}  // namespace

std::optional<double> ZoneMask::Limit_mps(std::optional<int> value,
                                          double full_mps) const {
  if (!value.has_value() || *value == 0) return std::nullopt;
  const double limit = base + multiplier * *value;
  const double limit_mps = is_percent ? limit / 100 * full_mps : limit;
  if (limit_mps >= full_mps) return std::nullopt;
  return std::max(kMinZoneSpeed_mps, limit_mps);
}

absl::StatusOr<std::vector<ZoneMask>> ReadZoneMasks(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode yaml, yaml::YamlNode::Read(path));
  TL_RETURN_IF_ERROR(yaml.CheckKeys({"masks"}));
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      yaml.Items("masks"));
  if (items.empty()) return yaml.Error("it lists no masks");
  std::vector<ZoneMask> masks;
  for (const yaml::YamlNode& item : items) {
    TL_ASSIGN_OR_RETURN(
        ZoneMask mask,
        ReadMask(item, std::filesystem::path(path).parent_path()));
    masks.push_back(std::move(mask));
  }
  return masks;
}

}  // namespace treeline::zones
