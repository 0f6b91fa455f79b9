// One of a bounded number of streams.
#ifndef NAV_AGENT_SERVICE_STREAM_SLOT_H_
#define NAV_AGENT_SERVICE_STREAM_SLOT_H_

#include <atomic>

namespace treeline::agent_service {

// Taken while it lives, if there was one.
class StreamSlot {
 public:
  StreamSlot(std::atomic<int>& streams, int max_streams)
      : streams_(streams), is_taken_(++streams <= max_streams) {}
  ~StreamSlot() { --streams_; }
  StreamSlot(const StreamSlot&) = delete;
  StreamSlot& operator=(const StreamSlot&) = delete;

  bool is_taken() const { return is_taken_; }

 private:
  std::atomic<int>& streams_;
  const bool is_taken_;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_STREAM_SLOT_H_
