#include "simulation/emulators/emulator_server.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"

namespace treeline::emulators {
namespace {

using std::chrono::milliseconds;

// How long the thread waits for anything, at most.
constexpr milliseconds kLongestWait(10);
// A reader that is a little slow gets its bytes; one that is not there must
// not hold the device up.
constexpr milliseconds kWriteTimeout(50);

}  // namespace

absl::StatusOr<DeviceAddress> ParseDeviceAddress(absl::string_view text) {
  absl::string_view rest = text;
  if (rest == "pty") return PtyAddress{};
  if (absl::ConsumePrefix(&rest, "pty:") && !rest.empty()) {
    return PtyAddress{.symlink = std::string(rest)};
  }
  if (absl::ConsumePrefix(&rest, "tcp:")) {
    base::ListenAddress address{.host = "127.0.0.1"};
    const size_t colon = rest.rfind(':');
    if (colon != absl::string_view::npos) {
      address.host = std::string(rest.substr(0, colon));
      rest.remove_prefix(colon + 1);
    }
    if (!address.host.empty() && absl::SimpleAtoi(rest, &address.port) &&
        address.port >= 0 && address.port <= 65535) {
      return address;
    }
  }
  return absl::InvalidArgumentError(
      absl::StrCat("\"", text,
                   "\" is nowhere to listen: pty, pty:SYMLINK, tcp:PORT or "
                   "tcp:ADDRESS:PORT"));
}

absl::StatusOr<std::unique_ptr<EmulatorServer>> EmulatorServer::Start(
    EmulatorServerOptions options, EmulatedDevice& device,
    const base::Clock& clock) {
  std::unique_ptr<EmulatorServer> server(
      new EmulatorServer(std::move(options), device, clock));
  TL_RETURN_IF_ERROR(server->Plug());
  server->thread_ = std::jthread(
      [raw = server.get()](const std::stop_token& stop) { raw->Run(stop); });
  return server;
}

EmulatorServer::EmulatorServer(EmulatorServerOptions options,
                               EmulatedDevice& device, const base::Clock& clock)
    : listen_(std::move(options.listen)),
      device_(device),
      clock_(clock),
      byte_faults_(options.seed),
      faults_(std::move(options.faults)),
      faults_since_(clock.Now()) {}

EmulatorServer::~EmulatorServer() = default;

std::string EmulatorServer::address() const {
  const absl::MutexLock lock(&mutex_);
  return address_;
}

absl::Status EmulatorServer::trouble() const {
  const absl::MutexLock lock(&mutex_);
  return trouble_;
}

void EmulatorServer::SetFaults(DeviceFaultPlan faults) {
  const absl::MutexLock lock(&mutex_);
  faults_ = std::move(faults);
  faults_since_ = clock_.Now();
}

ActiveFaults EmulatorServer::Faults(base::MonotonicTime now) const {
  const absl::MutexLock lock(&mutex_);
  return faults_.At(base::MillisecondsBetween(faults_since_, now) * 1e-3);
}

absl::Status EmulatorServer::Plug() {
  std::string address;
  if (const auto* pty = std::get_if<PtyAddress>(&listen_)) {
    TL_ASSIGN_OR_RETURN(pty_, stream::Pty::Open(pty->symlink));
    address = pty_->path();
    device_.Connect(clock_.Now());
  } else {
    auto& tcp = std::get<base::ListenAddress>(listen_);
    TL_ASSIGN_OR_RETURN(listener_,
                        stream::TcpListener::Listen(tcp.port, tcp.host));
    // The same again after it was replugged.
    tcp.port = listener_->port();
    const bool everywhere = tcp.host == "0.0.0.0" || tcp.host == "::";
    address = absl::StrCat("tcp:", everywhere ? "127.0.0.1" : tcp.host, ":",
                           tcp.port);
  }
  const absl::MutexLock lock(&mutex_);
  address_ = address;
  return absl::OkStatus();
}

void EmulatorServer::Unplug() {
  caller_.reset();
  listener_.reset();
  pty_.reset();
  unsent_.clear();
  byte_faults_.Forget();
}

void EmulatorServer::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const base::MonotonicTime now = clock_.Now();
    const ActiveFaults faults = Faults(now);
    device_.SetFaults(faults, now);
    if (faults.unplugged && plugged()) Unplug();
    if (!faults.unplugged && !plugged()) {
      absl::Status plugged_in = Plug();
      const absl::MutexLock lock(&mutex_);
      trouble_ = std::move(plugged_in);
    }
    if (plugged()) {
      Step(faults, stop);
    } else {
      device_.TakeOutput(now);
      stream::StopRequestedWithin(milliseconds(2), stop);
    }
  }
}

stream::ByteStream* EmulatorServer::Peer(const std::stop_token& stop) {
  if (pty_ != nullptr) return pty_.get();
  if (caller_ == nullptr) {
    auto caller = listener_->Accept(kLongestWait, stop);
    if (!caller.ok() || *caller == nullptr) return nullptr;
    caller_ = *std::move(caller);
    device_.Connect(clock_.Now());
  }
  return caller_.get();
}

void EmulatorServer::Step(const ActiveFaults& faults,
                          const std::stop_token& stop) {
  stream::ByteStream* const peer = Peer(stop);
  if (peer == nullptr) {
    device_.TakeOutput(clock_.Now());
    return;
  }
  const auto until_event =
      std::chrono::ceil<milliseconds>(device_.NextEvent() - clock_.Now());
  std::array<uint8_t, 4096> buffer = {};
  const auto count = peer->Read(
      buffer, std::clamp(until_event, milliseconds(0), kLongestWait), stop);
  if (!count.ok()) {
    caller_.reset();
    unsent_.clear();
    byte_faults_.Forget();
    return;
  }
  const base::MonotonicTime now = clock_.Now();
  if (*count > 0) {
    received_ += static_cast<int64_t>(*count);
    device_.Receive(std::span(buffer).first(*count), now);
  }
  Send(*peer, faults, now);
}

void EmulatorServer::Send(stream::ByteStream& peer, const ActiveFaults& faults,
                          base::MonotonicTime now) {
  const std::string output = device_.TakeOutput(now);
  if (faults.stuck) {
    unsent_.clear();
    return byte_faults_.Forget();
  }
  // As a device's buffer: what it says while a reader is late is lost as a
  // whole, but nothing is torn.
  if (!Finish(peer)) return;
  bool is_taken = true;
  for (const std::string& piece : byte_faults_.Apply(output, faults, now)) {
    unsent_ += piece;
    is_taken = is_taken && Finish(peer);
  }
}

bool EmulatorServer::Finish(stream::ByteStream& peer) {
  if (unsent_.empty()) return true;
  const auto sent = peer.WriteSome(stream::AsBytes(unsent_), kWriteTimeout);
  if (!sent.ok()) {
    // Over TCP the next read says whether anyone is still there.
    unsent_.clear();
    return false;
  }
  sent_ += static_cast<int64_t>(*sent);
  unsent_.erase(0, *sent);
  return unsent_.empty();
}

}  // namespace treeline::emulators
