#include "nav_agent/urdf/urdf_file.h"

#include <map>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/xml/xml_file.h"

namespace treeline::urdf {
namespace {

using tinyxml2::XMLElement;

constexpr double kFarthest_m = 100;
constexpr double kLargestAngle_rad = 100;
constexpr int kMaxShapes = 256;

class Reader {
 public:
  explicit Reader(absl::string_view name) : name_(name) {}

  absl::StatusOr<Urdf> Read(absl::string_view text);

 private:
  absl::Status Error(const XMLElement& at, absl::string_view reason) const {
    return xml::ErrorAt(at, name_, reason);
  }
  absl::Status CheckExpanded(const XMLElement& element) const;
  absl::StatusOr<std::string> Text(const XMLElement& element,
                                   const char* attribute) const;
  absl::StatusOr<double> Number(const XMLElement& element,
                                const char* attribute, double min,
                                double max) const;
  absl::StatusOr<geometry::Vec3> Numbers(const XMLElement& element,
                                         const char* attribute, double min,
                                         double max) const;
  // The pose in the <origin> of an element; none: the identity.
  absl::StatusOr<geometry::Rigid3> Origin(const XMLElement& parent) const;
  absl::Status ReadCollision(const XMLElement& collision, Link& link) const;
  absl::Status ReadLink(const XMLElement& element);
  absl::Status ReadJoint(const XMLElement& element);
  absl::StatusOr<size_t> LinkOf(const XMLElement& joint,
                                const char* child) const;
  absl::Status CheckTree(const XMLElement& robot) const;

