#include "server/repository/scene_metadata.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"
#include "nlohmann/json.hpp"

namespace treeline::repository {
namespace {

using Json = nlohmann::json;

// Longer keys are not repeated in messages.
constexpr size_t kLongestQuoted = 40;

// About one key; "" is the whole file.
absl::Status KeyError(absl::string_view key, absl::string_view problem) {
  return absl::InvalidArgumentError(
      absl::StrCat("scene.json: ", key, key.empty() ? "" : ": ", problem));
}

std::string Quoted(absl::string_view text) {
  return absl::StrCat("'", absl::CHexEscape(text.substr(0, kLongestQuoted)),
                      "'");
}

std::string Join(absl::string_view parent, absl::string_view key) {
  return parent.empty() ? std::string(key) : absl::StrCat(parent, ".", key);
}

// That `json` is an object with no keys but `known`.
absl::Status CheckKeys(const Json& json, absl::string_view name,
                       std::initializer_list<absl::string_view> known) {
  if (!json.is_object()) return KeyError(name, "must be an object");
  for (const auto& item : json.items()) {
    if (std::find(known.begin(), known.end(), absl::string_view(item.key())) ==
        known.end()) {
      return KeyError(
          Join(name, Quoted(item.key())),
          absl::StrCat("unknown key; known are ", absl::StrJoin(known, ", ")));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<double> Number(const Json& object, absl::string_view parent,
                              const char* key) {
  const std::string name = Join(parent, key);
  const auto found = object.find(key);
  if (found == object.end()) return KeyError(name, "is missing");
  if (!found->is_number()) return KeyError(name, "must be a number");
  const double value = found->get<double>();
  if (!std::isfinite(value)) return KeyError(name, "is not finite");
  return value;
}

absl::StatusOr<double> NumberWithin(const Json& object,
                                    absl::string_view parent, const char* key,
                                    double low, double high) {
  TL_ASSIGN_OR_RETURN(const double value, Number(object, parent, key));
  if (value >= low && value <= high) return value;
  return KeyError(
      Join(parent, key),
      absl::StrCat("is ", value, "; it must be between ", low, " and ", high));
}

absl::StatusOr<int> Size_px(const Json& object, absl::string_view parent,
                            const char* key) {
  TL_ASSIGN_OR_RETURN(const double value,
                      NumberWithin(object, parent, key, 1, 16384));
  if (value != std::floor(value)) {
    return KeyError(Join(parent, key), "must be a whole number");
  }
  return static_cast<int>(value);
}

absl::StatusOr<geometry::Rotation3> QuaternionFromJson(const Json& json,
                                                       absl::string_view name) {
  TL_RETURN_IF_ERROR(CheckKeys(json, name, {"w", "x", "y", "z"}));
  TL_ASSIGN_OR_RETURN(const double w, Number(json, name, "w"));
  TL_ASSIGN_OR_RETURN(const double x, Number(json, name, "x"));
  TL_ASSIGN_OR_RETURN(const double y, Number(json, name, "y"));
  TL_ASSIGN_OR_RETURN(const double z, Number(json, name, "z"));
  const absl::StatusOr<geometry::Rigid3> rotation =
      geometry::RigidFromQuaternion(w, x, y, z, {});
  if (!rotation.ok()) return KeyError(name, rotation.status().message());
  return geometry::Normalized(rotation->rotation);
}

absl::StatusOr<GeoAnchor> GeoAnchorFromJson(const Json& json) {
  constexpr absl::string_view kName = "geo_anchor";
  TL_RETURN_IF_ERROR(CheckKeys(json, kName,
                               {"latitude_deg", "longitude_deg", "height_m",
                                "heading_deg", "enu_from_world"}));
  GeoAnchor anchor;
  TL_ASSIGN_OR_RETURN(anchor.latitude_deg,
                      NumberWithin(json, kName, "latitude_deg", -90, 90));
  TL_ASSIGN_OR_RETURN(anchor.longitude_deg,
                      NumberWithin(json, kName, "longitude_deg", -180, 180));
  TL_ASSIGN_OR_RETURN(anchor.height_m,
                      NumberWithin(json, kName, "height_m", -12000, 100000));
  if (json.contains("heading_deg") == json.contains("enu_from_world")) {
    return KeyError(kName, "needs either heading_deg or enu_from_world");
  }
  if (json.contains("heading_deg")) {
    TL_ASSIGN_OR_RETURN(const double heading_deg,
                        NumberWithin(json, kName, "heading_deg", -360, 360));
    anchor.enu_from_world = EnuFromWorldOfHeading(heading_deg);
  } else {
    TL_ASSIGN_OR_RETURN(
        anchor.enu_from_world,
        QuaternionFromJson(json["enu_from_world"],
                           absl::StrCat(kName, ".enu_from_world")));
  }
  return anchor;
}

absl::StatusOr<camera::Camera> CameraFromJson(const Json& json) {
  constexpr absl::string_view kName = "camera";
  TL_RETURN_IF_ERROR(
      CheckKeys(json, kName, {"model", "width_px", "height_px", "parameters"}));
  const auto model_name = json.find("model");
  if (model_name == json.end() || !model_name->is_string()) {
    return KeyError("camera.model", "must be a string, for instance PINHOLE");
  }
  const auto model = camera::ParseCameraModel(model_name->get<std::string>());
  if (!model.ok()) {
    return KeyError(
        "camera.model",
        absl::StrCat("unknown model ", Quoted(model_name->get<std::string>())));
  }
  TL_ASSIGN_OR_RETURN(const int width, Size_px(json, kName, "width_px"));
  TL_ASSIGN_OR_RETURN(const int height, Size_px(json, kName, "height_px"));
  const auto list = json.find("parameters");
  if (list == json.end() || !list->is_array() ||
      list->size() > camera::Camera::kMaxParameters ||
      !std::all_of(list->begin(), list->end(),
                   [](const Json& value) { return value.is_number(); })) {
    return KeyError("camera.parameters",
                    absl::StrCat("must be a list of at most ",
                                 camera::Camera::kMaxParameters, " numbers"));
  }
  const auto parameters = list->get<std::vector<double>>();
  absl::StatusOr<camera::Camera> camera =
      camera::Camera::Create(*model, width, height, parameters.data(),
                             static_cast<int>(parameters.size()));
  if (!camera.ok()) return KeyError(kName, camera.status().message());
  return camera;
}

absl::StatusOr<std::string> DisplayNameFromJson(const Json& json) {
  constexpr absl::string_view kName = "display_name";
  if (!json.is_string()) return KeyError(kName, "must be a string");
  std::string name = json.get<std::string>();
  if (name.size() > kMaxDisplayNameBytes) {
    return KeyError(kName, absl::StrCat("has ", name.size(), " bytes; at most ",
                                        kMaxDisplayNameBytes, " are allowed"));
  }
  if (std::any_of(name.begin(), name.end(), [](char c) {
        return absl::ascii_iscntrl(static_cast<unsigned char>(c));
      })) {
    return KeyError(kName, "holds a control character");
  }
  return name;
}

// The parser keeps the last of keys that repeat; this refuses them.
absl::StatusOr<Json> ParseWithoutRepetition(absl::string_view text) {
  std::vector<std::set<std::string>> keys;
  std::string repeated;
  const Json::parser_callback_t look = [&](int, Json::parse_event_t event,
                                           Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key) {
      const std::string key = parsed.get<std::string>();
      if (!keys.back().insert(key).second) repeated = Quoted(key);
    }
    return true;
  };
  try {
    Json json = Json::parse(text.begin(), text.end(), look);
    if (!repeated.empty()) return KeyError(repeated, "stands there twice");
    return json;
  } catch (const Json::exception& error) {
    return KeyError("", absl::StrCat("not JSON: ", error.what()));
  }
}

}  // namespace

geometry::Rotation3 EnuFromWorldOfHeading(double heading_deg) {
  return geometry::Normalized(geometry::Rotation3::FromAxisAngle(
      {0, 0, -heading_deg * std::numbers::pi / 180}));
}

absl::StatusOr<SceneMetadata> ParseSceneMetadata(absl::string_view text) {
  if (text.size() > kMaxSceneJsonBytes) {
    return KeyError("",
                    absl::StrCat("longer than ", kMaxSceneJsonBytes, " bytes"));
  }
  TL_ASSIGN_OR_RETURN(const Json json, ParseWithoutRepetition(text));
  TL_RETURN_IF_ERROR(
      CheckKeys(json, "", {"display_name", "geo_anchor", "camera"}));
  SceneMetadata metadata;
  if (json.contains("display_name")) {
    TL_ASSIGN_OR_RETURN(metadata.display_name,
                        DisplayNameFromJson(json["display_name"]));
  }
  if (json.contains("geo_anchor")) {
    TL_ASSIGN_OR_RETURN(metadata.geo_anchor,
                        GeoAnchorFromJson(json["geo_anchor"]));
  }
  if (json.contains("camera")) {
    TL_ASSIGN_OR_RETURN(metadata.camera, CameraFromJson(json["camera"]));
  }
  return metadata;
}

}  // namespace treeline::repository
