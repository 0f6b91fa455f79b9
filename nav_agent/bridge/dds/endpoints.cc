#include "nav_agent/bridge/dds/endpoints.h"

#include <algorithm>
#include <functional>
#include <set>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/strip.h"

namespace treeline::dds {
namespace {

constexpr size_t kNamed = 6;

// At most kNamed of them, and how many more there are.
std::string Listed(const std::set<std::string>& names) {
  const auto end =
      names.size() > kNamed ? std::next(names.begin(), kNamed) : names.end();
  std::string text = absl::StrJoin(names.begin(), end, ", ");
  if (end != names.end()) {
    absl::StrAppend(&text, " and ", names.size() - kNamed, " more");
  }
  return text;
}

// Of others' endpoints of the other direction, one text each, without repeats.
std::set<std::string> Those(
    const Endpoint& ours, const std::vector<Endpoint>& others,
    const std::function<bool(const Endpoint&)>& fits,
    const std::function<std::string(const Endpoint&)>& text) {
  std::set<std::string> found;
  for (const Endpoint& other : others) {
    if (other.is_writer != ours.is_writer && fits(other)) {
      found.insert(text(other));
    }
  }
  return found;
}

// Why two of one topic and type do not meet; "": they do.
std::string MismatchOf(const Endpoint& ours, const Endpoint& other) {
  const Quality& asked = ours.is_writer ? other.quality : ours.quality;
  const Quality& offered = ours.is_writer ? ours.quality : other.quality;
  const auto told = [&ours](const char* asked_for, const char* there_is) {
    return ours.is_writer
               ? absl::StrCat("who listens asks for ", asked_for,
                              ", and it is published as ", there_is, " here")
               : absl::StrCat("it is published as ", there_is, ", and ",
                              asked_for, " is asked for here");
  };
  if (asked.is_reliable && !offered.is_reliable) {
    return told("reliable", "best effort");
  }
  if (asked.is_latched && !offered.is_latched) {
    return told("transient local", "volatile");
  }
  return "";
}

}  // namespace

std::optional<Endpoint> EndpointOf(const std::string& dds_topic,
                                   const std::string& dds_type) {
  absl::string_view topic = dds_topic;
  absl::string_view type = dds_type;
  const size_t inner = type.find("::dds_::");
  if (!absl::ConsumePrefix(&topic, "rt/") || !absl::ConsumeSuffix(&type, "_") ||
      inner == absl::string_view::npos) {
    return std::nullopt;
  }
  return Endpoint{.topic = absl::StrCat("/", topic),
                  .message_name = absl::StrReplaceAll(
                      type, {{"::dds_::", "/"}, {"::", "/"}})};
}

std::string WhyNobody(const Endpoint& ours, const std::vector<Endpoint>& others,
                      int domain_id) {
  const char* does = ours.is_writer ? " listens on " : " publishes ";
  const auto has_topic = [&ours](const Endpoint& other) {
    return other.topic == ours.topic;
  };
  const auto has_type = [&ours](const Endpoint& other) {
    return other.message_name == ours.message_name;
  };
  std::string mismatch;
  for (const Endpoint& other : others) {
    if (other.is_writer == ours.is_writer || !has_topic(other) ||
        !has_type(other)) {
      continue;
    }
    mismatch = MismatchOf(ours, other);
    if (mismatch.empty()) return "";
  }
  if (!mismatch.empty()) {
    return absl::StrCat(ours.topic,
                        ": the quality of service does not fit: ", mismatch);
  }
  const auto types = Those(ours, others, has_topic, [](const Endpoint& other) {
    return other.message_name;
  });
  if (!types.empty()) {
    return absl::StrCat(ours.topic, " is of type ", Listed(types),
                        " there, and not ", ours.message_name);
  }
  const std::string nobody =
      absl::StrCat("nobody", does, ours.topic, " in domain ", domain_id);
  const auto names = Those(ours, others, has_type,
                           [](const Endpoint& other) { return other.topic; });
  if (!names.empty()) {
    return absl::StrCat(nobody, "; of type ", ours.message_name, " there is ",
                        Listed(names));
  }
  const auto all = Those(
      ours, others, [](const Endpoint&) { return true; },
      [](const Endpoint& other) { return other.topic; });
  if (!all.empty()) {
    return absl::StrCat(nobody, ", nor any ", ours.message_name, "; there is ",
                        Listed(all));
  }
  return absl::StrCat(nobody,
                      ", nor anything else: is the robot on, in this domain "
                      "(ROS_DOMAIN_ID) and network?");
}

}  // namespace treeline::dds
