#include "nav_agent/drivers/hokuyo/scip_replies.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::hokuyo {
namespace {

constexpr uint32_t kNoEchoCode = 1;
constexpr uint32_t kTooNearCode = 2;
constexpr uint32_t kOtherErrorCode = 5;

using Fields = std::map<std::string, std::string>;

absl::StatusOr<Fields> DecodeFields(const ScipReply& reply) {
  Fields fields;
  for (const absl::string_view line : reply.lines) {
    const auto text = CheckedScipInfoLine(line);
    const size_t colon = text ? text->find(':') : absl::string_view::npos;
    if (colon == absl::string_view::npos) {
      return absl::DataLossError(
          absl::StrCat("broken line in the reply to ", reply.echo));
    }
    fields[std::string(text->substr(0, colon))] =
        std::string(text->substr(colon + 1));
  }
  return fields;
}

absl::StatusOr<int> NumberIn(const Fields& fields, const std::string& name) {
  const auto found = fields.find(name);
  int value = 0;
  if (found == fields.end() || !absl::SimpleAtoi(found->second, &value)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the sensor's parameters have no number ", name));
  }
  return value;
}

std::string TextIn(const Fields& fields, const std::string& name) {
  const auto found = fields.find(name);
  return found == fields.end() ? "" : found->second;
}

absl::Status Check(const ScipParameters& p) {
  // Steps are written with four digits.
  const bool valid = p.min_mm >= 0 && p.max_mm > p.min_mm &&
                     p.max_mm < (1 << 18) && p.steps_per_turn > 0 &&
                     p.steps_per_turn <= 10'000 && p.first_step >= 0 &&
                     p.last_step > p.first_step && p.last_step <= 9999 &&
                     p.last_step - p.first_step < p.steps_per_turn &&
                     p.front_step >= 0 && p.front_step <= 9999 &&
                     p.turns_per_minute > 0 && p.turns_per_minute <= 60'000;
  if (valid) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "the sensor's parameters make no sense: DMIN ", p.min_mm, ", DMAX ",
      p.max_mm, ", ARES ", p.steps_per_turn, ", AMIN ", p.first_step, ", AMAX ",
      p.last_step, ", AFRT ", p.front_step, ", SCAN ", p.turns_per_minute));
}

// Six bits of each of `count` characters; false if one is no such character.
// Written without branches inside the loop, since every character of every
// scan goes through it.
bool DecodeCharacters(const char* text, size_t count, uint32_t& value) {
  uint32_t bits = 0;
  uint32_t wrong = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t six =
        static_cast<uint32_t>(static_cast<unsigned char>(text[i])) - 0x30u;
    wrong |= six;
    bits = bits << 6 | (six & 0x3f);
  }
  value = bits;
  return (wrong & ~0x3fu) == 0;
}

