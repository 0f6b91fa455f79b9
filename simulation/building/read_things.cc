#include "simulation/building/read_things.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "simulation/building/catalogue.h"
#include "simulation/building/plan_geometry.h"
#include "simulation/building/read_values.h"

namespace treeline::building {
namespace {

// Least wall on either side of a door or window.
constexpr double kMargin_m = 0.05;

absl::StatusOr<WallRef> ReadWallRef(const yaml::YamlNode& item,
                                    const BuildingPlan& plan,
                                    PlanOnWall& place) {
  TL_ASSIGN_OR_RETURN(place.wall, item.Text("wall"));
  const auto ref = FindWall(plan, place.wall);
  if (!ref.has_value()) {
    const std::vector<std::string> names = WallNames(plan);
    const std::vector<absl::string_view> known(names.begin(), names.end());
    return item.Error(absl::StrCat(
        "there is no wall '", place.wall.substr(0, 80), "'",
        known.size() > 24
            ? "; walls are ROOM.north and the like, or a wall's name"
            : Suggestion(place.wall.substr(0, 80), known)));
  }
  TL_ASSIGN_OR_RETURN(place.at_m, item.Number("at", 0, kMaxSize_m));
  return *ref;
}

absl::Status CheckSpan(const yaml::YamlNode& item, const WallRef& ref,
                       absl::string_view what, double at_m, double width_m,
                       double low_m, double high_m) {
  const double margin_m = kMargin_m + (ref.room >= 0 ? kRoomWall_m / 2 : 0);
  if (at_m - width_m / 2 < ref.low_m + margin_m - 1e-9 ||
      at_m + width_m / 2 > ref.high_m - margin_m + 1e-9) {
    return item.Error(absl::StrCat(
        "the ", what, " from ", at_m - width_m / 2, " to ", at_m + width_m / 2,
        " m is not within its wall, which goes from ", ref.low_m, " to ",
        ref.high_m, " m"));
  }
  if (low_m < 0 || high_m > ref.height_m - 0.02) {
    return item.Error(absl::StrCat(
        "the ", what, " from ", low_m, " to ", high_m,
        " m is not within its wall, which is ", ref.height_m, " m high"));
  }
  return absl::OkStatus();
}

// Doors and windows of one wall must lie apart: beside one another, or one over
// the other where nothing is cut.
absl::Status CheckApart(const yaml::YamlNode& item, const BuildingPlan& plan,
                        const WallRef& ref, double at_m, double width_m,
                        double low_m, double high_m) {
  std::vector<WallRef> faces = {ref};
  if (const auto behind =
          WallBehind(plan, ref, at_m - width_m / 2, at_m + width_m / 2)) {
    faces.push_back(*behind);
  }
  const bool is_cut = ref.room < 0 || faces.size() > 1;
  const auto is_near = [&](const PlanOnWall& place, double other_width_m,
                           double other_low_m, double other_high_m) {
    if (!is_cut && (other_low_m > high_m + 2 * kMargin_m ||
                    low_m > other_high_m + 2 * kMargin_m)) {
      return false;
    }
    const auto other = FindWall(plan, place.wall);
    if (!other || std::abs(place.at_m - at_m) >=
                      (width_m + other_width_m) / 2 + kMargin_m) {
      return false;
    }
    std::vector<WallRef> others = {*other};
    if (const auto behind =
            WallBehind(plan, *other, place.at_m - other_width_m / 2,
                       place.at_m + other_width_m / 2)) {
      others.push_back(*behind);
    }
    return std::any_of(faces.begin(), faces.end(), [&](const WallRef& face) {
      return std::any_of(
          others.begin(), others.end(),
          [&](const WallRef& each) { return each.IsSameFace(face); });
    });
  };
  for (const PlanDoor& door : plan.doors) {
    if (is_near(door.place, door.width_m, 0, door.height_m)) {
      return item.Error(
          absl::StrCat("it overlaps a door at ", door.place.at_m, " m"));
    }
  }
  for (const PlanWindow& window : plan.windows) {
    if (is_near(window.place, window.width_m, window.low_m, window.high_m)) {
      return item.Error(
          absl::StrCat("it overlaps a window at ", window.place.at_m, " m"));
    }
  }
  return absl::OkStatus();
}

// A piece's footprint must be within the building.
absl::Status CheckFootprint(const yaml::YamlNode& item,
                            const BuildingPlan& plan, const PlanStand& stand,
                            double width_m, double depth_m) {
  const double yaw = (stand.facing_deg - 90) * std::numbers::pi / 180;
  for (const double x : {-width_m / 2, width_m / 2}) {
    for (const double y : {-depth_m / 2, depth_m / 2}) {
      const double at_x = stand.at.x_m + std::cos(yaw) * x - std::sin(yaw) * y;
      const double at_y = stand.at.y_m + std::sin(yaw) * x + std::cos(yaw) * y;
      const bool is_inside = std::any_of(
          plan.rooms.begin(), plan.rooms.end(),
          [&](const PlanRoom& room) { return room.area.Contains(at_x, at_y); });
      if (!is_inside) {
        return item.Error(absl::StrCat(
            "its corner at [", std::round(at_x * 100) / 100, ", ",
            std::round(at_y * 100) / 100, "] is outside of all rooms"));
      }
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<PlanMover::Stop> ReadStop(const yaml::YamlNode& node,
                                         const BuildingPlan& plan) {
  PlanMover::Stop stop;
  if (!node.IsMap()) {
    TL_ASSIGN_OR_RETURN(stop.at, ReadGroundPoint(node, plan));
    return stop;
  }
  TL_RETURN_IF_ERROR(node.CheckKeys({"at", "pause", "speed", "jump"}));
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode at, node.Get("at"));
  TL_ASSIGN_OR_RETURN(stop.at, ReadGroundPoint(at, plan));
  TL_ASSIGN_OR_RETURN(stop.pause_s, node.NumberOr("pause", 0, 0, 3600));
  if (node.Has("speed")) {
    TL_ASSIGN_OR_RETURN(stop.speed_mps, node.Number("speed", 0.05, 3));
  }
  TL_ASSIGN_OR_RETURN(stop.jumps, node.BooleanOr("jump", false));
  return stop;
}

}  // namespace

absl::Status ReadDoors(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      ReadList(file, "doors",
                               {"wall", "at", "width", "height", "leaf",
                                "period", "open_for"}));
  for (const yaml::YamlNode& item : items) {
    PlanDoor door;
    TL_ASSIGN_OR_RETURN(const WallRef ref, ReadWallRef(item, plan, door.place));
    TL_ASSIGN_OR_RETURN(door.width_m, item.NumberOr("width", 0.95, 0.5, 4));
    TL_ASSIGN_OR_RETURN(door.height_m, item.NumberOr("height", 2.05, 1.5, 4));
    TL_RETURN_IF_ERROR(CheckSpan(item, ref, "door", door.place.at_m,
                                 door.width_m, 0, door.height_m));
    TL_RETURN_IF_ERROR(CheckApart(item, plan, ref, door.place.at_m,
                                  door.width_m, 0, door.height_m));
    if (item.Has("leaf")) {
      TL_ASSIGN_OR_RETURN(
          const int leaf,
          item.Choice("leaf", {"none", "open", "closed", "moving"}));
      door.leaf = static_cast<DoorLeaf>(leaf);
    }
    TL_ASSIGN_OR_RETURN(door.period_s, item.NumberOr("period", 20, 10, 3600));
    TL_ASSIGN_OR_RETURN(door.open_s,
                        item.NumberOr("open_for", 8, 0, door.period_s - 5));
    if (ref.room >= 0 && door.leaf != DoorLeaf::kClosed &&
        !WallBehind(plan, ref, door.place.at_m - door.width_m / 2,
                    door.place.at_m + door.width_m / 2)) {
      return item.Error(
          "there is not one room behind all of this door; doors to the outside "
          "have 'leaf: closed'");
    }
    plan.doors.push_back(door);
  }
  return absl::OkStatus();
}

absl::Status ReadWindows(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(
      const std::vector<yaml::YamlNode> items,
      ReadList(file, "windows", {"wall", "at", "width", "low", "high"}));
  for (const yaml::YamlNode& item : items) {
    PlanWindow window;
    TL_ASSIGN_OR_RETURN(const WallRef ref,
                        ReadWallRef(item, plan, window.place));
    TL_ASSIGN_OR_RETURN(window.width_m, item.NumberOr("width", 1.6, 0.3, 10));
    TL_ASSIGN_OR_RETURN(window.low_m, item.NumberOr("low", 0.95, 0.1, 5));
    TL_ASSIGN_OR_RETURN(window.high_m, item.NumberOr("high", 2.15, 0.3, 10));
    if (window.high_m < window.low_m + 0.2) {
      return item.Error("a window's high is at least 0.2 above its low");
    }
    TL_RETURN_IF_ERROR(CheckSpan(item, ref, "window", window.place.at_m,
                                 window.width_m, window.low_m, window.high_m));
    TL_RETURN_IF_ERROR(CheckApart(item, plan, ref, window.place.at_m,
                                  window.width_m, window.low_m, window.high_m));
    plan.windows.push_back(window);
  }
  return absl::OkStatus();
}

absl::Status ReadPosters(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(
      const std::vector<yaml::YamlNode> items,
      ReadList(file, "posters",
               {"wall", "at", "middle", "width", "height", "moved_to"}));
  for (const yaml::YamlNode& item : items) {
    PlanPoster poster;
    TL_ASSIGN_OR_RETURN(const WallRef ref,
                        ReadWallRef(item, plan, poster.place));
    if (!ref.names_side) {
      return item.Error(absl::StrCat("a poster hangs on '", poster.place.wall,
                                     ".left' or '.right'"));
    }
    TL_ASSIGN_OR_RETURN(poster.middle_m, item.NumberOr("middle", 1.55, 0.1, 9));
    TL_ASSIGN_OR_RETURN(poster.width_m, item.NumberOr("width", 0.6, 0.1, 5));
    TL_ASSIGN_OR_RETURN(poster.height_m, item.NumberOr("height", 0.8, 0.1, 5));
    const double low_m = poster.middle_m - poster.height_m / 2;
    const double high_m = poster.middle_m + poster.height_m / 2;
    TL_RETURN_IF_ERROR(CheckSpan(item, ref, "poster", poster.place.at_m,
                                 poster.width_m, low_m, high_m));
    if (item.Has("moved_to")) {
      TL_ASSIGN_OR_RETURN(poster.moved_to_m,
                          item.Number("moved_to", 0, kMaxSize_m));
      TL_RETURN_IF_ERROR(CheckSpan(item, ref, "poster", *poster.moved_to_m,
                                   poster.width_m, low_m, high_m));
    }
    plan.posters.push_back(poster);
  }
  return absl::OkStatus();
}

absl::Status ReadFurniture(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(
      const std::vector<yaml::YamlNode> items,
      ReadList(file, "furniture",
               {"kind", "at", "facing", "width", "variant", "moved_to"}));
  for (const yaml::YamlNode& item : items) {
    PlanFurniture piece;
    TL_ASSIGN_OR_RETURN(piece.kind, item.Text("kind"));
    const FurnitureKind* kind = FindFurniture(piece.kind);
    if (kind == nullptr) {
      std::vector<absl::string_view> known;
      for (const FurnitureKind& each : FurnitureKinds()) {
        known.push_back(each.name);
      }
      return item.Error(
          absl::StrCat("unknown furniture '", piece.kind.substr(0, 40), "'",
                       Suggestion(piece.kind.substr(0, 40), known)));
    }
    TL_ASSIGN_OR_RETURN(piece.stand, ReadStand(item, plan));
    piece.width_m = kind->width_m;
    if (item.Has("width")) {
      if (kind->max_width_m == 0) {
        return item.Error(absl::StrCat("a ", kind->name,
                                       " has one width only: ", kind->width_m));
      }
      TL_ASSIGN_OR_RETURN(piece.width_m, item.Number("width", kind->min_width_m,
                                                     kind->max_width_m));
    }
    TL_ASSIGN_OR_RETURN(const int64_t variant,
                        item.IntegerOr("variant", 0, 0, 1000));
    piece.variant = static_cast<int>(variant);
    TL_RETURN_IF_ERROR(
        CheckFootprint(item, plan, piece.stand, piece.width_m, kind->depth_m));
    if (item.Has("moved_to")) {
      TL_ASSIGN_OR_RETURN(const yaml::YamlNode moved, item.Get("moved_to"));
      TL_RETURN_IF_ERROR(moved.CheckKeys({"at", "facing"}));
      TL_ASSIGN_OR_RETURN(piece.moved_to, ReadStand(moved, plan));
      TL_RETURN_IF_ERROR(CheckFootprint(moved, plan, *piece.moved_to,
                                        piece.width_m, kind->depth_m));
    }
    plan.furniture.push_back(piece);
  }
  return absl::OkStatus();
}

absl::Status ReadMovers(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(
      const std::vector<yaml::YamlNode> items,
      ReadList(file, "movers",
               {"name", "kind", "speed", "width", "height", "path"}));
  if (items.size() > 50) return items[50].Error("more than 50 movers");
  for (const yaml::YamlNode& item : items) {
    PlanMover mover;
    TL_ASSIGN_OR_RETURN(mover.name, ReadName(item));
    for (const PlanMover& other : plan.movers) {
      if (other.name == mover.name || mover.name == "crate") {
        return item.Error(absl::StrCat("something that moves is called '",
                                       mover.name, "' already"));
      }
    }
    TL_ASSIGN_OR_RETURN(const int kind,
                        item.Choice("kind", {"person", "cart", "post"}));
    mover.kind = static_cast<MoverKind>(kind);
    TL_ASSIGN_OR_RETURN(mover.speed_mps, item.NumberOr("speed", 0.8, 0.05, 3));
    if (mover.kind == MoverKind::kPost) {
      TL_ASSIGN_OR_RETURN(mover.width_m, item.NumberOr("width", 0.4, 0.05, 3));
      TL_ASSIGN_OR_RETURN(mover.height_m, item.NumberOr("height", 1, 0.05, 10));
    } else if (item.Has("width") || item.Has("height")) {
      return item.Error("posts alone have a width and a height of their own");
    }
    TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> stops,
                        item.Items("path"));
    if (stops.size() < 2 || stops.size() > 200) {
      return item.Error("a path has 2..200 points");
    }
    for (const yaml::YamlNode& stop : stops) {
      TL_ASSIGN_OR_RETURN(PlanMover::Stop next, ReadStop(stop, plan));
      mover.path.push_back(next);
    }
    plan.movers.push_back(mover);
  }
  return absl::OkStatus();
}

absl::Status ReadPlaces(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      ReadList(file, "places", {"name", "at", "facing"}));
  for (const yaml::YamlNode& item : items) {
    PlanPlace place;
    TL_ASSIGN_OR_RETURN(place.name, ReadName(item));
    for (const PlanPlace& other : plan.places) {
      if (other.name == place.name) {
        return item.Error(
            absl::StrCat("a place is called '", place.name, "' already"));
      }
    }
    TL_ASSIGN_OR_RETURN(place.stand, ReadStand(item, plan));
    plan.places.push_back(place);
  }
  if (plan.places.empty()) {
    return file.Error("there are no places; a robot must start somewhere");
  }
  return absl::OkStatus();
}

absl::Status ReadTour(const yaml::YamlNode& file, BuildingPlan& plan) {
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> corners,
                      file.Items("tour"));
  if (corners.size() > kMaxThings) {
    return file.Error(
        absl::StrCat("a tour of more than ", kMaxThings, " corners"));
  }
  if (corners.size() < 3) {
    return file.Error("a 'tour' of at least 3 corners is missing");
  }
  for (const yaml::YamlNode& corner : corners) {
    TL_ASSIGN_OR_RETURN(const PlanPoint point, ReadGroundPoint(corner, plan));
    plan.tour.push_back(point);
  }
  return absl::OkStatus();
}

}  // namespace treeline::building
