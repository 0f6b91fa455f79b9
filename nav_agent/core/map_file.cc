#include "nav_agent/core/map_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/nearest_name.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "common/yaml/yaml_node.h"
#include "nav_agent/core/doubtful_map.h"

namespace treeline::core {
namespace {

constexpr uint16_t kFreeGrey = 254;
constexpr uint16_t kOccupiedGrey = 0;
constexpr uint16_t kUnknownGrey = 205;
// So much of a map that is unknown and counts as free is told of.
constexpr double kToldShare = 0.01;

// What map_server reads of a map's YAML.
constexpr absl::string_view kKnownKeys[] = {
    "image",           "resolution",  "origin", "negate",
    "occupied_thresh", "free_thresh", "mode"};

enum class MapMode { kTrinary, kScale, kRaw };

struct MapSettings {
  std::string image;
  double resolution_m = 0.05;
  geometry::Rigid2 map_from_grid;
  bool negate = false;
  double occupied_threshold = 0.65;
  double free_threshold = 0.196;
  MapMode mode = MapMode::kTrinary;
  std::vector<std::string> unknown_keys;
};

// Words of a PGM's head, comments left out.
class PgmWords {
 public:
  explicit PgmWords(absl::string_view bytes) : rest_(bytes) {}

  absl::string_view Next() {
    while (!rest_.empty()) {
      if (rest_[0] == '#') {
        const size_t end = rest_.find('\n');
        rest_ = end == absl::string_view::npos ? "" : rest_.substr(end);
      } else if (IsSpace(rest_[0])) {
        rest_.remove_prefix(1);
      } else {
        break;
      }
    }
    size_t length = 0;
    while (length < rest_.size() && !IsSpace(rest_[length])) ++length;
    const absl::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }
  // A whole number in [min, max], or false.
  bool NextNumber(int64_t min, int64_t max, int64_t& value) {
    return absl::SimpleAtoi(Next(), &value) && value >= min && value <= max;
  }
  absl::string_view rest() const { return rest_; }

