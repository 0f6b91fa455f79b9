#include "simulation/building/gazebo_world.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/geometry/rigid3.h"
#include "common/xml/xml_file.h"

namespace treeline::building {
namespace {

using tinyxml2::XMLElement;

constexpr double kFarthest_m = 1000;
constexpr double kLargestAngle_rad = 1000;
constexpr size_t kMaxSolids = 20000;
// An axis that leans less is upright.
constexpr double kUpright = 0.9999;
// A plane so near z = 0 is the ground.
constexpr double kGround_m = 0.02;
constexpr size_t kShownChars = 60;

absl::string_view Shown(absl::string_view text) {
  return text.substr(0, kShownChars);
}

class Reader {
 public:
  explicit Reader(absl::string_view name) : name_(name) {}

  absl::StatusOr<std::vector<GazeboSolid>> Read(absl::string_view text);

 private:
  absl::Status Error(const XMLElement& at, absl::string_view reason) const {
    return xml::ErrorAt(
        at, name_,
        model_.empty() ? std::string(reason)
                       : absl::StrCat("model '", Shown(model_), "': ", reason));
  }
  // What an element's child says, without white space around; "": nothing.
  static absl::string_view TextOf(const XMLElement& parent, const char* child);
  absl::Status Numbers(const XMLElement& parent, const char* child, double min,
                       std::span<double> values) const;
  // None: the identity.
  absl::StatusOr<geometry::Rigid3> Pose(const XMLElement& parent) const;
  absl::Status ReadState(const XMLElement& world);
  absl::Status CheckInclude(const XMLElement& include) const;
  absl::Status ReadModel(const XMLElement& model);
  absl::Status ReadLink(const XMLElement& link,
                        const geometry::Rigid3& world_from_model);
  absl::Status ReadCollision(const XMLElement& collision,
                             const geometry::Rigid3& world_from_link);
  absl::Status AddBox(const XMLElement& box,
                      const geometry::Rigid3& world_from_shape);
  absl::Status AddCylinder(const XMLElement& cylinder,
                           const geometry::Rigid3& world_from_shape);
  absl::Status CheckPlane(const XMLElement& plane,
                          const geometry::Rigid3& world_from_shape) const;
  absl::Status Add(const XMLElement& at, GazeboSolid solid);