// The characters of all data lines, without their check sums.
absl::Status JoinData(std::span<const absl::string_view> lines,
                      size_t characters, std::string& data) {
  data.clear();
  for (size_t i = 0; i < lines.size(); ++i) {
    const auto text = CheckedScipLine(lines[i]);
    if (!text) return absl::DataLossError("check sum of a scan's line");
    // All lines but the last are full.
    if (text->size() > kScipLineData ||
        (i + 1 < lines.size() && text->size() != kScipLineData)) {
      return absl::DataLossError("length of a scan's line");
    }
    data.append(text->data(), text->size());
  }
  if (data.size() != characters) {
    return absl::DataLossError("length of a scan");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ScipParameters> DecodeParameters(const ScipReply& reply) {
  TL_ASSIGN_OR_RETURN(const Fields fields, DecodeFields(reply));
  ScipParameters result;
  result.model = TextIn(fields, "MODL");
  TL_ASSIGN_OR_RETURN(result.min_mm, NumberIn(fields, "DMIN"));
  TL_ASSIGN_OR_RETURN(result.max_mm, NumberIn(fields, "DMAX"));
  TL_ASSIGN_OR_RETURN(result.steps_per_turn, NumberIn(fields, "ARES"));
  TL_ASSIGN_OR_RETURN(result.first_step, NumberIn(fields, "AMIN"));
  TL_ASSIGN_OR_RETURN(result.last_step, NumberIn(fields, "AMAX"));
  TL_ASSIGN_OR_RETURN(result.front_step, NumberIn(fields, "AFRT"));
  TL_ASSIGN_OR_RETURN(result.turns_per_minute, NumberIn(fields, "SCAN"));
  TL_RETURN_IF_ERROR(Check(result));
  return result;
}

absl::StatusOr<ScipVersion> DecodeVersion(const ScipReply& reply) {
  TL_ASSIGN_OR_RETURN(const Fields fields, DecodeFields(reply));
  return ScipVersion{.vendor = TextIn(fields, "VEND"),
                     .product = TextIn(fields, "PROD"),
                     .firmware = TextIn(fields, "FIRM"),
                     .protocol = TextIn(fields, "PROT"),
                     .serial = TextIn(fields, "SERI")};
}

absl::StatusOr<std::string> DecodeCondition(const ScipReply& reply) {
  TL_ASSIGN_OR_RETURN(const Fields fields, DecodeFields(reply));
  return TextIn(fields, "STAT");
}

absl::StatusOr<int64_t> DecodeTime(const ScipReply& reply) {
  if (reply.lines.empty() || reply.lines[0].size() != 5) {
    return absl::DataLossError("a reply without its time");
  }
  const auto text = CheckedScipLine(reply.lines[0]);
  const auto time = text ? DecodeScipNumber(*text) : std::nullopt;
  if (!time) return absl::DataLossError("check sum of a time");
  return static_cast<int64_t>(*time);
}

std::string EncodeParameters(const ScipParameters& parameters) {
  return absl::StrCat(
      ScipInfoLine(absl::StrCat("MODL:", parameters.model)),
      ScipInfoLine(absl::StrCat("DMIN:", parameters.min_mm)),
      ScipInfoLine(absl::StrCat("DMAX:", parameters.max_mm)),
      ScipInfoLine(absl::StrCat("ARES:", parameters.steps_per_turn)),
      ScipInfoLine(absl::StrCat("AMIN:", parameters.first_step)),
      ScipInfoLine(absl::StrCat("AMAX:", parameters.last_step)),
      ScipInfoLine(absl::StrCat("AFRT:", parameters.front_step)),
      ScipInfoLine(absl::StrCat("SCAN:", parameters.turns_per_minute)), "\n");
}

std::string EncodeVersion(const ScipVersion& version) {
  return absl::StrCat(ScipInfoLine(absl::StrCat("VEND:", version.vendor)),
                      ScipInfoLine(absl::StrCat("PROD:", version.product)),
                      ScipInfoLine(absl::StrCat("FIRM:", version.firmware)),
                      ScipInfoLine(absl::StrCat("PROT:", version.protocol)),
                      ScipInfoLine(absl::StrCat("SERI:", version.serial)),
                      "\n");
}

absl::Status DecodeScan(const ScipReply& reply, const ScanCommand& command,
                        ScipScan& scan) {
  TL_ASSIGN_OR_RETURN(scan.time_ms, DecodeTime(reply));
  const auto steps = static_cast<size_t>(command.Steps());
  const auto width = static_cast<size_t>(CharactersPerStep(command.content));
  // At most 13 KB; one allocation a scan.
  std::string data;
  data.reserve(steps * width);
  TL_RETURN_IF_ERROR(JoinData(reply.lines.subspan(1), steps * width, data));
  const bool with_intensity =
      command.content == ScanContent::kDistanceAndIntensity;
  const size_t distance_width = with_intensity ? 3 : width;
  scan.codes.resize(steps);
  scan.intensities.resize(with_intensity ? steps : 0);
  bool good = true;
  for (size_t i = 0; i < steps; ++i) {
    const char* step = data.data() + i * width;
    good &= DecodeCharacters(step, distance_width, scan.codes[i]);
    if (!with_intensity) continue;
    uint32_t intensity = 0;
    good &= DecodeCharacters(step + distance_width, 3, intensity);
    scan.intensities[i] =
        static_cast<uint16_t>(std::min<uint32_t>(intensity, 0xffff));
  }
  if (!good) return absl::DataLossError("characters of a scan");
  return absl::OkStatus();
}

std::string EncodeScan(const ScipScan& scan, ScanContent content) {
  std::string data;
  const bool with_intensity = content == ScanContent::kDistanceAndIntensity;
  for (size_t i = 0; i < scan.codes.size(); ++i) {
    data += EncodeScipNumber(scan.codes[i],
                             content == ScanContent::kShortDistance ? 2 : 3);
    if (!with_intensity) continue;
    const bool known = i < scan.intensities.size();
    data += EncodeScipNumber(known ? scan.intensities[i] : 0, 3);
  }
  const auto time = static_cast<uint32_t>(scan.time_ms % kScipTimeSpan_ms);
  std::string reply = ScipLine(EncodeScipNumber(time, 4));
  absl::string_view rest = data;
  while (!rest.empty()) {
    reply += ScipLine(rest.substr(0, kScipLineData));
    rest.remove_prefix(std::min<size_t>(rest.size(), kScipLineData));
  }
  return reply + "\n";
}

float RangeOfCode(uint32_t code, const ScipParameters& parameters) {
  const auto mm = static_cast<int64_t>(code);
  if (mm >= parameters.max_mm) return core::kNoReturn;
  if (mm >= parameters.min_mm) return static_cast<float>(mm) * 1e-3f;
  switch (code) {
    case 0:
    case 3:
    case kOtherErrorCode:
      return core::kInvalidRange;
    case kNoEchoCode:
      return core::kNoReturn;
    default:
      return core::kTooNear;
  }
}

uint32_t CodeOfRange(float range_m, const ScipParameters& parameters) {
  if (std::isnan(range_m)) return kOtherErrorCode;
  const float mm = std::round(range_m * 1e3f);
  if (mm < static_cast<float>(parameters.min_mm)) return kTooNearCode;
  if (mm >= static_cast<float>(parameters.max_mm)) return kNoEchoCode;
  return static_cast<uint32_t>(mm);
}

core::RangeSensorInfo InfoOf(const ScipParameters& parameters,
                             const ScanCommand& command) {
  const double step_rad = 2 * std::numbers::pi / parameters.steps_per_turn;
  const double turn_s = 60.0 / parameters.turns_per_minute;
  const int cluster = std::max(command.cluster, 1);
  // Merged neighbours stand for the direction in their middle.
  const double first = command.first_step + (cluster - 1) / 2.0;
  return {.angle_min_rad = (first - parameters.front_step) * step_rad,
          .angle_increment_rad = cluster * step_rad,
          .beams = command.Steps(),
          .range_min_m = parameters.min_mm * 1e-3,
          .range_max_m = parameters.max_mm * 1e-3,
          .beam_interval_s = cluster * turn_s / parameters.steps_per_turn,
          .scan_interval_s = turn_s * (command.skipped_scans + 1)};
}

}  // namespace treeline::hokuyo