 private:
  static bool IsSpace(char c) {
    return absl::ascii_isspace(static_cast<unsigned char>(c));
  }
  absl::string_view rest_;
};

absl::Status PgmError(absl::string_view name, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(name, ": ", what));
}

absl::Status ReadPlainValues(PgmWords& words, absl::string_view name,
                             GreyPicture& picture) {
  for (uint16_t& grey : picture.values) {
    int64_t value = 0;
    if (!words.NextNumber(0, picture.max_value, value)) {
      return PgmError(name,
                      absl::StrCat("a grey level is missing or not in 0..",
                                   picture.max_value));
    }
    grey = static_cast<uint16_t>(value);
  }
  return absl::OkStatus();
}

absl::Status ReadRawValues(absl::string_view bytes, absl::string_view name,
                           GreyPicture& picture) {
  const size_t width = picture.max_value > 255 ? 2 : 1;
  if (bytes.size() < width * picture.values.size()) {
    return PgmError(
        name, absl::StrCat("it ends after ", bytes.size(), " of ",
                           width * picture.values.size(), " bytes of picture"));
  }
  for (size_t i = 0; i < picture.values.size(); ++i) {
    uint32_t value = static_cast<uint8_t>(bytes[width * i]);
    if (width == 2) value = value << 8 | static_cast<uint8_t>(bytes[2 * i + 1]);
    if (value > static_cast<uint32_t>(picture.max_value)) {
      return PgmError(name, absl::StrCat("grey level ", value, " is above ",
                                         picture.max_value));
    }
    picture.values[i] = static_cast<uint16_t>(value);
  }
  return absl::OkStatus();
}

absl::StatusOr<MapSettings> ReadSettings(const yaml::YamlNode& yaml) {
  MapSettings settings;
  const std::vector<std::string> keys = yaml.Keys();
  for (const std::string& key : keys) {
    if (std::ranges::count(keys, key) > 1) {
      return yaml.Error(absl::StrCat("'", key, "' stands there twice"));
    }
    if (std::ranges::find(kKnownKeys, key) != std::end(kKnownKeys)) continue;
    const std::string nearest = base::NearestName(key, kKnownKeys);
    if (!nearest.empty()) {
      TL_ASSIGN_OR_RETURN(const yaml::YamlNode value, yaml.Get(key));
      return value.Error(absl::StrCat("unknown key '", key, "'; did you mean '",
                                      nearest, "'?"));
    }
    settings.unknown_keys.push_back(key);
  }
  TL_ASSIGN_OR_RETURN(settings.image, yaml.Text("image"));
  TL_ASSIGN_OR_RETURN(settings.resolution_m,
                      yaml.Number("resolution", 1e-3, 100));
  TL_ASSIGN_OR_RETURN(const std::vector<double> origin,
                      yaml.Numbers("origin", 3, -1e7, 1e7));
  settings.map_from_grid = {.translation = {origin[0], origin[1]},
                            .yaw_rad = origin[2]};
  // map_server wants 0 or 1 here.
  if (yaml.Has("negate")) {
    TL_ASSIGN_OR_RETURN(const int negate,
                        yaml.Choice("negate", {"0", "1", "false", "true"}));
    settings.negate = negate % 2 == 1;
  }
  TL_ASSIGN_OR_RETURN(
      settings.occupied_threshold,
      yaml.NumberOr("occupied_thresh", settings.occupied_threshold, 0, 1));
  TL_ASSIGN_OR_RETURN(
      settings.free_threshold,
      yaml.NumberOr("free_thresh", settings.free_threshold, 0, 1));
  if (settings.free_threshold > settings.occupied_threshold) {
    return yaml.Error(absl::StrCat("free_thresh, ", settings.free_threshold,
                                   ", is above occupied_thresh, ",
                                   settings.occupied_threshold));
  }
  if (yaml.Has("mode")) {
    TL_ASSIGN_OR_RETURN(const int mode,
                        yaml.Choice("mode", {"trinary", "scale", "raw"}));
    settings.mode = static_cast<MapMode>(mode);
  }
  return settings;
}

Occupancy OccupancyOf(uint16_t grey, const GreyPicture& picture,
                      const MapSettings& settings) {
  if (settings.mode == MapMode::kRaw) {
    // The occupancy in percent itself.
    if (grey > 100) return Occupancy::kUnknown;
    if (grey >= 100 * settings.occupied_threshold) return Occupancy::kOccupied;
    return grey <= 100 * settings.free_threshold ? Occupancy::kFree
                                                 : Occupancy::kUnknown;
  }
  const double brightness =
      static_cast<double>(grey) / static_cast<double>(picture.max_value);
  const double occupied = settings.negate ? brightness : 1 - brightness;
  if (occupied > settings.occupied_threshold) return Occupancy::kOccupied;
  if (occupied < settings.free_threshold) return Occupancy::kFree;
  return Occupancy::kUnknown;
}

// As map_server's; 255: none.
uint8_t ValueOf(uint16_t grey, const GreyPicture& picture,
                const MapSettings& settings) {
  constexpr uint8_t kNone = 255;
  if (settings.mode == MapMode::kRaw) {
    return grey <= 100 ? static_cast<uint8_t>(grey) : kNone;
  }
  const double brightness =
      static_cast<double>(grey) / static_cast<double>(picture.max_value);
  const double occupied = settings.negate ? brightness : 1 - brightness;
  if (occupied >= settings.occupied_threshold) return 100;
  if (occupied <= settings.free_threshold) return 0;
  if (settings.mode == MapMode::kTrinary) return kNone;
  return static_cast<uint8_t>(
      std::lround(100 * (occupied - settings.free_threshold) /
                  (settings.occupied_threshold - settings.free_threshold)));
}

// PGM, or PNG by its first bytes.
absl::StatusOr<GreyPicture> ParsePicture(absl::string_view bytes,
                                         const std::string& name) {
  if (image::SniffFormat(bytes) != image::ImageFormat::kPng) {
    return ParsePgm(bytes, name);
  }
  const auto colors = image::DecodeColor(bytes);
  if (!colors.ok()) return base::Annotate(colors.status(), name);
  GreyPicture picture{.width = colors->width,
                      .height = colors->height,
                      .max_value = 255,
                      .values = {}};
  picture.values.reserve(colors->rgb.size() / 3);
  for (size_t i = 0; i < colors->rgb.size(); i += 3) {
    const int sum = colors->rgb[i] + colors->rgb[i + 1] + colors->rgb[i + 2];
    picture.values.push_back(static_cast<uint16_t>((sum + 1) / 3));
  }
  return picture;
}

// A map's file, before anything is made of its pixels.
struct MapPicture {
  MapSettings settings;
  GreyPicture picture;
};

// Beside the file, or, where the file is a link, beside what it is a link to.
std::filesystem::path PicturePath(const std::string& path,
                                  const std::string& image) {
  namespace fs = std::filesystem;
  const fs::path beside = fs::path(path).parent_path() / image;
  std::error_code error;
  if (fs::exists(beside, error)) return beside;
  const fs::path target = fs::canonical(path, error);
  if (error) return beside;
  const fs::path beside_target = target.parent_path() / image;
  return fs::exists(beside_target, error) ? beside_target : beside;
}

absl::StatusOr<MapPicture> ReadMapPicture(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode yaml, yaml::YamlNode::Read(path));
  MapPicture map;
  TL_ASSIGN_OR_RETURN(map.settings, ReadSettings(yaml));
  const std::filesystem::path image = PicturePath(path, map.settings.image);
  TL_ASSIGN_OR_RETURN(const std::string bytes, base::ReadFile(image.string()));
  TL_ASSIGN_OR_RETURN(map.picture, ParsePicture(bytes, image.string()));
  return map;
}

