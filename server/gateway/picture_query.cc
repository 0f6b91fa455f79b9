#include "server/gateway/picture_query.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/algorithm/container.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"
#include "common/camera/camera.h"
#include "common/connect_rpc/connect_error.h"
#include "common/connect_rpc/connect_message.h"
#include "common/image/decode.h"
#include "common/wire/camera.h"
#include "server/gateway/form_data.h"

namespace treeline::gateway {
namespace {

using connect_rpc::InvalidRequest;
using connect_rpc::MediaType;

constexpr char kForm[] = "multipart/form-data";
constexpr double kMillimetres = 0.001;

// The words of a query. Values are views of the request.
class Words {
 public:
  absl::Status Add(absl::string_view name, absl::string_view value) {
    if (name == "image") name = "color";
    if (name == "candidate_scene") {
      candidates_.emplace_back(value);
      return absl::OkStatus();
    }
    if (!absl::c_linear_search(kNames, name)) {
      return InvalidRequest(absl::StrCat(
          "'", name, "' is unknown; there are image, candidate_scene, ",
          absl::StrJoin(kNames, ", ")));
    }
    if (!values_.emplace(std::string(name), value).second) {
      return InvalidRequest(absl::StrCat("'", name, "' comes twice"));
    }
    return absl::OkStatus();
  }

  // Empty: it is not there.
  absl::string_view Get(absl::string_view name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? absl::string_view() : found->second;
  }
  bool Has(absl::string_view name) const { return values_.contains(name); }
  const std::vector<std::string>& candidates() const { return candidates_; }

  absl::StatusOr<double> Number(absl::string_view name, double absent) const {
    if (!Has(name)) return absent;
    double value = 0;
    if (absl::SimpleAtod(Get(name), &value)) return value;
    return Wrong(name, "is no number");
  }
  absl::StatusOr<bool> Flag(absl::string_view name) const {
    if (!Has(name)) return false;
    bool value = false;
    if (absl::SimpleAtob(Get(name), &value)) return value;
    return Wrong(name, "is neither true nor false");
  }
  absl::Status Wrong(absl::string_view name, absl::string_view what) const {
    return InvalidRequest(absl::StrCat("'", name, "' ", what));
  }

 private:
  static constexpr absl::string_view kNames[] = {
      "color", "depth",       "registered",    "depth_unit",     "camera",
      "scene", "orientation", "model_version", "min_confidence", "seed"};

  std::map<std::string, absl::string_view, std::less<>> values_;
  std::vector<std::string> candidates_;
};

absl::Status ReadBody(const http::HttpRequest& http, Words& words) {
  const std::string type(http.Header("content-type"));
  if (MediaType(type) != kForm) return words.Add("color", http.body);
  TL_ASSIGN_OR_RETURN(const std::vector<FormPart> parts,
                      ParseFormData(type, http.body));
  for (const FormPart& part : parts) {
    TL_RETURN_IF_ERROR(words.Add(part.name, part.bytes));
  }
  return absl::OkStatus();
}

absl::StatusOr<v1::Orientation> OrientationOf(const Words& words) {
  const absl::string_view up = words.Get("orientation");
  if (up == "top") return v1::ORIENTATION_TOP_UP;
  if (up == "right") return v1::ORIENTATION_RIGHT_UP;
  if (up == "bottom") return v1::ORIENTATION_BOTTOM_UP;
  if (up == "left") return v1::ORIENTATION_LEFT_UP;
  return words.Wrong("orientation", "is none of top, right, bottom, left");
}

absl::Status ReadDepth(const Words& words, v1::Frame& frame) {
  if (!words.Has("depth")) {
    for (const char* name : {"registered", "depth_unit"}) {
      if (words.Has(name)) return words.Wrong(name, "goes with depth only");
    }
    return absl::OkStatus();
  }
  TL_ASSIGN_OR_RETURN(const bool registered, words.Flag("registered"));
  TL_ASSIGN_OR_RETURN(const double unit_m,
                      words.Number("depth_unit", kMillimetres));
  v1::DepthImage& depth = *frame.mutable_depth();
  depth.set_png(std::string(words.Get("depth")));
  depth.set_unit_m(unit_m);
  depth.set_registration(registered ? v1::DEPTH_REGISTRATION_REGISTERED_TO_COLOR
                                    : v1::DEPTH_REGISTRATION_SCENE_CALIBRATION);
  return absl::OkStatus();
}

absl::Status ReadFrame(const Words& words, v1::Frame& frame) {
  const absl::string_view picture = words.Get("color");
  if (picture.empty()) {
    return InvalidRequest(
        "there is no picture: send a JPEG or PNG as the body, or as 'image' of "
        "a form");
  }
  frame.mutable_color()->set_encoded(std::string(picture));
  if (words.Has("camera")) {
    TL_ASSIGN_OR_RETURN(const image::ImageSize size,
                        image::ReadImageSize(picture));
    const absl::StatusOr<camera::Camera> camera =
        camera::Camera::Parse(words.Get("camera"), size.width, size.height);
    if (!camera.ok()) return words.Wrong("camera", camera.status().message());
    *frame.mutable_camera() = wire::ToProto(*camera);
  }
  if (words.Has("orientation")) {
    TL_ASSIGN_OR_RETURN(const v1::Orientation up, OrientationOf(words));
    frame.set_orientation(up);
  }
  return ReadDepth(words, frame);
}

absl::Status ReadOptions(const Words& words, v1::LocalizeOptions& options) {
  if (words.Has("min_confidence")) {
    TL_ASSIGN_OR_RETURN(const double confidence,
                        words.Number("min_confidence", 0));
    options.set_min_confidence(confidence);
  }
  if (words.Has("seed")) {
    uint64_t seed = 0;
    if (!absl::SimpleAtoi(words.Get("seed"), &seed)) {
      return words.Wrong("seed", "is no whole number");
    }
    options.set_seed(seed);
  }
  return absl::OkStatus();
}

}  // namespace

bool MayBePicture(absl::string_view content_type) {
  const std::string type = MediaType(content_type);
  return type.empty() || type == kForm || absl::StartsWith(type, "image/") ||
         type == "application/octet-stream" ||
         type == "application/x-www-form-urlencoded";
}

absl::StatusOr<v1::LocalizeRequest> ParsePictureQuery(
    const http::HttpRequest& http) {
  Words words;
  for (const auto& [name, value] : http.query) {
    TL_RETURN_IF_ERROR(words.Add(name, value));
  }
  TL_RETURN_IF_ERROR(ReadBody(http, words));
  v1::LocalizeRequest request;
  TL_RETURN_IF_ERROR(ReadFrame(words, *request.mutable_frame()));
  if (words.Has("min_confidence") || words.Has("seed")) {
    TL_RETURN_IF_ERROR(ReadOptions(words, *request.mutable_options()));
  }
  request.set_scene(std::string(words.Get("scene")));
  request.set_model_version(std::string(words.Get("model_version")));
  request.mutable_candidate_scenes()->Assign(words.candidates().begin(),
                                             words.candidates().end());
  return request;
}

}  // namespace treeline::gateway
