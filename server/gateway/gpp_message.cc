#include "server/gateway/gpp_message.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/camera/camera.h"
#include "common/connect_rpc/connect_error.h"
#include "common/connect_rpc/json_message.h"
#include "common/image/decode.h"
#include "server/gateway/gpp_json_field.h"

namespace treeline::gateway {
namespace {

using connect_rpc::InvalidRequest;

// Depth and colour of one moment.
constexpr double kSameMomentMs = 50;
constexpr double kDepthUnit_m = 0.001;
// COLMAP's centre of the top left pixel.
constexpr double kColmapPixelCentre = 0.5;
// A geolocation is given with one sigma; this many of them are believed.
constexpr double kSigmas = 3;
// Satellite positions are poor indoors: no client is taken to be more exact.
constexpr double kMinRadius_m = 50;
// Where nothing is said.
constexpr double kUnknownRadius_m = 1000;

struct Reading {
  JsonField json;
  double timestamp_ms;
  bool is_depth;
};

struct Size {
  int width = 0;
  int height = 0;
};

absl::StatusOr<std::vector<Reading>> ReadReadings(const JsonField& readings) {
  TL_ASSIGN_OR_RETURN(const std::vector<JsonField> elements,
                      readings.FindElements("cameraReadings"));
  std::vector<Reading> cameras;
  for (const JsonField& element : elements) {
    TL_ASSIGN_OR_RETURN(const double timestamp_ms,
                        element.GetNumber("timestamp"));
    TL_ASSIGN_OR_RETURN(const JsonField format, element.Get("imageFormat"));
    TL_ASSIGN_OR_RETURN(const absl::string_view name, format.AsString());
    cameras.push_back({element, timestamp_ms, name == "DEPTH"});
  }
  return cameras;
}

// The last one, or of a kind the nearest to a moment; null: there is none.
const Reading* Newest(const std::vector<Reading>& readings) {
  const Reading* newest = nullptr;
  for (const Reading& reading : readings) {
    if (!reading.is_depth &&
        (newest == nullptr || reading.timestamp_ms > newest->timestamp_ms)) {
      newest = &reading;
    }
  }
  return newest;
}

const Reading* NearestDepth(const std::vector<Reading>& readings,
                            double timestamp_ms) {
  const auto distance = [&](const Reading& reading) {
    return std::abs(reading.timestamp_ms - timestamp_ms);
  };
  const Reading* nearest = nullptr;
  for (const Reading& reading : readings) {
    if (reading.is_depth &&
        (nearest == nullptr || distance(reading) < distance(*nearest))) {
      nearest = &reading;
    }
  }
  return nearest;
}

absl::StatusOr<Size> ReadSize(const JsonField& reading) {
  TL_ASSIGN_OR_RETURN(const JsonField field, reading.Get("size"));
  TL_ASSIGN_OR_RETURN(const std::vector<double> size, field.AsNumbers());
  const auto is_length = [](double value) {
    return value >= 1 && value <= 16384 && value == std::floor(value);
  };
  if (size.size() != 2 || !is_length(size[0]) || !is_length(size[1])) {
    return field.Wrong("must be [width, height], whole numbers in 1..16384");
  }
  return Size{static_cast<int>(size[0]), static_cast<int>(size[1])};
}

absl::StatusOr<std::string> ReadBytes(const JsonField& reading) {
  TL_ASSIGN_OR_RETURN(const JsonField field, reading.Get("imageBytes"));
  TL_ASSIGN_OR_RETURN(absl::string_view text, field.AsString());
  if (absl::StartsWith(text, "data:")) {
    text.remove_prefix(std::min(text.size(), text.find(',')));
    if (!text.empty()) text.remove_prefix(1);
  }
  std::string bytes;
  if (!absl::Base64Unescape(text, &bytes)) return field.Wrong("is not base64");
  if (bytes.empty()) return field.Wrong("is empty");
  return bytes;
}

// How far a picture is to be turned clockwise until it is upright, in [0, 360);
// nullopt: nothing is said of it.
absl::StatusOr<std::optional<double>> ReadRotation_deg(
    const JsonField& reading) {
  TL_ASSIGN_OR_RETURN(const std::optional<JsonField> orientation,
                      reading.Find("imageOrientation"));
  if (!orientation.has_value()) return std::nullopt;
  TL_ASSIGN_OR_RETURN(const std::optional<JsonField> mirrored,
                      orientation->Find("mirrored"));
  if (mirrored.has_value() && mirrored->IsTrue()) {
    return mirrored->Wrong(
        "mirrored pictures are refused; send the picture as a camera sees it");
  }
  TL_ASSIGN_OR_RETURN(const double rotation_deg,
                      orientation->NumberOr("rotation", 0));
  const double turn_deg = std::fmod(rotation_deg, 360);
  return turn_deg < 0 ? turn_deg + 360 : turn_deg;
}

// nullopt: the client does not know its camera.
absl::StatusOr<std::optional<v1::Camera>> ReadCamera(const JsonField& reading,
                                                     Size size) {
  TL_ASSIGN_OR_RETURN(const std::optional<JsonField> params,
                      reading.Find("params"));
  if (!params.has_value()) return std::nullopt;
  TL_ASSIGN_OR_RETURN(const std::optional<JsonField> model,
                      params->Find("model"));
  if (!model.has_value()) return std::nullopt;
  TL_ASSIGN_OR_RETURN(const absl::string_view name, model->AsString());
  if (name == "UNKNOWN" || name == "UNKNOWN_CAMERA") return std::nullopt;
  const absl::StatusOr<camera::CameraModel> known = camera::ParseCameraModel(
      name == "THIN_PRISM" ? "THIN_PRISM_FISHEYE" : name);
  if (!known.ok()) {
    return model->Wrong("not one of COLMAP's camera models");
  }
  TL_ASSIGN_OR_RETURN(const JsonField parameters, params->Get("modelParams"));
  TL_ASSIGN_OR_RETURN(std::vector<double> values, parameters.AsNumbers());
  if (static_cast<int>(values.size()) != camera::CameraParameterCount(*known)) {
    return parameters.Wrong(absl::StrCat(camera::CameraModelName(*known),
                                         " has ",
                                         camera::CameraParameterCount(*known),
                                         " parameters, not ", values.size()));
  }
  const auto cx =
      static_cast<size_t>(camera::CameraPrincipalPointIndex(*known));
  values[cx] -= kColmapPixelCentre;
  values[cx + 1] -= kColmapPixelCentre;
  v1::Camera camera;
  const absl::string_view model_name = camera::CameraModelName(*known);
  camera.set_model(model_name.data(), model_name.size());
  camera.set_width_px(size.width);
  camera.set_height_px(size.height);
  camera.mutable_parameters()->Add(values.begin(), values.end());
  return camera;
}

// Raw pixels of `channels` bytes as R, G, B.
absl::Status ReadRaw(const JsonField& reading, absl::string_view bytes,
                     Size size, size_t channels, v1::Rgb8Image& image) {
  const auto pixels =
      static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
  if (bytes.size() != pixels * channels) {
    return reading.Wrong(absl::StrCat("imageBytes has ", bytes.size(),
                                      " bytes; ", size.width, " x ",
                                      size.height, " pixels of ", channels,
                                      " byte(s) are ", pixels * channels));
  }
  image.set_width_px(size.width);
  image.set_height_px(size.height);
  std::string& rgb = *image.mutable_data();
  rgb.resize(3 * pixels);
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      rgb[3 * i + c] = bytes[channels * i + (channels == 1 ? 0 : c)];
    }
  }
  return absl::OkStatus();
}

