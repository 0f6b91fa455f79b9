// What services of every implementation of ROS 2 have in common: replies to
// clients that cannot hear them yet are kept, since a request may come before
// its client's reader is found.
#ifndef NAV_AGENT_BRIDGE_DDS_KEEPING_SERVICE_H_
#define NAV_AGENT_BRIDGE_DDS_KEEPING_SERVICE_H_

#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "nav_agent/bridge/dds/service.h"

namespace treeline::dds {

// Of more than 64 kept replies the oldest are dropped, and each after ten
// seconds.
class KeepingService : public Service {
 public:
  std::vector<Request> Take() final;
  absl::Status Reply(const RequestId& id, std::span<const uint8_t> bytes) final;
  int64_t not_understood() const final { return not_understood_; }
  const std::string& name() const final { return name_; }

 protected:
  enum class Hearing {
    kHears,
    kNotYet,
    // The client has ended.
    kGone
  };

  explicit KeepingService(std::string name) : name_(std::move(name)) {}

  // As Take. Those that are not understood are counted by it.
  virtual std::vector<Request> TakeRequests() = 0;
  virtual Hearing HearingOf(const RequestId& id) const = 0;
  // Sends one, which has kEncodingBytes at least.
  virtual absl::Status Write(const RequestId& id,
                             std::span<const uint8_t> bytes) = 0;
  void CountNotUnderstood() { ++not_understood_; }

  // In front of a message's bytes.
  static constexpr size_t kEncodingBytes = 4;

 private:
  struct Kept {
    RequestId id;
    std::vector<uint8_t> bytes;
    absl::Time until;
  };

  const std::string name_;
  std::deque<Kept> kept_;
  int64_t not_understood_ = 0;
};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_KEEPING_SERVICE_H_
