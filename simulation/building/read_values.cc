#include "simulation/building/read_values.h"

#include <algorithm>
#include <array>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/building/catalogue.h"
#include "simulation/building/plan_geometry.h"

namespace treeline::building {

absl::StatusOr<std::vector<yaml::YamlNode>> ReadList(
    const yaml::YamlNode& file, absl::string_view key,
    std::initializer_list<absl::string_view> known, size_t most) {
  TL_ASSIGN_OR_RETURN(std::vector<yaml::YamlNode> items, file.Items(key));
  if (items.size() > most) {
    return items[most].Error(
        absl::StrCat("more than ", most, " in '", key, "'"));
  }
  for (const yaml::YamlNode& item : items)
    TL_RETURN_IF_ERROR(item.CheckKeys(known));
  return items;
}

absl::StatusOr<std::string> ReadName(const yaml::YamlNode& node) {
  TL_ASSIGN_OR_RETURN(std::string name, node.Text("name"));
  const bool is_plain = std::all_of(name.begin(), name.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' ||
           c == '_';
  });
  if (name.empty() || name.size() > 40 || !is_plain) {
    return node.Error("a name has 1..40 letters, digits, '-' and '_'");
  }
  return name;
}

absl::StatusOr<PlanPoint> ReadPoint(const yaml::YamlNode& node,
                                    const BuildingPlan& plan) {
  const auto elements = node.Elements();
  if (!elements.ok() || elements->size() < 2 || elements->size() > 3) {
    return node.Error("a point is [x, y] or [x, y, z]");
  }
  std::array<double, 3> values{};
  for (size_t i = 0; i < elements->size(); ++i) {
    TL_ASSIGN_OR_RETURN(values[i], (*elements)[i].AsNumber(0, kMaxSize_m));
    if (values[i] > plan.size_m[i]) {
      return node.Error(
          absl::StrCat(values[i], " m is outside the building, which ends at ",
                       plan.size_m[i], " m"));
    }
  }
  PlanPoint point{.x_m = values[0], .y_m = values[1]};
  if (elements->size() == 3) point.z_m = values[2];
  return point;
}

absl::StatusOr<PlanPoint> ReadPointAt(const yaml::YamlNode& node,
                                      absl::string_view key,
                                      const BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode value, node.Get(key));
  return ReadPoint(value, plan);
}

absl::StatusOr<PlanPoint> ReadGroundPoint(const yaml::YamlNode& node,
                                          const BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const PlanPoint point, ReadPoint(node, plan));
  if (!GroundAt(plan, point).has_value()) {
    return node.Error(
        absl::StrCat("there is no ground at [", point.x_m, ", ", point.y_m,
                     point.z_m ? absl::StrCat(", ", *point.z_m) : "", "]"));
  }
  return point;
}

absl::StatusOr<PlanStand> ReadStand(const yaml::YamlNode& node,
                                    const BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode at, node.Get("at"));
  PlanStand stand;
  TL_ASSIGN_OR_RETURN(stand.at, ReadGroundPoint(at, plan));
  TL_ASSIGN_OR_RETURN(stand.facing_deg, ReadFacing(node, 90));
  return stand;
}

absl::StatusOr<PlanArea> ReadArea(const yaml::YamlNode& node,
                                  const BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const std::vector<double> v,
                      node.Numbers("area", 4, 0, kMaxSize_m));
  const PlanArea area = {v[0], v[1], v[2], v[3]};
  if (area.x1_m - area.x0_m < 0.3 || area.y1_m - area.y0_m < 0.3) {
    return node.Error(
        "area is [x0, y0, x1, y1] with x1 and y1 at least 0.3 larger");
  }
  if (area.x1_m > plan.size_m[0] || area.y1_m > plan.size_m[1]) {
    return node.Error(absl::StrCat("area is outside the building of ",
                                   plan.size_m[0], " x ", plan.size_m[1],
                                   " m"));
  }
  return area;
}

absl::Status CheckFinish(const yaml::YamlNode& node, absl::string_view finish,
                         const BuildingPlan& plan) {
  std::vector<absl::string_view> known(Materials().begin(), Materials().end());
  for (const PlanFinish& own : plan.finishes) known.push_back(own.name);
  if (std::find(known.begin(), known.end(), finish) != known.end()) {
    return absl::OkStatus();
  }
  return node.Error(absl::StrCat("unknown finish '", finish.substr(0, 40), "'",
                                 Suggestion(finish.substr(0, 40), known)));
}

absl::StatusOr<std::string> ReadFinish(const yaml::YamlNode& node,
                                       absl::string_view key,
                                       absl::string_view otherwise,
                                       const BuildingPlan& plan) {
  if (!node.Has(key)) return std::string(otherwise);
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode value, node.Get(key));
  TL_ASSIGN_OR_RETURN(std::string finish, value.AsText());
  TL_RETURN_IF_ERROR(CheckFinish(value, finish, plan));
  return finish;
}

absl::StatusOr<PlanLamps> ReadLamps(const yaml::YamlNode& node) {
  if (!node.Has("lamps")) return PlanLamps{};
  TL_ASSIGN_OR_RETURN(const std::vector<double> count,
                      node.Numbers("lamps", 2, 0, 20));
  const PlanLamps lamps = {static_cast<int>(count[0]),
                           static_cast<int>(count[1])};
  if (lamps.along_x != count[0] || lamps.along_y != count[1]) {
    return node.Error("lamps are two whole numbers: along x, along y");
  }
  return lamps;
}

absl::StatusOr<double> ReadFacing(const yaml::YamlNode& node,
                                  double otherwise_deg) {
  if (!node.Has("facing")) return otherwise_deg;
  TL_ASSIGN_OR_RETURN(const std::string text, node.Text("facing"));
  double facing_deg = 0;
  for (const absl::string_view name : {"east", "north", "west", "south"}) {
    if (text == name) return facing_deg;
    facing_deg += 90;
  }
  const auto number = node.Number("facing", -360, 360);
  if (number.ok()) return number;
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode value, node.Get("facing"));
  return value.Error(
      "facing is east, north, west, south, or degrees from the east in "
      "-360..360");
}

}  // namespace treeline::building
