// The alphabet of SCIP 2.x, the protocol of Hokuyo's laser scanners: numbers
// as characters, check sums and commands. Pure functions.
//
// Source: Hokuyo, "Communication Protocol Specification for SCIP2.0 Standard"
// (C-42-03320B, 2008), and that of the UTM-30LX-EW.
#ifndef NAV_AGENT_DRIVERS_HOKUYO_SCIP_CODEC_H_
#define NAV_AGENT_DRIVERS_HOKUYO_SCIP_CODEC_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::hokuyo {

// Timestamps count milliseconds in 24 bits, and begin again after 4.66 hours.
inline constexpr int64_t kScipTimeSpan_ms = 1 << 24;
// Data come in lines of at most so many characters, and one of check sum.
inline constexpr int kScipLineData = 64;

// The number in 1 to 4 characters: six bits each, most significant first,
// written as 0x30 + bits ("CB" = 1234, "1Dh" = 5432). Nothing if a character
// is none of these 64.
std::optional<uint32_t> DecodeScipNumber(absl::string_view text);
// The lowest 6 * characters bits of `value`.
std::string EncodeScipNumber(uint32_t value, int characters);

// The low six bits of the sum of all characters, plus 0x30.
char ScipChecksum(absl::string_view text);
// `text` with its check sum, and the end of the line.
std::string ScipLine(absl::string_view text);

// What a line of data or status says before its last character, its check sum;
// nothing if the two do not agree or the line is shorter than two characters.
std::optional<absl::string_view> CheckedScipLine(absl::string_view line);
// The same for lines "NAME:value;S" in answers to VV, PP and II, whose sum
// leaves the semicolon out. Some UTM-30LX also leave out a remark that begins
// with "<-" (gearbox mailing list, 2009-04-14), so that is accepted as well.
std::optional<absl::string_view> CheckedScipInfoLine(absl::string_view line);
// "NAME:value" as such a line, with its end.
std::string ScipInfoLine(absl::string_view text);

// What one step of a scan consists of.
enum class ScanContent {
  kDistance,              // D: distance in 3 characters
  kShortDistance,         // S: distance in 2 characters, below 4.096 m
  kDistanceAndIntensity,  // E: distance in 3 characters, intensity in 3
};
int CharactersPerStep(ScanContent content);

// A request to measure: M... is answered with one reply for each scan until
// `count` of them were sent, G... with the latest scan alone.
struct ScanCommand {
  bool continuous = true;
  ScanContent content = ScanContent::kDistance;
  // Steps 0 to 9999, both included; so many neighbours are merged into one.
  int first_step = 0;
  int last_step = 0;
  int cluster = 1;
  // Only where continuous: scans left out between two, 0 to 9; and how many
  // are wanted, 0: without end.
  int skipped_scans = 0;
  int count = 0;

  // Numbers that each scan has.
  int Steps() const;
  // "MD0000108001000", without the end of the line.
  std::string Text() const;
  bool operator==(const ScanCommand&) const = default;
};
// What ScanCommand::Text() says; nothing if it is not made like one (a sensor
// says in its status what is wrong, see docs/reference/laser-driver.md).
std::optional<ScanCommand> ParseScanCommand(absl::string_view text);

}  // namespace treeline::hokuyo

#endif  // NAV_AGENT_DRIVERS_HOKUYO_SCIP_CODEC_H_