  const std::string name_;
  // The one that is being read.
  std::string model_;
  std::map<std::string, geometry::Rigid3> state_;
  std::vector<GazeboSolid> solids_;
};

absl::string_view Reader::TextOf(const XMLElement& parent, const char* child) {
  const XMLElement* element = parent.FirstChildElement(child);
  if (element == nullptr || element->GetText() == nullptr) return "";
  return absl::StripAsciiWhitespace(element->GetText());
}

absl::Status Reader::Numbers(const XMLElement& parent, const char* child,
                             double min, std::span<double> values) const {
  const absl::string_view text = TextOf(parent, child);
  if (xml::ParseNumbers(text, min, kFarthest_m, values)) {
    return absl::OkStatus();
  }
  return Error(
      parent, absl::StrCat("<", child, "> of <", parent.Name(), "> is '",
                           Shown(text), "', not ", values.size(), " number",
                           values.size() == 1 ? "" : "s", " from ", min, " to ",
                           kFarthest_m));
}

absl::StatusOr<geometry::Rigid3> Reader::Pose(const XMLElement& parent) const {
  const XMLElement* pose = parent.FirstChildElement("pose");
  geometry::Rigid3 parent_from_this;
  if (pose == nullptr) return parent_from_this;
  for (const char* frame : {"frame", "relative_to"}) {
    if (pose->Attribute(frame) != nullptr && *pose->Attribute(frame) != '\0') {
      return Error(*pose,
                   absl::StrCat("its pose is given in the frame '",
                                Shown(pose->Attribute(frame)),
                                "'; poses are read in their parent's alone"));
    }
  }
  std::array<double, 6> values = {};
  const absl::string_view text = TextOf(parent, "pose");
  if (!text.empty() &&
      !xml::ParseNumbers(text, -kLargestAngle_rad, kLargestAngle_rad, values)) {
    return Error(*pose, absl::StrCat("the pose '", Shown(text),
                                     "' is not six numbers from ", -kFarthest_m,
                                     " to ", kFarthest_m));
  }
  parent_from_this.translation = {values[0], values[1], values[2]};
  // About the fixed axes x, y, z, one after the other.
  parent_from_this.rotation =
      geometry::Rotation3::FromAxisAngle({0, 0, values[5]}) *
      geometry::Rotation3::FromAxisAngle({0, values[4], 0}) *
      geometry::Rotation3::FromAxisAngle({values[3], 0, 0});
  return parent_from_this;
}

// Where models were when the world was saved.
absl::Status Reader::ReadState(const XMLElement& world) {
  const XMLElement* state = world.FirstChildElement("state");
  if (state == nullptr) return absl::OkStatus();
  for (const XMLElement* model = state->FirstChildElement("model");
       model != nullptr; model = model->NextSiblingElement("model")) {
    const char* name = model->Attribute("name");
    if (name == nullptr || model->FirstChildElement("pose") == nullptr) {
      continue;
    }
    model_ = name;
    std::array<double, 3> scale = {1, 1, 1};
    if (model->FirstChildElement("scale") != nullptr) {
      TL_RETURN_IF_ERROR(Numbers(*model, "scale", 0, scale));
    }
    if (scale != std::array<double, 3>{1, 1, 1}) {
      return Error(*model, "its <state> scales it, which is not read");
    }
    TL_ASSIGN_OR_RETURN(state_[model_], Pose(*model));
  }
  model_.clear();
  return absl::OkStatus();
}

absl::Status Reader::CheckInclude(const XMLElement& include) const {
  const absl::string_view uri = TextOf(include, "uri");
  if (uri == "model://ground_plane" || uri == "model://sun") {
    return absl::OkStatus();
  }
  return Error(include,
               absl::StrCat("the model '", Shown(uri),
                            "' is a file of its own, which is not read; of "
                            "those, ground_plane and sun alone are known"));
}

absl::Status Reader::Add(const XMLElement& at, GazeboSolid solid) {
  if (solids_.size() >= kMaxSolids) {
    return Error(at, absl::StrCat("more than ", kMaxSolids, " shapes"));
  }
  solid.model = model_;
  solid.line = at.GetLineNum();
  solids_.push_back(std::move(solid));
  return absl::OkStatus();
}

absl::Status Reader::AddBox(const XMLElement& box,
                            const geometry::Rigid3& world_from_shape) {
  std::array<double, 3> size = {};
  TL_RETURN_IF_ERROR(Numbers(box, "size", 0, size));
  const geometry::Mat3 axes = world_from_shape.rotation.Matrix();
  for (int up = 0; up < 3; ++up) {
    if (std::abs(axes(2, up)) < kUpright) continue;
    const int along = (up + 1) % 3;
    const int across = (up + 2) % 3;
    const geometry::Vec3 middle = world_from_shape.translation;
    const double half_m = size[static_cast<size_t>(up)] / 2;
    return Add(box, {.x_m = middle.x,
                     .y_m = middle.y,
                     .yaw_rad = std::atan2(axes(1, along), axes(0, along)),
                     .along_m = size[static_cast<size_t>(along)],
                     .across_m = size[static_cast<size_t>(across)],
                     .bottom_m = middle.z - half_m,
                     .top_m = middle.z + half_m});
  }
  return Error(box, "its box is tilted; upright ones alone are read");
}

absl::Status Reader::AddCylinder(const XMLElement& cylinder,
                                 const geometry::Rigid3& world_from_shape) {
  double radius_m = 0;
  double length_m = 0;
  TL_RETURN_IF_ERROR(Numbers(cylinder, "radius", 0, {&radius_m, 1}));
  TL_RETURN_IF_ERROR(Numbers(cylinder, "length", 0, {&length_m, 1}));
  if (std::abs(world_from_shape.rotation.Matrix()(2, 2)) < kUpright) {
    return Error(cylinder,
                 "its cylinder is tilted; upright ones alone are read");
  }
  const geometry::Vec3 middle = world_from_shape.translation;
  return Add(cylinder, {.is_round = true,
                        .x_m = middle.x,
                        .y_m = middle.y,
                        .along_m = 2 * radius_m,
                        .across_m = 2 * radius_m,
                        .bottom_m = middle.z - length_m / 2,
                        .top_m = middle.z + length_m / 2});
}

absl::Status Reader::CheckPlane(
    const XMLElement& plane, const geometry::Rigid3& world_from_shape) const {
  std::array<double, 3> normal = {0, 0, 1};
  if (plane.FirstChildElement("normal") != nullptr) {
    TL_RETURN_IF_ERROR(Numbers(plane, "normal", -kFarthest_m, normal));
  }
  const geometry::Vec3 up = world_from_shape.rotation *
                            geometry::Vec3{normal[0], normal[1], normal[2]};
  if (up.z > kUpright * geometry::Norm(up) &&
      std::abs(world_from_shape.translation.z) < kGround_m) {
    return absl::OkStatus();
  }
  return Error(plane, "its plane is not the ground at z = 0");
}

absl::Status Reader::ReadCollision(const XMLElement& collision,
                                   const geometry::Rigid3& world_from_link) {
  const XMLElement* geometry = collision.FirstChildElement("geometry");
  const XMLElement* shape =
      geometry == nullptr ? nullptr : geometry->FirstChildElement();
  if (shape == nullptr) return Error(collision, "a <collision> of no shape");
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 link_from_shape, Pose(collision));
  const geometry::Rigid3 world_from_shape = world_from_link * link_from_shape;
  const absl::string_view kind = shape->Name();
  if (kind == "box") return AddBox(*shape, world_from_shape);
  if (kind == "cylinder") return AddCylinder(*shape, world_from_shape);
  if (kind == "plane") return CheckPlane(*shape, world_from_shape);
  if (kind == "empty") return absl::OkStatus();
  return Error(*shape,
               absl::StrCat("its shape is a <", Shown(kind),
                            ">; <box>, <cylinder> and the ground's <plane> "
                            "are read"));
}

absl::Status Reader::ReadLink(const XMLElement& link,
                              const geometry::Rigid3& world_from_model) {
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 model_from_link, Pose(link));
  for (const XMLElement* collision = link.FirstChildElement("collision");
       collision != nullptr;
       collision = collision->NextSiblingElement("collision")) {
    TL_RETURN_IF_ERROR(
        ReadCollision(*collision, world_from_model * model_from_link));
  }
  return absl::OkStatus();
}