absl::Status ReadColor(const JsonField& reading, Size size,
                       v1::ColorImage& color) {
  TL_ASSIGN_OR_RETURN(std::string bytes, ReadBytes(reading));
  if (image::SniffFormat(bytes) != image::ImageFormat::kUnknown) {
    color.set_encoded(std::move(bytes));
    return absl::OkStatus();
  }
  TL_ASSIGN_OR_RETURN(const JsonField format, reading.Get("imageFormat"));
  TL_ASSIGN_OR_RETURN(const absl::string_view name, format.AsString());
  if (name == "RGBA32") {
    return ReadRaw(reading, bytes, size, 4, *color.mutable_rgb8());
  }
  if (name == "GRAY8") {
    return ReadRaw(reading, bytes, size, 1, *color.mutable_rgb8());
  }
  return format.Wrong(
      "imageBytes is neither a JPEG nor a PNG file, and only RGBA32 and GRAY8 "
      "are known without");
}

// The side that a turn of `rotation_deg` clockwise brings to the top.
v1::Orientation SideUp(double rotation_deg) {
  switch (static_cast<int>(std::lround(rotation_deg / 90)) % 4) {
    case 1:
      return v1::ORIENTATION_LEFT_UP;
    case 2:
      return v1::ORIENTATION_BOTTOM_UP;
    case 3:
      return v1::ORIENTATION_RIGHT_UP;
    default:
      return v1::ORIENTATION_TOP_UP;
  }
}

