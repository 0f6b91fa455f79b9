#include "common/flood_guard/watched_connection.h"

#include <algorithm>

namespace treeline::flood_guard {
namespace {

// A TLS record of a handshake, with version and length; ClientHello, with
// length and version; then 32 random bytes.
constexpr char kHandshake = 22;
constexpr char kClientHello = 1;
constexpr size_t kRecordHead = 5;
constexpr size_t kRandomAt = 11;
constexpr size_t kRandomBytes = 32;
constexpr size_t kHelloBytes = kRandomAt + kRandomBytes;

// Of a record, without its head.
size_t RecordLength(absl::string_view record) {
  return static_cast<size_t>(static_cast<unsigned char>(record[3])) << 8 |
         static_cast<unsigned char>(record[4]);
}

}  // namespace

std::shared_ptr<WatchedConnection> WatchedConnection::Open(
    std::shared_ptr<FloodGuard> guard, std::string address, std::string peer) {
  if (!guard->Open(address, peer)) return nullptr;
  return std::shared_ptr<WatchedConnection>(new WatchedConnection(
      std::move(guard), std::move(address), std::move(peer)));
}

WatchedConnection::~WatchedConnection() { guard_->Close(address_); }

WatchedConnection::Verdict WatchedConnection::Receive(absl::string_view bytes) {
  if (is_cut()) return Verdict::kCut;
  if (bytes.empty()) return Verdict::kGoOn;
  const absl::MutexLock lock(&mutex_);
  if (kind_ == Kind::kUnknown) {
    kind_ = bytes[0] == kHandshake ? Kind::kTls : Kind::kHttp2;
  }
  if (kind_ == Kind::kTls) return TakeHello(bytes);
  return CountFrames(bytes) ? Verdict::kGoOn : Verdict::kCut;
}

bool WatchedConnection::Decrypted(absl::string_view bytes) {
  if (is_cut()) return false;
  const absl::MutexLock lock(&mutex_);
  return CountFrames(bytes);
}

void WatchedConnection::Cut(CutReason reason) {
  is_cut_ = true;
  guard_->Cut(address_, peer_, reason);
}

std::string WatchedConnection::client_random() const {
  const absl::MutexLock lock(&mutex_);
  return hello_.size() == kHelloBytes ? hello_.substr(kRandomAt) : "";
}

WatchedConnection::Verdict WatchedConnection::TakeHello(
    absl::string_view bytes) {
  if (hello_.size() == kHelloBytes) return Verdict::kGoOn;
  const absl::string_view taken = bytes.substr(0, kHelloBytes - hello_.size());
  hello_.append(taken.data(), taken.size());
  if (hello_.size() < kHelloBytes) return Verdict::kGoOn;
  if (hello_[kRecordHead] == kClientHello &&
      RecordLength(hello_) >= kHelloBytes - kRecordHead) {
    return Verdict::kTlsBegins;
  }
  Cut(CutReason::kHandshake);
  return Verdict::kCut;
}

bool WatchedConnection::CountFrames(absl::string_view bytes) {
  FrameCounts counts;
  if (!frames_.Count(bytes, counts)) {
    Cut(CutReason::kHeaderBlock);
    return false;
  }
  if (guard_->Draw(address_, peer_, counts)) return true;
  is_cut_ = true;
  return false;
}

}  // namespace treeline::flood_guard