absl::Status Reader::ReadModel(const XMLElement& model) {
  model_ = model.Attribute("name") == nullptr ? "" : model.Attribute("name");
  if (const XMLElement* plugin = model.FirstChildElement("plugin")) {
    const char* file = plugin->Attribute("filename");
    return Error(
        *plugin,
        absl::StrCat("a plugin, '", Shown(file == nullptr ? "" : file),
                     "', moves it or does something else; that is a program "
                     "for Gazebo. What moves can be said in a world file "
                     "(docs/reference/world-files.md, movers)"));
  }
  for (const char* kind : {"joint", "model", "include"}) {
    if (const XMLElement* child = model.FirstChildElement(kind)) {
      return Error(*child, absl::StrCat("it has a <", kind,
                                        ">; models of links that stand are "
                                        "read"));
    }
  }
  geometry::Rigid3 world_from_model;
  if (const auto found = state_.find(model_); found != state_.end()) {
    world_from_model = found->second;
  } else {
    TL_ASSIGN_OR_RETURN(world_from_model, Pose(model));
  }
  for (const XMLElement* link = model.FirstChildElement("link");
       link != nullptr; link = link->NextSiblingElement("link")) {
    TL_RETURN_IF_ERROR(ReadLink(*link, world_from_model));
  }
  model_.clear();
  return absl::OkStatus();
}

absl::StatusOr<std::vector<GazeboSolid>> Reader::Read(absl::string_view text) {
  tinyxml2::XMLDocument document;
  TL_RETURN_IF_ERROR(xml::ParseXml(
      text, name_, {.name = "SDF", .max_bytes = kMaxGazeboBytes}, document));
  const XMLElement* root = document.RootElement();
  const XMLElement* world =
      root == nullptr || absl::string_view(root->Name()) != "sdf"
          ? nullptr
          : root->FirstChildElement("world");
  if (world == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(
        name_, ": this is no world of Gazebo: no <sdf> with a <world>"));
  }
  if (const XMLElement* second = world->NextSiblingElement("world")) {
    return Error(*second, "a second <world>; which one is meant?");
  }
  TL_RETURN_IF_ERROR(ReadState(*world));
  for (const XMLElement* child = world->FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    const absl::string_view kind = child->Name();
    if (kind == "model") {
      TL_RETURN_IF_ERROR(ReadModel(*child));
    } else if (kind == "include") {
      TL_RETURN_IF_ERROR(CheckInclude(*child));
    } else if (kind == "actor" || kind == "population" || kind == "road" ||
               kind == "joint" || kind == "frame") {
      const char* name = child->Attribute("name");
      return Error(*child, absl::StrCat("<", kind, "> '",
                                        Shown(name == nullptr ? "" : name),
                                        "' is not read"));
    }
  }
  return std::move(solids_);
}

}  // namespace

absl::StatusOr<std::vector<GazeboSolid>> ParseGazeboWorld(
    absl::string_view text, absl::string_view name) {
  return Reader(name).Read(text);
}

}  // namespace treeline::building
