#include "nav_agent/drivers/hokuyo/scip_codec.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace treeline::hokuyo {
namespace {

constexpr char kFirstCharacter = 0x30;

// The decimal number at text[at .. at + digits); nothing but digits.
std::optional<int> DecimalAt(absl::string_view text, size_t at, size_t digits) {
  int value = 0;
  for (const char c : text.substr(at, digits)) {
    if (c < '0' || c > '9') return std::nullopt;
    value = value * 10 + (c - '0');
  }
  return value;
}

std::optional<ScanContent> ContentOf(char letter) {
  switch (letter) {
    case 'D':
      return ScanContent::kDistance;
    case 'S':
      return ScanContent::kShortDistance;
    case 'E':
      return ScanContent::kDistanceAndIntensity;
    default:
      return std::nullopt;
  }
}

char LetterOf(ScanContent content) {
  switch (content) {
    case ScanContent::kShortDistance:
      return 'S';
    case ScanContent::kDistanceAndIntensity:
      return 'E';
    case ScanContent::kDistance:
      break;
  }
  return 'D';
}

}  // namespace

std::optional<uint32_t> DecodeScipNumber(absl::string_view text) {
  if (text.empty() || text.size() > 4) return std::nullopt;
  uint32_t value = 0;
  for (const char c : text) {
    const int bits = c - kFirstCharacter;
    if (bits < 0 || bits > 0x3f) return std::nullopt;
    value = value << 6 | static_cast<uint32_t>(bits);
  }
  return value;
}

std::string EncodeScipNumber(uint32_t value, int characters) {
  std::string text(static_cast<size_t>(characters), kFirstCharacter);
  for (auto c = text.rbegin(); c != text.rend(); ++c, value >>= 6) {
    *c = static_cast<char>(kFirstCharacter + (value & 0x3f));
  }
  return text;
}

char ScipChecksum(absl::string_view text) {
  uint32_t sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<char>((sum & 0x3f) + kFirstCharacter);
}

std::string ScipLine(absl::string_view text) {
  return absl::StrFormat("%s%c\n", text, ScipChecksum(text));
}

std::optional<absl::string_view> CheckedScipLine(absl::string_view line) {
  if (line.size() < 2) return std::nullopt;
  const absl::string_view text = line.substr(0, line.size() - 1);
  if (ScipChecksum(text) != line.back()) return std::nullopt;
  return text;
}

std::optional<absl::string_view> CheckedScipInfoLine(absl::string_view line) {
  if (line.size() < 3 || line[line.size() - 2] != ';') return std::nullopt;
  const absl::string_view text = line.substr(0, line.size() - 2);
  if (ScipChecksum(text) == line.back() ||
      ScipChecksum(text.substr(0, text.find("<-"))) == line.back()) {
    return text;
  }
  return std::nullopt;
}

std::string ScipInfoLine(absl::string_view text) {
  return absl::StrFormat("%s;%c\n", text, ScipChecksum(text));
}

int CharactersPerStep(ScanContent content) {
  switch (content) {
    case ScanContent::kShortDistance:
      return 2;
    case ScanContent::kDistanceAndIntensity:
      return 6;
    case ScanContent::kDistance:
      break;
  }
  return 3;
}

int ScanCommand::Steps() const {
  return (last_step - first_step) / std::max(cluster, 1) + 1;
}

std::string ScanCommand::Text() const {
  std::string text =
      absl::StrFormat("%c%c%04d%04d%02d", continuous ? 'M' : 'G',
                      LetterOf(content), first_step, last_step, cluster);
  if (continuous) absl::StrAppendFormat(&text, "%d%02d", skipped_scans, count);
  return text;
}

std::optional<ScanCommand> ParseScanCommand(absl::string_view text) {
  ScanCommand command;
  if (text.empty() || (text[0] != 'M' && text[0] != 'G')) return std::nullopt;
  command.continuous = text[0] == 'M';
  if (text.size() != (command.continuous ? 15u : 12u)) return std::nullopt;
  const auto content = ContentOf(text[1]);
  const auto first = DecimalAt(text, 2, 4);
  const auto last = DecimalAt(text, 6, 4);
  const auto cluster = DecimalAt(text, 10, 2);
  if (!content || !first || !last || !cluster) return std::nullopt;
  command.content = *content;
  command.first_step = *first;
  command.last_step = *last;
  command.cluster = *cluster;
  if (command.continuous) {
    const auto skipped = DecimalAt(text, 12, 1);
    const auto count = DecimalAt(text, 13, 2);
    if (!skipped || !count) return std::nullopt;
    command.skipped_scans = *skipped;
    command.count = *count;
  }
  return command;
}

}  // namespace treeline::hokuyo