absl::Status ReadDepth(const JsonField& reading, Size color_size,
                       std::optional<double> color_rotation_deg,
                       bool has_camera, v1::DepthImage& depth) {
  TL_ASSIGN_OR_RETURN(const std::optional<double> rotation_deg,
                      ReadRotation_deg(reading));
  if (rotation_deg.has_value() &&
      *rotation_deg != color_rotation_deg.value_or(0)) {
    return reading.Wrong("imageOrientation is not that of its picture");
  }
  TL_ASSIGN_OR_RETURN(const Size size, ReadSize(reading));
  TL_ASSIGN_OR_RETURN(const std::optional<JsonField> params,
                      reading.Find("params"));
  if (params.has_value()) {
    for (const char* name : {"minMaxDepth", "minMaxDisparity"}) {
      TL_ASSIGN_OR_RETURN(const std::optional<JsonField> range,
                          params->Find(name));
      if (range.has_value()) {
        return range->Wrong(
            "is refused: depth must be in millimetres, without a scale");
      }
    }
  }
  TL_ASSIGN_OR_RETURN(const std::optional<v1::Camera> camera,
                      ReadCamera(reading, size));
  const bool registered = has_camera || camera.has_value();
  if (registered &&
      (size.width != color_size.width || size.height != color_size.height)) {
    return reading.Wrong(
        "depth of another size than the picture: it must be registered to it");
  }
  depth.set_registration(registered ? v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR
                                    : v1::DEPTH_REGISTRATION_SCENE_CALIBRATION);
  depth.set_unit_m(kDepthUnit_m);
  TL_ASSIGN_OR_RETURN(std::string bytes, ReadBytes(reading));
  if (image::SniffFormat(bytes) == image::ImageFormat::kPng) {
    depth.set_png(std::move(bytes));
    return absl::OkStatus();
  }
  const size_t wanted =
      2 * static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
  if (bytes.size() != wanted) {
    return reading.Wrong(absl::StrCat("imageBytes has ", bytes.size(),
                                      " bytes; DEPTH is a 16-bit PNG or ",
                                      wanted, " bytes of 16-bit values for ",
                                      size.width, " x ", size.height));
  }
  depth.mutable_raw()->set_width_px(size.width);
  depth.mutable_raw()->set_height_px(size.height);
  depth.mutable_raw()->set_data(std::move(bytes));
  return absl::OkStatus();
}

absl::Status ReadFrame(const std::vector<Reading>& readings,
                       GppRequest& request) {
  const Reading* picture = Newest(readings);
  if (picture == nullptr) {
    return InvalidRequest(
        "sensorReadings.cameraReadings: a picture is needed to localize");
  }
  request.timestamp_ms = picture->timestamp_ms;
  TL_ASSIGN_OR_RETURN(const std::optional<double> rotation_deg,
                      ReadRotation_deg(picture->json));
  // Clients that know nothing of it say 0.
  if (rotation_deg.value_or(0) != 0) {
    request.frame.set_orientation(SideUp(*rotation_deg));
    request.frame.set_orientation_is_guess(true);
  }
  TL_ASSIGN_OR_RETURN(const Size size, ReadSize(picture->json));
  TL_ASSIGN_OR_RETURN(const std::optional<v1::Camera> camera,
                      ReadCamera(picture->json, size));
  if (camera.has_value()) *request.frame.mutable_camera() = *camera;
  TL_RETURN_IF_ERROR(
      ReadColor(picture->json, size, *request.frame.mutable_color()));
  const Reading* depth = NearestDepth(readings, picture->timestamp_ms);
  if (depth == nullptr) return absl::OkStatus();
  if (std::abs(depth->timestamp_ms - picture->timestamp_ms) > kSameMomentMs) {
    return depth->json.Wrong(absl::StrCat("no DEPTH within ", kSameMomentMs,
                                          " ms of the newest picture"));
  }
  return ReadDepth(depth->json, size, rotation_deg, camera.has_value(),
                   *request.frame.mutable_depth());
}

double RadiusFor(double accuracy_m) {
  if (!(accuracy_m > 0)) return kUnknownRadius_m;
  return std::max(kSigmas * accuracy_m, kMinRadius_m);
}

