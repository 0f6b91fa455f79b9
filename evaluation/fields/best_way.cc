#include "evaluation/fields/best_way.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "simulation/building/cylinder_field.h"
#include "simulation/worlds/world.h"

namespace treeline::fields {
namespace {

constexpr absl::string_view kMagic = "\x93NUMPY";
constexpr size_t kMostPoints = 100000;
constexpr double kFarthestCell = 1e6;
// path_coord_to_gazebo_coord of the challenge's run.py.
constexpr double kRadius_m = 0.075;
constexpr double kShiftX_m = -kRadius_m - 30 * 2 * kRadius_m;
constexpr double kShiftY_m = kRadius_m + 5;

static_assert(std::endian::native == std::endian::little);

template <typename Number>
Number At(absl::string_view bytes, size_t index) {
  Number number;
  std::memcpy(&number, bytes.data() + index * sizeof(Number), sizeof(Number));
  return number;
}

double CellAt(absl::string_view kind, absl::string_view bytes, size_t index) {
  if (kind == "i8") return static_cast<double>(At<int64_t>(bytes, index));
  if (kind == "i4") return At<int32_t>(bytes, index);
  if (kind == "f8") return At<double>(bytes, index);
  return static_cast<double>(At<float>(bytes, index));
}

// What follows "'KEY':" in the header, up to `end`.
absl::string_view ValueOf(absl::string_view header, absl::string_view key,
                          char end) {
  const size_t at = header.find(key);
  if (at == absl::string_view::npos) return "";
  const size_t from = at + key.size();
  const size_t to = header.find(end, from);
  return to == absl::string_view::npos
             ? ""
             : absl::StripAsciiWhitespace(header.substr(from, to - from));
}

struct Array {
  absl::string_view kind;  // "i8": the type without its byte order
  absl::string_view bytes;
  size_t points = 0;
};

absl::StatusOr<Array> ParseArray(absl::string_view bytes,
                                 absl::string_view name) {
  const auto error = [&](absl::string_view reason) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", reason));
  };
  // Magic, two bytes of version, the header's length in two bytes or four.
  constexpr size_t kVersionAt = kMagic.size();
  constexpr size_t kLengthAt = kVersionAt + 2;
  if (!absl::StartsWith(bytes, kMagic) || bytes.size() < kLengthAt + 4) {
    return error("this is no array of numpy's");
  }
  const bool is_first = bytes[kVersionAt] == 1;
  const size_t length = is_first ? At<uint16_t>(bytes.substr(kLengthAt), 0)
                                 : At<uint32_t>(bytes.substr(kLengthAt), 0);
  const size_t header_at = kLengthAt + (is_first ? 2 : 4);
  if (length > bytes.size() - header_at) return error("its header is cut off");
  const absl::string_view header = bytes.substr(header_at, length);
  Array array;
  absl::string_view type = ValueOf(header, "'descr':", ',');
  if (!absl::ConsumePrefix(&type, "'<") || !absl::ConsumeSuffix(&type, "'") ||
      (type != "i8" && type != "i4" && type != "f8" && type != "f4")) {
    return error("its numbers are not of <i8, <i4, <f8 or <f4");
  }
  array.kind = type;
  if (ValueOf(header, "'fortran_order':", ',') != "False") {
    return error("it is not in C's order");
  }
  const std::vector<absl::string_view> shape =
      absl::StrSplit(ValueOf(header, "'shape': (", ')'), absl::ByAnyChar(", "),
                     absl::SkipEmpty());
  size_t columns = 0;
  if (shape.size() != 2 || !absl::SimpleAtoi(shape[0], &array.points) ||
      !absl::SimpleAtoi(shape[1], &columns) || columns != 2 ||
      array.points == 0 || array.points > kMostPoints) {
    return error(
        absl::StrCat("it is not N x 2 numbers, N up to ", kMostPoints));
  }
  array.bytes = bytes.substr(header_at + length);
  const size_t number_bytes = array.kind[1] == '8' ? 8 : 4;
  if (array.bytes.size() != array.points * 2 * number_bytes) {
    return error(absl::StrCat("it has ", array.bytes.size(), " bytes for ",
                              array.points, " points"));
  }
  return array;
}

}  // namespace

const char* BestWaySourceName(BestWaySource source) {
  switch (source) {
    case BestWaySource::kCells:
      return "cells";
    case BestWaySource::kPathFile:
      return "path_file";
    case BestWaySource::kStraightLine:
      return "straight_line";
  }
  return "unknown";
}

absl::StatusOr<std::vector<geometry::Vec2>> ParseBarnPath(
    absl::string_view bytes, absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const Array array, ParseArray(bytes, name));
  std::vector<geometry::Vec2> points;
  for (size_t i = 0; i < array.points; ++i) {
    const double column = CellAt(array.kind, array.bytes, 2 * i);
    const double row = CellAt(array.kind, array.bytes, 2 * i + 1);
    if (!(std::abs(column) <= kFarthestCell &&
          std::abs(row) <= kFarthestCell)) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, ": point ", i, " is no cell"));
    }
    points.push_back(
        {column * 2 * kRadius_m + kShiftX_m, row * 2 * kRadius_m + kShiftY_m});
  }
  return points;
}

std::string PathFileBeside(absl::string_view world) {
  const size_t slash = world.rfind('/');
  const size_t at = slash == absl::string_view::npos ? 0 : slash + 1;
  absl::string_view file = world.substr(at);
  int number = 0;
  if (!absl::ConsumePrefix(&file, "world_") ||
      !absl::ConsumeSuffix(&file, ".world") ||
      !absl::SimpleAtoi(file, &number)) {
    return "";
  }
  return absl::StrCat(world.substr(0, at), "path_files/path_", number, ".npy");
}

absl::StatusOr<BestWay> FindBestWay(absl::string_view world,
                                    geometry::Vec2 start, geometry::Vec2 goal) {
  uint64_t field = 0;
  absl::string_view rest = world;
  if (absl::ConsumePrefix(&rest, "field:") && absl::SimpleAtoi(rest, &field)) {
    return BestWay{.length_m = building::BestWay_m(building::DrawField(field)),
                   .source = BestWaySource::kCells};
  }
  BestWay way = {.length_m = geometry::Norm(goal - start),
                 .source = BestWaySource::kStraightLine};
  const std::string path =
      worlds::IsGazeboWorld(world) ? PathFileBeside(world) : "";
  if (path.empty()) return way;
  const absl::StatusOr<std::string> bytes =
      base::ReadFile(path, kMaxPathFileBytes);
  if (absl::IsNotFound(bytes.status())) return way;
  TL_RETURN_IF_ERROR(bytes.status());
  TL_ASSIGN_OR_RETURN(const std::vector<geometry::Vec2> points,
                      ParseBarnPath(*bytes, path));
  way = {.length_m = 0, .source = BestWaySource::kPathFile};
  geometry::Vec2 at = start;
  for (const geometry::Vec2 point : points) {
    way.length_m += geometry::Norm(point - at);
    at = point;
  }
  way.length_m += geometry::Norm(goal - at);
  return way;
}

}  // namespace treeline::fields
