#include "common/flood_guard/flood_guard.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/strip.h"
#include "common/base/check_range.h"
#include "common/base/socket_address.h"
#include "common/base/status_macros.h"

namespace treeline::flood_guard {
namespace {

constexpr double kBurst_s = 1;
// Of that, what new connections leave.
constexpr double kCallsAlone = 0.25;
constexpr std::chrono::seconds kRefused{1};
constexpr double kReportInterval_s = 1;

}  // namespace

absl::Status FloodLimits::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("calls a second of an address", calls_per_s, 1, 1e9));
  TL_RETURN_IF_ERROR(base::CheckRange(
      "open calls of an address", static_cast<double>(open_calls), 10, 1e9));
  return base::CheckRange("connections of an address", connections, 1, 1e6);
}

absl::string_view NameOf(CutReason reason) {
  switch (reason) {
    case CutReason::kCalls:
      return "calls";
    case CutReason::kFrames:
      return "frames";
    case CutReason::kOpenCalls:
      return "open_calls";
    case CutReason::kHeaderBlock:
      return "header_block";
    case CutReason::kHandshake:
      return "handshake";
    case CutReason::kConnections:
      return "connections";
    case CutReason::kCameBack:
      return "came_back";
  }
  return "";
}

std::string AddressKeyOfPeer(absl::string_view peer) {
  const size_t colon = peer.rfind(':');
  if (colon == absl::string_view::npos) return "";
  absl::string_view rest = peer.substr(0, colon);
  sockaddr_storage address = {};
  if (absl::ConsumePrefix(&rest, "ipv4:")) {
    auto& v4 = reinterpret_cast<sockaddr_in&>(address);
    v4.sin_family = AF_INET;
    if (inet_pton(AF_INET, std::string(rest).c_str(), &v4.sin_addr) != 1) {
      return "";
    }
    return base::AddressKey(address);
  }
  if (!absl::ConsumePrefix(&rest, "ipv6:")) return "";
  std::string text = absl::StrReplaceAll(
      rest, {{"%5B", ""}, {"%5D", ""}, {"[", ""}, {"]", ""}});
  // Of "fe80::1%eth0", the zone.
  text.resize(std::min(text.size(), text.find('%')));
  auto& v6 = reinterpret_cast<sockaddr_in6&>(address);
  v6.sin6_family = AF_INET6;
  if (inet_pton(AF_INET6, text.c_str(), &v6.sin6_addr) != 1) return "";
  return base::AddressKey(address);
}

FloodGuard::FloodGuard(const FloodLimits& limits, const base::Clock& clock,
                       Report report)
    : limits_(limits),
      burst_(std::min(kBurst_s * limits.calls_per_s,
                      static_cast<double>(limits.open_calls))),
      clock_(clock),
      report_(std::move(report)) {}

FloodGuard::Address& FloodGuard::Find(const std::string& key) {
  const base::MonotonicTime now = clock_.Now();
  if (addresses_.size() >= forget_at_) Forget();
  const auto [found, is_new] = addresses_.try_emplace(key);
  Address& address = found->second;
  const double returned =
      is_new ? burst_
             : limits_.calls_per_s * base::SecondsBetween(address.seen, now);
  address.calls = std::min(burst_, address.calls + returned);
  address.frames = std::min(kFramesOfACall * burst_,
                            address.frames + kFramesOfACall * returned);
  address.seen = now;
  return address;
}

void FloodGuard::Forget() {
  const base::MonotonicTime now = clock_.Now();
  absl::erase_if(addresses_, [now](const auto& each) {
    return each.second.connections == 0 && each.second.open_calls == 0 &&
           base::SecondsBetween(each.second.seen, now) >= kBurst_s;
  });
  forget_at_ = std::max<size_t>(1024, 2 * addresses_.size());
}

bool FloodGuard::Open(const std::string& key, absl::string_view peer) {
  std::optional<CutReason> reason;
  {
    const absl::MutexLock lock(&mutex_);
    Address& address = Find(key);
    if (address.seen < address.refused_until) {
      reason = CutReason::kCameBack;
    } else if (address.connections >= limits_.connections) {
      reason = CutReason::kConnections;
    } else if (address.calls < kCallsAlone * burst_ + kCallsOfAConnection) {
      reason = CutReason::kCalls;
    } else {
      address.calls -= kCallsOfAConnection;
      ++address.connections;
    }
  }
  if (reason.has_value()) Note(peer, *reason);
  return !reason.has_value();
}

void FloodGuard::Close(const std::string& key) {
  const absl::MutexLock lock(&mutex_);
  const auto found = addresses_.find(key);
  if (found != addresses_.end()) --found->second.connections;
}

