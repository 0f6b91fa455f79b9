#include "nav_agent/bridge/dds/topic_names.h"

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"

namespace treeline::dds {
namespace {

absl::Status CheckFullName(absl::string_view name) {
  for (const absl::string_view part :
       absl::StrSplit(absl::StripPrefix(name, "/"), '/')) {
    bool is_good = !part.empty() &&
                   !absl::ascii_isdigit(static_cast<unsigned char>(part[0]));
    for (const char c : part) {
      is_good &= absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_';
    }
    if (!is_good) {
      return absl::InvalidArgumentError(
          absl::StrCat("\"", name,
                       "\" is no name of a topic: between slashes, letters, "
                       "digits and underscores, and no digit first"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> Expanded(absl::string_view name,
                                     const NodeName& node) {
  std::string full;
  const absl::string_view space =
      absl::StripSuffix(absl::StripPrefix(node.name_space, "/"), "/");
  const std::string prefix = space.empty() ? "" : absl::StrCat("/", space);
  if (absl::StartsWith(name, "/")) {
    full = std::string(name);
  } else if (absl::StartsWith(name, "~/")) {
    full = absl::StrCat(prefix, "/", node.node, name.substr(1));
  } else {
    full = absl::StrCat(prefix, "/", name);
  }
  TL_RETURN_IF_ERROR(CheckFullName(full));
  return full;
}

}  // namespace

absl::StatusOr<Remapping> ParseRemapping(absl::string_view text) {
  const std::vector<std::string> sides = absl::StrSplit(text, ":=");
  if (sides.size() != 2 || sides[0].empty() || sides[1].empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", text,
                     "\" is no remapping: write from:=to, as in "
                     "scan:=/front/scan"));
  }
  return Remapping{.from = sides[0], .to = sides[1]};
}

absl::StatusOr<std::string> FullTopicName(absl::string_view name,
                                          const NodeName& node) {
  TL_ASSIGN_OR_RETURN(const std::string full, Expanded(name, node));
  for (const Remapping& rule : node.remappings) {
    TL_ASSIGN_OR_RETURN(const std::string from, Expanded(rule.from, node));
    if (from == full) return Expanded(rule.to, node);
  }
  return full;
}

std::string DdsTopicName(absl::string_view full_name) {
  return absl::StrCat("rt", full_name);
}

std::string DdsRequestTopicName(absl::string_view full_name) {
  return absl::StrCat("rq", full_name, "Request");
}

std::string DdsReplyTopicName(absl::string_view full_name) {
  return absl::StrCat("rr", full_name, "Reply");
}

std::string DdsTypeName(absl::string_view message_name) {
  const size_t slash = message_name.rfind('/');
  std::string modules(message_name.substr(0, slash));
  absl::StrReplaceAll({{"/", "::"}}, &modules);
  return absl::StrCat(modules, "::dds_::", message_name.substr(slash + 1), "_");
}

}  // namespace treeline::dds