// map_saver writes what is unknown as grey 205, and Nav2's writes
// `free_thresh: 0.25` beside it, which makes that free.
std::string DoubtOfUnknownCells(const MapPicture& map) {
  const auto& [settings, picture] = map;
  if (settings.mode == MapMode::kRaw || picture.max_value != 255 ||
      OccupancyOf(kUnknownGrey, picture, settings) != Occupancy::kFree) {
    return "";
  }
  const double share =
      static_cast<double>(std::ranges::count(picture.values, kUnknownGrey)) /
      static_cast<double>(picture.values.size());
  if (settings.negate || share < kToldShare) return "";
  return absl::StrFormat(
      "%.0f %% of its cells are of the grey that map_saver writes for unknown "
      "(205), and free_thresh: %g makes them free, as in Nav2; set "
      "free_thresh to 0.196 for them to be unknown",
      100 * share, settings.free_threshold);
}

// Programs write more than map_server reads, and it passes over that.
std::string DoubtOf(const MapPicture& map) {
  std::string doubt = DoubtOfUnknownCells(map);
  if (!map.settings.unknown_keys.empty()) {
    absl::StrAppend(&doubt, doubt.empty() ? "" : "; ",
                    "not known, and passed over: ",
                    absl::StrJoin(map.settings.unknown_keys, ", "));
  }
  return doubt;
}

}  // namespace

absl::StatusOr<GreyPicture> ParsePgm(absl::string_view bytes,
                                     absl::string_view name) {
  PgmWords words(bytes);
  const absl::string_view magic = words.Next();
  if (magic != "P5" && magic != "P2") {
    return PgmError(name, "this is neither a PGM (P5 or P2) nor a PNG picture");
  }
  int64_t width = 0;
  int64_t height = 0;
  int64_t max_value = 0;
  if (!words.NextNumber(1, 1 << 20, width) ||
      !words.NextNumber(1, 1 << 20, height) ||
      !words.NextNumber(1, 65535, max_value)) {
    return PgmError(name,
                    "width, height or the largest grey level is missing "
                    "or out of range");
  }
  // Each value takes a byte at least; a plain one two.
  if (width * height > static_cast<int64_t>(bytes.size()) ||
      width * height > kMaxMapCells) {
    return PgmError(name, absl::StrCat("it is too short for ", width, " x ",
                                       height, " grey levels"));
  }
  GreyPicture picture{.width = static_cast<int>(width),
                      .height = static_cast<int>(height),
                      .max_value = static_cast<int>(max_value),
                      .values = {}};
  picture.values.resize(static_cast<size_t>(width * height));
  if (magic == "P2") {
    TL_RETURN_IF_ERROR(ReadPlainValues(words, name, picture));
  } else {
    // One white space ends the head.
    absl::string_view rest = words.rest();
    if (!rest.empty()) rest.remove_prefix(1);
    TL_RETURN_IF_ERROR(ReadRawValues(rest, name, picture));
  }
  return picture;
}