int64_t FloodGuard::OpenCallsOfOne(int64_t more) {
  const base::MonotonicTime now = clock_.Now();
  begun_ *= std::max(0.0, 1 - base::SecondsBetween(begun_at_, now));
  begun_at_ = now;
  const int64_t of_all = kAddressesOfAllCalls * limits_.open_calls;
  if (open_calls_ + static_cast<int64_t>(begun_) + more <= of_all) {
    return limits_.open_calls;
  }
  const auto share = of_all / static_cast<int64_t>(addresses_.size());
  return std::clamp(share, std::min(kFewCalls, limits_.open_calls),
                    limits_.open_calls);
}

bool FloodGuard::Draw(const std::string& key, absl::string_view peer,
                      const FrameCounts& counts) {
  if (counts == FrameCounts()) return true;
  std::optional<CutReason> reason;
  {
    const absl::MutexLock lock(&mutex_);
    Address& address = Find(key);
    address.calls = std::min(
        burst_, address.calls + static_cast<double>(counts.payload_bytes) /
                                    kPayloadOfACall);
    const auto calls = static_cast<double>(counts.calls);
    const auto frames = static_cast<double>(counts.frames);
    if (calls > address.calls) {
      reason = CutReason::kCalls;
    } else if (frames > address.frames) {
      reason = CutReason::kFrames;
    } else if (counts.calls > 0 && address.open_calls + counts.calls >
                                       OpenCallsOfOne(counts.calls)) {
      reason = CutReason::kOpenCalls;
    } else {
      address.calls -= calls;
      address.frames -= frames;
      begun_ += calls;
    }
  }
  if (reason.has_value()) Cut(key, peer, *reason);
  return !reason.has_value();
}

void FloodGuard::Cut(const std::string& key, absl::string_view peer,
                     CutReason reason) {
  {
    const absl::MutexLock lock(&mutex_);
    Address& address = Find(key);
    address.refused_until = address.seen + kRefused;
  }
  Note(peer, reason);
}

void FloodGuard::BeginCall(const std::string& key) {
  const absl::MutexLock lock(&mutex_);
  ++Find(key).open_calls;
  ++open_calls_;
}

void FloodGuard::EndCall(const std::string& key) {
  const absl::MutexLock lock(&mutex_);
  const auto found = addresses_.find(key);
  if (found == addresses_.end()) return;
  --found->second.open_calls;
  --open_calls_;
}

std::string FloodGuard::Explain(CutReason reason) const {
  switch (reason) {
    case CutReason::kCalls:
      return absl::StrCat("its address begins more than ", limits_.calls_per_s,
                          " calls a second, connections included");
    case CutReason::kFrames:
      return absl::StrCat("its address sends more than ",
                          kFramesOfACall * limits_.calls_per_s,
                          " frames a second that carry nothing");
    case CutReason::kOpenCalls:
      return absl::StrCat("its address has more than ", limits_.open_calls,
                          " calls open, or more than its share of too many");
    case CutReason::kHeaderBlock:
      return "headers without end";
    case CutReason::kHandshake:
      return "no client begins TLS like this";
    case CutReason::kConnections:
      return absl::StrCat("its address has ", limits_.connections,
                          " connections");
    case CutReason::kCameBack:
      return "its address was cut off a moment ago";
  }
  return "";
}

void FloodGuard::Note(absl::string_view peer, CutReason reason) {
  {
    const absl::MutexLock lock(&mutex_);
    ++cuts_[static_cast<size_t>(reason)];
  }
  const absl::MutexLock lock(&report_mutex_);
  if (report_ == nullptr) return;
  const base::MonotonicTime now = clock_.Now();
  if (reported_.has_value() &&
      base::SecondsBetween(*reported_, now) < kReportInterval_s) {
    ++not_reported_;
    return;
  }
  reported_ = now;
  std::string message = absl::StrCat("cut off ", peer, ": ", Explain(reason));
  if (not_reported_ > 0) {
    absl::StrAppend(&message, " (and ", not_reported_,
                    " connections since the last such line)");
  }
  not_reported_ = 0;
  report_(message);
}

uint64_t FloodGuard::cuts(CutReason reason) const {
  const absl::MutexLock lock(&mutex_);
  return cuts_[static_cast<size_t>(reason)];
}

size_t FloodGuard::addresses() const {
  const absl::MutexLock lock(&mutex_);
  return addresses_.size();
}

void FloodGuard::StopReporting() {
  const absl::MutexLock lock(&report_mutex_);
  report_ = nullptr;
}

}  // namespace treeline::flood_guard
