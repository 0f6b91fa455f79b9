#include "nav_agent/bridge/foxglove/foxglove_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace treeline::foxglove {
namespace {

using http::WebSocketClose;
using http::WebSocketReader;

// Between looks for a newer state: those come ten times a second.
constexpr auto kLook = std::chrono::milliseconds(50);
// A viewer's messages are lists of ids.
constexpr size_t kMaxMessageBytes = size_t{64} << 10;
constexpr size_t kMaxSubscriptions = 256;
constexpr size_t kPiece = 4096;

}  // namespace

FoxgloveSession::FoxgloveSession(const agent_service::AgentHub& hub,
                                 LiveTopics topics, const base::Clock& clock,
                                 http::HttpDuplex& connection)
    : hub_(hub),
      topics_(std::move(topics)),
      clock_(clock),
      connection_(connection),
      reader_(kMaxMessageBytes, [](size_t) { return true; }) {}

void FoxgloveSession::Run(absl::string_view server_name,
                          absl::string_view session_id) {
  if (!Text(ServerInfoText(server_name, session_id)) ||
      !Text(AdvertiseText(LiveChannels()))) {
    return;
  }
  while (!end_.has_value()) {
    if (!Show() || !WaitAndRead()) return;
    if (hub_.is_closed()) end_ = WebSocketClose::kGoingAway;
  }
  connection_.Write(http::WebSocketCloseFrame(*end_, ""));
}

bool FoxgloveSession::Text(absl::string_view text) {
  return connection_.Write(http::WebSocketMessage(/*is_text=*/true, text));
}

bool FoxgloveSession::Show() {
  const std::shared_ptr<const agent_service::AgentState> state = hub_.Latest();
  if (state == nullptr) return true;
  const int64_t now_ns = absl::ToUnixNanos(absl::Now());
  for (const Channel& channel : LiveChannels()) {
    const auto topic = static_cast<LiveTopic>(channel.id);
    const auto wants = [topic](const auto& subscription) {
      return subscription.second == topic;
    };
    if (std::none_of(subscriptions_.begin(), subscriptions_.end(), wants)) {
      continue;
    }
    for (const std::vector<uint8_t>& message :
         topics_.Next(topic, *state, now_ns)) {
      for (const auto& subscription : subscriptions_) {
        if (!wants(subscription)) continue;
        if (!connection_.Write(http::WebSocketMessage(
                /*is_text=*/false,
                MessageData(subscription.first, static_cast<uint64_t>(now_ns),
                            message)))) {
          return false;
        }
      }
    }
  }
  return true;
}

bool FoxgloveSession::WaitAndRead() {
  const http::HttpDuplex::Readiness ready =
      connection_.Wait(/*reads=*/true, /*other=*/-1, clock_.Now() + kLook);
  if (!ready.can_read) return !ready.has_gone;
  std::array<char, kPiece> bytes;
  const ssize_t got = connection_.ReadSome(bytes.data(), bytes.size());
  if (got < 0) return false;
  return Parse(absl::string_view(bytes.data(), static_cast<size_t>(got)));
}

bool FoxgloveSession::Parse(absl::string_view bytes) {
  while (!bytes.empty() && !end_.has_value()) {
    switch (reader_.Read(bytes)) {
      case WebSocketReader::Event::kNone:
        break;
      case WebSocketReader::Event::kMessage:
        if (!OnMessage()) return false;
        break;
      case WebSocketReader::Event::kPing:
        if (!connection_.Write(http::WebSocketPong(reader_.ping()))) {
          return false;
        }
        break;
      case WebSocketReader::Event::kClose:
        end_ = WebSocketClose::kNormal;
        break;
      case WebSocketReader::Event::kFailed:
        end_ = reader_.failure();
        break;
    }
  }
  SetArriving(!end_.has_value() && reader_.is_amid());
  return true;
}

void FoxgloveSession::SetArriving(bool is_arriving) {
  if (is_arriving == is_arriving_) return;
  is_arriving_ = is_arriving;
  if (is_arriving) {
    connection_.BeginArrival();
  } else {
    connection_.EndArrival();
  }
}

bool FoxgloveSession::OnMessage() {
  const bool is_text = reader_.is_text();
  const std::string message = reader_.TakeMessage();
  // Binary ones publish, which nobody was offered.
  const absl::StatusOr<ClientRequest> request =
      is_text ? ParseClientText(message)
              : absl::UnimplementedError(
                    "this server only shows the robot; it takes no messages");
  const absl::Status taken = request.ok() ? Take(*request) : request.status();
  return taken.ok() ||
         Text(StatusText(absl::IsUnimplemented(taken) ? StatusLevel::kWarning
                                                      : StatusLevel::kError,
                         taken.message()));
}

absl::Status FoxgloveSession::Take(const ClientRequest& request) {
  for (const uint32_t id : request.unsubscribe) subscriptions_.erase(id);
  for (const ClientRequest::Subscription& one : request.subscribe) {
    if (one.channel >= kLiveTopics) {
      return absl::InvalidArgumentError(
          absl::StrCat("there is no channel ", one.channel));
    }
    if (subscriptions_.size() >= kMaxSubscriptions) {
      return absl::InvalidArgumentError(
          absl::StrCat("more than ", kMaxSubscriptions, " subscriptions"));
    }
    const auto topic = static_cast<LiveTopic>(one.channel);
    subscriptions_[one.id] = topic;
    topics_.Begin(topic);
  }
  return absl::OkStatus();
}

}  // namespace treeline::foxglove