std::string FormatPgm(const GreyPicture& picture) {
  std::string bytes = absl::StrCat("P5\n", picture.width, " ", picture.height,
                                   "\n", picture.max_value, "\n");
  for (const uint16_t value : picture.values) {
    if (picture.max_value > 255) bytes.push_back(static_cast<char>(value >> 8));
    bytes.push_back(static_cast<char>(value & 255));
  }
  return bytes;
}

absl::StatusOr<OccupancyGrid> ReadMap(const std::string& path) {
  TL_ASSIGN_OR_RETURN(DoubtfulMap map, ReadDoubtfulMap(path));
  return std::move(map.grid);
}

absl::StatusOr<DoubtfulMap> ReadDoubtfulMap(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const MapPicture map, ReadMapPicture(path));
  OccupancyGrid grid = OccupancyGrid::Filled(
      map.picture.width, map.picture.height, map.settings.resolution_m,
      map.settings.map_from_grid, Occupancy::kUnknown);
  size_t i = 0;
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      grid.Set({x, y},
               OccupancyOf(map.picture.values[i++], map.picture, map.settings));
    }
  }
  return DoubtfulMap{.grid = std::move(grid), .doubt = DoubtOf(map)};
}

absl::StatusOr<ValueGrid> ReadMapValues(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const MapPicture map, ReadMapPicture(path));
  ValueGrid grid = {.width = map.picture.width,
                    .height = map.picture.height,
                    .resolution_m = map.settings.resolution_m,
                    .map_from_grid = map.settings.map_from_grid,
                    .values = {}};
  grid.values.reserve(map.picture.values.size());
  const auto width = static_cast<size_t>(grid.width);
  for (size_t row = static_cast<size_t>(grid.height); row-- > 0;) {
    for (size_t x = 0; x < width; ++x) {
      grid.values.push_back(ValueOf(map.picture.values[row * width + x],
                                    map.picture, map.settings));
    }
  }
  return grid;
}

absl::Status WriteMap(const OccupancyGrid& grid, const std::string& path) {
  absl::string_view stem = path;
  if (!absl::ConsumeSuffix(&stem, ".yaml")) {
    return absl::InvalidArgumentError(
        absl::StrCat("a map's name ends in .yaml; got ", path));
  }
  GreyPicture picture{.width = grid.width,
                      .height = grid.height,
                      .max_value = 255,
                      .values = {}};
  picture.values.reserve(grid.cells.size());
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const Occupancy value = grid.At({x, y});
      picture.values.push_back(value == Occupancy::kFree       ? kFreeGrey
                               : value == Occupancy::kOccupied ? kOccupiedGrey
                                                               : kUnknownGrey);
    }
  }
  const std::string image = absl::StrCat(stem, ".pgm");
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(image, FormatPgm(picture)));
  const geometry::Rigid2& origin = grid.map_from_grid;
  return base::WriteFileAtomically(
      path, absl::StrFormat("image: %s\nmode: trinary\nresolution: %.9g\n"
                            "origin: [%.9g, %.9g, %.9g]\nnegate: 0\n"
                            "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                            std::filesystem::path(image).filename().string(),
                            grid.resolution_m, origin.translation.x,
                            origin.translation.y, origin.yaw_rad));
}

}  // namespace treeline::core
