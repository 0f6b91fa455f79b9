#include "nav_agent/bridge/foxglove/foxglove_protocol.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::foxglove {
namespace {

using nlohmann::json;

// In front of a binary message that holds one of a channel.
constexpr char kMessageData = 1;

// What came from outside need not be UTF-8.
std::string TextOf(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

template <typename Number>
void AppendLittleEndian(Number number, std::string& bytes) {
  for (size_t i = 0; i < sizeof(Number); ++i) {
    bytes.push_back(static_cast<char>(number >> (8 * i)));
  }
}

std::optional<uint32_t> IdOf(const json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto id = value.get<uint64_t>();
  if (id > std::numeric_limits<uint32_t>::max()) return std::nullopt;
  return static_cast<uint32_t>(id);
}

absl::Status NotAsSpecified(absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(what, " is missing, or not as Foxglove's protocol says"));
}

// A member that is an array; nullptr: there is none.
const json* ArrayOf(const json& object, const char* name) {
  const auto member = object.find(name);
  return member != object.end() && member->is_array() ? &*member : nullptr;
}

absl::StatusOr<ClientRequest> SubscribeOf(const json& message) {
  const json* const list = ArrayOf(message, "subscriptions");
  if (list == nullptr) return NotAsSpecified("subscriptions");
  ClientRequest request;
  for (const json& one : *list) {
    if (!one.is_object()) return NotAsSpecified("subscriptions");
    const std::optional<uint32_t> id = IdOf(one.value("id", json()));
    const std::optional<uint32_t> channel =
        IdOf(one.value("channelId", json()));
    if (!id.has_value()) return NotAsSpecified("subscriptions.id");
    if (!channel.has_value()) return NotAsSpecified("subscriptions.channelId");
    request.subscribe.push_back({.id = *id, .channel = *channel});
  }
  return request;
}

absl::StatusOr<ClientRequest> UnsubscribeOf(const json& message) {
  const json* const list = ArrayOf(message, "subscriptionIds");
  if (list == nullptr) return NotAsSpecified("subscriptionIds");
  ClientRequest request;
  for (const json& one : *list) {
    const std::optional<uint32_t> id = IdOf(one);
    if (!id.has_value()) return NotAsSpecified("subscriptionIds");
    request.unsubscribe.push_back(*id);
  }
  return request;
}

}  // namespace

std::string ServerInfoText(absl::string_view name, absl::string_view session) {
  return TextOf({{"op", "serverInfo"},
                 {"name", std::string(name)},
                 {"capabilities", json::array()},
                 {"supportedEncodings", json::array()},
                 {"metadata", json::object()},
                 {"sessionId", std::string(session)}});
}

std::string AdvertiseText(std::span<const Channel> channels) {
  json list = json::array();
  for (const Channel& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic},
                    {"encoding", "cdr"},
                    {"schemaName", channel.schema_name},
                    {"schema", channel.schema},
                    {"schemaEncoding", "ros2msg"}});
  }
  return TextOf({{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string StatusText(StatusLevel level, absl::string_view message) {
  return TextOf({{"op", "status"},
                 {"level", static_cast<int>(level)},
                 {"message", std::string(message)}});
}

std::string MessageData(uint32_t subscription, uint64_t time_ns,
                        std::span<const uint8_t> message) {
  std::string bytes(1, kMessageData);
  bytes.reserve(1 + sizeof(subscription) + sizeof(time_ns) + message.size());
  AppendLittleEndian(subscription, bytes);
  AppendLittleEndian(time_ns, bytes);
  bytes.append(message.begin(), message.end());
  return bytes;
}

absl::StatusOr<ClientRequest> ParseClientText(absl::string_view text) {
  const json message = json::parse(text.begin(), text.end(), nullptr,
                                   /*allow_exceptions=*/false);
  if (!message.is_object()) {
    return absl::InvalidArgumentError("a message is no JSON object");
  }
  const auto op = message.find("op");
  if (op == message.end() || !op->is_string()) return NotAsSpecified("op");
  const std::string name = op->get<std::string>();
  if (name == "subscribe") return SubscribeOf(message);
  if (name == "unsubscribe") return UnsubscribeOf(message);
  return absl::UnimplementedError(
      absl::StrCat("this server only shows the robot; it has no operation ",
                   TextOf(json(name))));
}

}  // namespace treeline::foxglove
