#include "server/repository/model_index.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/repository/names.h"
#include "server/repository/scene_metadata.h"
#include "server/repository/sha256.h"

namespace treeline::repository {
namespace {

using Json = nlohmann::ordered_json;

// An index needs 4; scene.json may need a few more.
constexpr int kMaxDepth = 16;
constexpr size_t kMaxUrlBytes = 4096;

absl::Status Invalid(absl::string_view where, absl::string_view problem) {
  return absl::InvalidArgumentError(absl::StrCat(where, ": ", problem));
}

// Watches the parser for what the parsed value no longer shows.
class StrictParse {
 public:
  // A callback of Json::parse; false drops the value.
  bool operator()(int depth, Json::parse_event_t event, const Json& value) {
    if (depth > kMaxDepth) problem_ = "is nested too deeply";
    switch (event) {
      case Json::parse_event_t::object_start:
        keys_.emplace_back();
        break;
      case Json::parse_event_t::object_end:
        if (!keys_.empty()) keys_.pop_back();
        break;
      case Json::parse_event_t::key:
        if (!keys_.empty() &&
            !keys_.back().insert(value.get<std::string>()).second) {
          problem_ = "has a key twice";
        }
        break;
      default:
        break;
    }
    return problem_.empty();
  }

  const std::string& problem() const { return problem_; }