absl::Status ReadLocations(const JsonField& readings,
                           std::vector<GppHint>& hints) {
  // Version 0.2.1 of @oarc/gpp-access declares the first and writes the second.
  for (const char* name : {"geolocationReadings", "geoLocationReadings"}) {
    TL_ASSIGN_OR_RETURN(const std::vector<JsonField> locations,
                        readings.FindElements(name));
    for (const JsonField& location : locations) {
      GppHint hint;
      TL_ASSIGN_OR_RETURN(hint.position.latitude_deg,
                          location.GetNumber("latitude"));
      TL_ASSIGN_OR_RETURN(hint.position.longitude_deg,
                          location.GetNumber("longitude"));
      TL_ASSIGN_OR_RETURN(const double accuracy_m,
                          location.NumberOr("accuracy", 0));
      TL_RETURN_IF_ERROR(base::WithReason(
          CheckPosition(hint.position, location.path()), "INVALID_REQUEST"));
      hint.radius_m = RadiusFor(accuracy_m);
      hints.push_back(hint);
    }
  }
  return absl::OkStatus();
}

absl::Status ReadPriors(const JsonField& root, std::vector<GppHint>& hints) {
  TL_ASSIGN_OR_RETURN(const std::vector<JsonField> priors,
                      root.FindElements("priorPoses"));
  for (const JsonField& prior : priors) {
    TL_ASSIGN_OR_RETURN(const JsonField geopose, prior.Get("geopose"));
    TL_ASSIGN_OR_RETURN(const JsonField position, geopose.Get("position"));
    GppHint hint;
    TL_ASSIGN_OR_RETURN(hint.position.latitude_deg, position.GetNumber("lat"));
    TL_ASSIGN_OR_RETURN(hint.position.longitude_deg, position.GetNumber("lon"));
    TL_RETURN_IF_ERROR(base::WithReason(
        CheckPosition(hint.position, position.path()), "INVALID_REQUEST"));
    double accuracy_m = 0;
    TL_ASSIGN_OR_RETURN(const std::optional<JsonField> accuracy,
                        prior.Find("accuracy"));
    if (accuracy.has_value()) {
      TL_ASSIGN_OR_RETURN(accuracy_m, accuracy->NumberOr("position", 0));
    }
    hint.radius_m = RadiusFor(accuracy_m);
    hints.push_back(hint);
  }
  return absl::OkStatus();
}

// A whole number without a fraction, as clients sent it.
nlohmann::json NumberJson(double value) {
  if (value == std::floor(value) && std::abs(value) < 9e15) {
    return static_cast<int64_t>(value);
  }
  return value;
}

}  // namespace

absl::StatusOr<GppRequest> ParseGppRequest(absl::string_view json) {
  TL_RETURN_IF_ERROR(connect_rpc::CheckJsonShape(json));
  const nlohmann::json document = nlohmann::json::parse(
      json.begin(), json.end(), nullptr, /*allow_exceptions=*/false);
  if (document.is_discarded()) return InvalidRequest("the body is not JSON");
  const JsonField root(document, "");
  GppRequest request;
  TL_ASSIGN_OR_RETURN(const JsonField id, root.Get("id"));
  TL_ASSIGN_OR_RETURN(const absl::string_view id_text, id.AsString());
  request.id = std::string(id_text);
  TL_ASSIGN_OR_RETURN(const JsonField type, root.Get("type"));
  TL_ASSIGN_OR_RETURN(const absl::string_view type_name, type.AsString());
  if (type_name != "geopose") return type.Wrong("only geopose is known");
  TL_ASSIGN_OR_RETURN(const JsonField readings, root.Get("sensorReadings"));
  TL_ASSIGN_OR_RETURN(const std::vector<Reading> cameras,
                      ReadReadings(readings));
  TL_RETURN_IF_ERROR(ReadFrame(cameras, request));
  TL_RETURN_IF_ERROR(ReadLocations(readings, request.hints));
  TL_RETURN_IF_ERROR(ReadPriors(root, request.hints));
  return request;
}

std::string GppAnswerJson(const GppRequest& request, const GeoPose& pose,
                          const GeoAccuracy& accuracy) {
  const geometry::Rotation3& q = pose.enu_from_device;
  const nlohmann::json answer{
      {"id", request.id},
      {"timestamp", NumberJson(request.timestamp_ms)},
      {"type", "geopose"},
      {"accuracy",
       {{"position", accuracy.position_m},
        {"orientation", accuracy.orientation_deg}}},
      {"geopose",
       {{"position",
         {{"lat", pose.position.latitude_deg},
          {"lon", pose.position.longitude_deg},
          {"h", pose.position.height_m}}},
        {"quaternion", {{"x", q.x}, {"y", q.y}, {"z", q.z}, {"w", q.w}}}}}};
  return answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace treeline::gateway
