#include "nav_agent/app/zones/zones_yaml.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"

namespace treeline::zones_app {
namespace {

constexpr double kFarthest_m = 1e5;
constexpr double kMostYaw_rad = 1e3;
constexpr int kMostLevels = 1000;

absl::StatusOr<zones::Zone> ReadZone(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(node.CheckKeys(
      {"name", "kind", "level", "corners", "max_mps", "direction"}));
  zones::Zone zone;
  TL_ASSIGN_OR_RETURN(zone.name, node.Text("name"));
  TL_ASSIGN_OR_RETURN(const int kind,
                      node.Choice("kind", {"keep-out", "speed", "one-way"}));
  zone.kind = static_cast<zones::ZoneKind>(kind);
  TL_ASSIGN_OR_RETURN(const int64_t level,
                      node.IntegerOr("level", 0, 0, kMostLevels));
  zone.level = static_cast<int>(level);
  if (zone.kind == zones::ZoneKind::kSpeed) {
    TL_ASSIGN_OR_RETURN(zone.max_mps,
                        node.Number("max_mps", zones::kMinZoneSpeed_mps,
                                    zones::kMaxZoneSpeed_mps));
  }
  if (zone.kind == zones::ZoneKind::kOneWay) {
    TL_ASSIGN_OR_RETURN(zone.direction_rad,
                        node.Number("direction", -kMostYaw_rad, kMostYaw_rad));
  }
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> corners,
                      node.Items("corners"));
  if (corners.size() < 3) return node.Error("a zone needs 3 corners at least");
  for (const yaml::YamlNode& item : corners) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> at,
                        item.AsNumbers(2, -kFarthest_m, kFarthest_m));
    zone.corners_in_map.push_back({at[0], at[1]});
  }
  return zone;
}

}  // namespace

absl::StatusOr<std::vector<zones::Zone>> ParseZones(absl::string_view text,
                                                    absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root,
                      yaml::YamlNode::Parse(text, name));
  TL_RETURN_IF_ERROR(root.CheckKeys({"zones"}));
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      root.Items("zones"));
  std::vector<zones::Zone> zones;
  for (const yaml::YamlNode& item : items) {
    TL_ASSIGN_OR_RETURN(zones::Zone zone, ReadZone(item));
    zones.push_back(std::move(zone));
  }
  if (zones.empty()) return root.Error("there are no zones in it");
  return zones;
}

std::string ZonesText(const std::vector<zones::Zone>& zones) {
  if (zones.empty()) return "zones: []\n";
  std::string text = "zones:\n";
  for (const zones::Zone& zone : zones) {
    absl::StrAppend(&text, "  - name: ", base::JsonQuoted(zone.name),
                    "\n    kind: ", zones::ZoneKindName(zone.kind), "\n");
    if (zone.level != 0) {
      absl::StrAppend(&text, "    level: ", zone.level, "\n");
    }
    if (zone.kind == zones::ZoneKind::kSpeed) {
      absl::StrAppendFormat(&text, "    max_mps: %.10g\n", zone.max_mps);
    }
    if (zone.kind == zones::ZoneKind::kOneWay) {
      absl::StrAppendFormat(&text, "    direction: %.10g\n",
                            zone.direction_rad);
    }
    absl::StrAppend(&text, "    corners:\n");
    for (const geometry::Vec2& corner : zone.corners_in_map) {
      absl::StrAppendFormat(&text, "      - [%.10g, %.10g]\n", corner.x,
                            corner.y);
    }
  }
  return text;
}

}  // namespace treeline::zones_app