 private:
  std::vector<std::set<std::string>> keys_;
  std::string problem_;
};

absl::StatusOr<Json> ParseObject(absl::string_view text,
                                 absl::string_view what) {
  StrictParse strict;
  Json json;
  try {
    json = Json::parse(text.begin(), text.end(),
                       [&](int depth, Json::parse_event_t event, Json& value) {
                         return strict(depth, event, value);
                       });
  } catch (const Json::parse_error& error) {
    // error.what() quotes the text.
    return Invalid(what, absl::StrCat("is not JSON at byte ", error.byte));
  } catch (const Json::exception&) {
    return Invalid(what, "holds a number that is out of range");
  }
  if (!strict.problem().empty()) return Invalid(what, strict.problem());
  if (!json.is_object()) return Invalid(what, "is not an object");
  return json;
}

absl::Status CheckKeys(const Json& object, absl::string_view where,
                       const std::set<std::string>& required,
                       const std::set<std::string>& optional = {}) {
  for (const auto& item : object.items()) {
    if (required.count(item.key()) == 0 && optional.count(item.key()) == 0) {
      return Invalid(where, "has an unknown key; is it of a newer version?");
    }
  }
  for (const std::string& key : required) {
    if (!object.contains(key)) return Invalid(where, "lacks " + key);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> StringAt(const Json& object, const char* key,
                                     absl::string_view where) {
  const Json& value = object.at(key);
  if (!value.is_string()) {
    return Invalid(absl::StrCat(where, ".", key), "is not a string");
  }
  return value.get<std::string>();
}

bool IsUrlText(absl::string_view url) {
  return !url.empty() && url.size() <= kMaxUrlBytes &&
         std::all_of(url.begin(), url.end(),
                     [](char c) { return c > ' ' && c < 0x7f; });
}

absl::StatusOr<IndexedModel> ParseModel(const Json& json,
                                        absl::string_view where) {
  if (!json.is_object()) return Invalid(where, "is not an object");
  TL_RETURN_IF_ERROR(
      CheckKeys(json, where, {"scene", "version", "bytes", "sha256", "url"}));
  IndexedModel model;
  TL_ASSIGN_OR_RETURN(model.scene, StringAt(json, "scene", where));
  TL_RETURN_IF_ERROR(CheckName(absl::StrCat(where, ".scene"), model.scene));
  TL_ASSIGN_OR_RETURN(model.version, StringAt(json, "version", where));
  TL_RETURN_IF_ERROR(CheckName(absl::StrCat(where, ".version"), model.version));
  const Json& bytes = json.at("bytes");
  if (!bytes.is_number_unsigned() || bytes.get<uint64_t>() == 0 ||
      bytes.get<uint64_t>() > kMaxModelBytes) {
    return Invalid(absl::StrCat(where, ".bytes"),
                   absl::StrCat("is not 1 to ", kMaxModelBytes));
  }
  model.bytes = bytes.get<uint64_t>();
  TL_ASSIGN_OR_RETURN(model.sha256, StringAt(json, "sha256", where));
  if (!IsSha256(model.sha256)) {
    return Invalid(absl::StrCat(where, ".sha256"),
                   "is not 64 lower-case hexadecimal digits");
  }
  TL_ASSIGN_OR_RETURN(model.url, StringAt(json, "url", where));
  if (!IsUrlText(model.url)) {
    return Invalid(absl::StrCat(where, ".url"),
                   absl::StrCat("is not 1 to ", kMaxUrlBytes,
                                " printable characters without spaces"));
  }
  return model;
}

absl::Status ParseModels(const Json& models, ModelIndex& index) {
  if (!models.is_array()) return Invalid("models", "is not a list");
  if (models.size() > kMaxIndexedModels) {
    return Invalid("models", absl::StrCat("has ", models.size(), "; at most ",
                                          kMaxIndexedModels));
  }
  std::set<std::pair<std::string, std::string>> names;
  std::map<std::string, uint64_t> sizes;
  index.models.reserve(models.size());
  for (size_t i = 0; i < models.size(); ++i) {
    const std::string where = absl::StrCat("models[", i, "]");
    TL_ASSIGN_OR_RETURN(IndexedModel model, ParseModel(models[i], where));
    if (!names.insert({model.scene, model.version}).second) {
      return Invalid(where, "has a scene and version that were there before");
    }
    if (sizes.insert({model.sha256, model.bytes}).first->second !=
        model.bytes) {
      return Invalid(where, "has a digest that was there with other bytes");
    }
    index.models.push_back(std::move(model));
  }
  return absl::OkStatus();
}

absl::Status ParseScenes(const Json& scenes, ModelIndex& index) {
  if (!scenes.is_object()) return Invalid("scenes", "is not an object");
  for (const auto& item : scenes.items()) {
    TL_RETURN_IF_ERROR(CheckName("scenes", item.key()));
    const std::string where = absl::StrCat("scenes.", item.key());
    if (!item.value().is_object()) return Invalid(where, "is not an object");
    std::string text = item.value().dump();
    if (text.size() > kMaxSceneJsonBytes) {
      return Invalid(where,
                     absl::StrCat("has ", text.size(), " bytes; at most ",
                                  kMaxSceneJsonBytes));
    }
    index.scene_json[item.key()] = std::move(text);
  }
  return absl::OkStatus();
}

absl::Status ParseSignature(const Json& json, ModelIndex& index) {
  if (json.contains("published")) {
    const Json& published = json.at("published");
    if (!published.is_number_unsigned() || published.get<uint64_t>() == 0) {
      return Invalid("published", "is not a time in seconds since 1970");
    }
    index.published_unix_s = published.get<uint64_t>();
  }
  if (!json.contains("signature")) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string text,
                      StringAt(json, "signature", "index"));
  // One text for one signature: the reader is lenient.
  if (!absl::Base64Unescape(text, &index.signature) ||
      index.signature.size() != kSignatureBytes ||
      absl::Base64Escape(index.signature) != text) {
    return Invalid("index.signature", absl::StrCat("is not Base64 of ",
                                                   kSignatureBytes, " bytes"));
  }
  if (index.published_unix_s == 0) return Invalid("index", "lacks published");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ModelIndex> ParseModelIndex(absl::string_view text) {
  if (text.size() > kMaxIndexBytes) {
    return Invalid("index", absl::StrCat("has ", text.size(),
                                         " bytes; at most ", kMaxIndexBytes));
  }
  TL_ASSIGN_OR_RETURN(const Json json, ParseObject(text, "index"));
  TL_RETURN_IF_ERROR(CheckKeys(json, "index", {"models"},
                               {"scenes", "published", "signature"}));
  ModelIndex index;
  TL_RETURN_IF_ERROR(ParseModels(json.at("models"), index));
  if (json.contains("scenes")) {
    TL_RETURN_IF_ERROR(ParseScenes(json.at("scenes"), index));
  }
  TL_RETURN_IF_ERROR(ParseSignature(json, index));
  return index;
}

absl::StatusOr<std::string> ModelIndexJson(const ModelIndex& index) {
  Json json = {{"models", Json::array()}, {"scenes", Json::object()}};
  for (const IndexedModel& model : index.models) {
    json["models"].push_back({{"scene", model.scene},
                              {"version", model.version},
                              {"bytes", model.bytes},
                              {"sha256", model.sha256},
                              {"url", model.url}});
  }
  for (const auto& [scene, text] : index.scene_json) {
    TL_ASSIGN_OR_RETURN(json["scenes"][scene],
                        ParseObject(text, scene + "/scene.json"));
  }
  if (index.published_unix_s > 0) json["published"] = index.published_unix_s;
  if (!index.signature.empty()) {
    json["signature"] = absl::Base64Escape(index.signature);
  }
  return json.dump(1) + "\n";
}

}  // namespace treeline::repository
