#include "nav_agent/app/zones/zones_yaml.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"
#include "nav_agent/zones/zone.h"

namespace treeline::zones_app {
namespace {

constexpr double kFarthest_m = 1e5;
constexpr double kMostYaw_rad = 1e3;
constexpr int kMostLevels = 1000;

absl::StatusOr<v1::Zone> ReadZone(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(node.CheckKeys(
      {"name", "kind", "level", "corners", "max_mps", "direction"}));
  v1::Zone zone;
  TL_ASSIGN_OR_RETURN(std::string name, node.Text("name"));
  zone.set_name(std::move(name));
  TL_ASSIGN_OR_RETURN(const int kind,
                      node.Choice("kind", {"keep-out", "speed", "one-way"}));
  zone.set_kind(static_cast<v1::ZoneKind>(kind + 1));
  TL_ASSIGN_OR_RETURN(const int64_t level,
                      node.IntegerOr("level", 0, 0, kMostLevels));
  zone.set_level(static_cast<int32_t>(level));
  if (zone.kind() == v1::ZONE_KIND_SPEED) {
    TL_ASSIGN_OR_RETURN(const double max_mps,
                        node.Number("max_mps", zones::kMinZoneSpeed_mps,
                                    zones::kMaxZoneSpeed_mps));
    zone.set_max_mps(max_mps);
  }
  if (zone.kind() == v1::ZONE_KIND_ONE_WAY) {
    TL_ASSIGN_OR_RETURN(const double direction_rad,
                        node.Number("direction", -kMostYaw_rad, kMostYaw_rad));
    zone.set_direction_rad(direction_rad);
  }
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> corners,
                      node.Items("corners"));
  if (corners.size() < 3) return node.Error("a zone needs 3 corners at least");
  for (const yaml::YamlNode& item : corners) {
    TL_ASSIGN_OR_RETURN(const std::vector<double> at,
                        item.AsNumbers(2, -kFarthest_m, kFarthest_m));
    v1::ZoneCorner& corner = *zone.add_corners();
    corner.set_x_m(at[0]);
    corner.set_y_m(at[1]);
  }
  return zone;
}

}  // namespace

const char* KindName(v1::ZoneKind kind) {
  if (kind < v1::ZONE_KIND_KEEP_OUT || kind > v1::ZONE_KIND_ONE_WAY) {
    return "unknown";
  }
  // Numbers of the proto are one higher: 0 is "unspecified" there.
  return zones::ZoneKindName(
      static_cast<zones::ZoneKind>(static_cast<int>(kind) - 1));
}

absl::StatusOr<std::vector<v1::Zone>> ParseZones(absl::string_view text,
                                                 absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root,
                      yaml::YamlNode::Parse(text, name));
  TL_RETURN_IF_ERROR(root.CheckKeys({"zones"}));
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      root.Items("zones"));
  std::vector<v1::Zone> zones;
  for (const yaml::YamlNode& item : items) {
    TL_ASSIGN_OR_RETURN(v1::Zone zone, ReadZone(item));
    zones.push_back(std::move(zone));
  }
  if (zones.empty()) return root.Error("there are no zones in it");
  return zones;
}

std::string ZonesText(const std::vector<v1::Zone>& zones) {
  if (zones.empty()) return "zones: []\n";
  std::string text = "zones:\n";
  for (const v1::Zone& zone : zones) {
    absl::StrAppend(&text, "  - name: ", base::JsonQuoted(zone.name()),
                    "\n    kind: ", KindName(zone.kind()), "\n");
    if (zone.level() != 0) {
      absl::StrAppend(&text, "    level: ", zone.level(), "\n");
    }
    if (zone.kind() == v1::ZONE_KIND_SPEED) {
      absl::StrAppendFormat(&text, "    max_mps: %.10g\n", zone.max_mps());
    }
    if (zone.kind() == v1::ZONE_KIND_ONE_WAY) {
      absl::StrAppendFormat(&text, "    direction: %.10g\n",
                            zone.direction_rad());
    }
    absl::StrAppend(&text, "    corners:\n");
    for (const v1::ZoneCorner& corner : zone.corners()) {
      absl::StrAppendFormat(&text, "      - [%.10g, %.10g]\n", corner.x_m(),
                            corner.y_m());
    }
  }
  return text;
}

}  // namespace treeline::zones_app