  const std::string name_;
  Urdf urdf_;
  std::map<std::string, size_t> links_;
};

// xacro's elements and expressions.
absl::Status Reader::CheckExpanded(const XMLElement& element) const {
  constexpr const char* kXacro =
      "this is xacro, which is not expanded here; run 'xacro FILE > "
      "robot.urdf' first, and give that";
  if (absl::StartsWith(element.Name(), "xacro:")) {
    return Error(element, kXacro);
  }
  for (const tinyxml2::XMLAttribute* attribute = element.FirstAttribute();
       attribute != nullptr; attribute = attribute->Next()) {
    if (absl::StrContains(attribute->Value(), "${") ||
        absl::StrContains(attribute->Value(), "$(")) {
      return Error(element, kXacro);
    }
  }
  // As deep as the parser lets files be.
  for (const XMLElement* child = element.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    TL_RETURN_IF_ERROR(CheckExpanded(*child));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> Reader::Text(const XMLElement& element,
                                         const char* attribute) const {
  const char* value = element.Attribute(attribute);
  if (value == nullptr || *value == '\0') {
    return Error(element,
                 absl::StrCat("<", element.Name(), "> has no ", attribute));
  }
  return std::string(value);
}

absl::StatusOr<double> Reader::Number(const XMLElement& element,
                                      const char* attribute, double min,
                                      double max) const {
  TL_ASSIGN_OR_RETURN(const std::string text, Text(element, attribute));
  double value = 0;
  if (!xml::ParseNumbers(text, min, max, {&value, 1})) {
    return Error(element,
                 absl::StrCat(attribute, "=\"", text.substr(0, 40),
                              "\" is no number from ", min, " to ", max));
  }
  return value;
}

absl::StatusOr<geometry::Vec3> Reader::Numbers(const XMLElement& element,
                                               const char* attribute,
                                               double min, double max) const {
  TL_ASSIGN_OR_RETURN(const std::string text, Text(element, attribute));
  double values[3] = {0, 0, 0};
  if (!xml::ParseNumbers(text, min, max, values)) {
    return Error(element, absl::StrCat(attribute, "=\"", text.substr(0, 60),
                                       "\" is not three numbers from ", min,
                                       " to ", max));
  }
  return geometry::Vec3{values[0], values[1], values[2]};
}

absl::StatusOr<geometry::Rigid3> Reader::Origin(
    const XMLElement& parent) const {
  geometry::Rigid3 pose;
  const XMLElement* origin = parent.FirstChildElement("origin");
  if (origin == nullptr) return pose;
  if (origin->Attribute("xyz") != nullptr) {
    TL_ASSIGN_OR_RETURN(pose.translation,
                        Numbers(*origin, "xyz", -kFarthest_m, kFarthest_m));
  }
  if (origin->Attribute("rpy") != nullptr) {
    TL_ASSIGN_OR_RETURN(
        const geometry::Vec3 rpy,
        Numbers(*origin, "rpy", -kLargestAngle_rad, kLargestAngle_rad));
    // About the fixed axes x, y, z, one after the other.
    pose.rotation = geometry::Rotation3::FromAxisAngle({0, 0, rpy.z}) *
                    geometry::Rotation3::FromAxisAngle({0, rpy.y, 0}) *
                    geometry::Rotation3::FromAxisAngle({rpy.x, 0, 0});
  }
  return pose;
}

absl::Status Reader::ReadCollision(const XMLElement& collision,
                                   Link& link) const {
  const XMLElement* geometry = collision.FirstChildElement("geometry");
  if (geometry == nullptr) {
    return Error(collision, "<collision> has no <geometry>");
  }
  Shape shape;
  TL_ASSIGN_OR_RETURN(shape.link_from_shape, Origin(collision));
  if (const XMLElement* box = geometry->FirstChildElement("box")) {
    shape.kind = ShapeKind::kBox;
    TL_ASSIGN_OR_RETURN(shape.size_m, Numbers(*box, "size", 0, kFarthest_m));
  } else if (const XMLElement* cylinder =
                 geometry->FirstChildElement("cylinder")) {
    shape.kind = ShapeKind::kCylinder;
    TL_ASSIGN_OR_RETURN(shape.radius_m,
                        Number(*cylinder, "radius", 0, kFarthest_m));
    TL_ASSIGN_OR_RETURN(shape.length_m,
                        Number(*cylinder, "length", 0, kFarthest_m));
  } else if (const XMLElement* sphere = geometry->FirstChildElement("sphere")) {
    shape.kind = ShapeKind::kSphere;
    TL_ASSIGN_OR_RETURN(shape.radius_m,
                        Number(*sphere, "radius", 0, kFarthest_m));
  } else if (geometry->FirstChildElement("mesh") != nullptr) {
    ++link.meshes;
    return absl::OkStatus();
  } else {
    return Error(*geometry,
                 "<geometry> is none of box, cylinder, sphere and mesh");
  }
  if (link.collisions.size() >= kMaxShapes) {
    return Error(collision, absl::StrCat("more than ", kMaxShapes,
                                         " collision shapes of one link"));
  }
  link.collisions.push_back(shape);
  return absl::OkStatus();
}

absl::Status Reader::ReadLink(const XMLElement& element) {
  Link link;
  TL_ASSIGN_OR_RETURN(link.name, Text(element, "name"));
  for (const XMLElement* collision = element.FirstChildElement("collision");
       collision != nullptr;
       collision = collision->NextSiblingElement("collision")) {
    TL_RETURN_IF_ERROR(ReadCollision(*collision, link));
  }
  for (const char c : link.name) {
    if (absl::ascii_iscntrl(static_cast<unsigned char>(c))) {
      return Error(element, "a link's name with control characters");
    }
  }
  if (urdf_.links.size() >= kMaxLinks) {
    return Error(element, absl::StrCat("more than ", kMaxLinks, " links"));
  }
  if (!links_.emplace(link.name, urdf_.links.size()).second) {
    return Error(element, absl::StrCat("there are two links '",
                                       link.name.substr(0, 60), "'"));
  }
  urdf_.links.push_back(std::move(link));
  return absl::OkStatus();
}

absl::StatusOr<size_t> Reader::LinkOf(const XMLElement& joint,
                                      const char* child) const {
  const XMLElement* element = joint.FirstChildElement(child);
  if (element == nullptr) {
    return Error(joint, absl::StrCat("<joint> has no <", child, ">"));
  }
  TL_ASSIGN_OR_RETURN(const std::string name, Text(*element, "link"));
  const auto found = links_.find(name);
  if (found == links_.end()) {
    return Error(*element,
                 absl::StrCat("there is no link '", name.substr(0, 60), "'"));
  }
  return found->second;
}

absl::Status Reader::ReadJoint(const XMLElement& element) {
  TL_ASSIGN_OR_RETURN(const size_t parent, LinkOf(element, "parent"));
  TL_ASSIGN_OR_RETURN(const size_t child, LinkOf(element, "child"));
  TL_ASSIGN_OR_RETURN(const std::string type, Text(element, "type"));
  Link& link = urdf_.links[child];
  if (link.parent.has_value()) {
    return Error(element, absl::StrCat("link '", link.name.substr(0, 60),
                                       "' hangs on two joints"));
  }
  link.parent = parent;
  link.joint = type == "fixed" ? JointKind::kFixed
               : type == "continuous" || type == "revolute"
                   ? JointKind::kTurning
                   : JointKind::kOther;
  TL_ASSIGN_OR_RETURN(link.parent_from_link, Origin(element));
  return absl::OkStatus();
}

absl::Status Reader::CheckTree(const XMLElement& robot) const {
  if (urdf_.links.empty()) return Error(robot, "a robot without links");
  std::vector<std::string> roots;
  for (const Link& link : urdf_.links) {
    size_t steps = 0;
    const Link* at = &link;
    while (at->parent.has_value()) {
      at = &urdf_.links[*at->parent];
      if (++steps > urdf_.links.size()) {
        return Error(robot, absl::StrCat("the joints above link '",
                                         link.name.substr(0, 60),
                                         "' go round in a circle"));
      }
    }
    if (!link.parent.has_value()) roots.push_back(link.name.substr(0, 60));
  }
  if (roots.size() > 1) {
    return Error(robot,
                 absl::StrCat("two links hang on no joint: '", roots[0],
                              "' and '", roots[1], "'; a robot is one tree"));
  }
  return absl::OkStatus();
}

absl::StatusOr<Urdf> Reader::Read(absl::string_view text) {
  tinyxml2::XMLDocument document;
  TL_RETURN_IF_ERROR(xml::ParseXml(
      text, name_, {.name = "URDF", .max_bytes = kMaxUrdfBytes}, document));
  const XMLElement* robot = document.RootElement();
  if (robot == nullptr || std::string(robot->Name()) != "robot") {
    return absl::InvalidArgumentError(absl::StrCat(
        name_, ": this is no URDF: its first element is not <robot>"));
  }
  TL_RETURN_IF_ERROR(CheckExpanded(*robot));
  urdf_.name =
      robot->Attribute("name") == nullptr ? "" : robot->Attribute("name");
  for (const XMLElement* link = robot->FirstChildElement("link");
       link != nullptr; link = link->NextSiblingElement("link")) {
    TL_RETURN_IF_ERROR(ReadLink(*link));
  }
  for (const XMLElement* joint = robot->FirstChildElement("joint");
       joint != nullptr; joint = joint->NextSiblingElement("joint")) {
    TL_RETURN_IF_ERROR(ReadJoint(*joint));
  }
  TL_RETURN_IF_ERROR(CheckTree(*robot));
  return std::move(urdf_);
}

}  // namespace

std::optional<size_t> Urdf::Find(absl::string_view link) const {
  for (size_t i = 0; i < links.size(); ++i) {
    if (links[i].name == link) return i;
  }
  return std::nullopt;
}

geometry::Rigid3 Urdf::BaseFromLink(size_t base, size_t link) const {
  const auto root_from = [this](size_t from) {
    geometry::Rigid3 root_from_link;
    for (std::optional<size_t> at = from; at; at = links[*at].parent) {
      if (links[*at].parent) {
        root_from_link = links[*at].parent_from_link * root_from_link;
      }
    }
    return root_from_link;
  };
  return root_from(base).Inverse() * root_from(link);
}

absl::StatusOr<Urdf> ParseUrdf(absl::string_view text, absl::string_view name) {
  return Reader(name).Read(text);
}

}  // namespace treeline::urdf
