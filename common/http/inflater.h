// gzip, a piece at a time, within bounds.
#ifndef COMMON_HTTP_INFLATER_H_
#define COMMON_HTTP_INFLATER_H_

#include <cstddef>
#include <functional>
#include <memory>

#include "absl/strings/string_view.h"

namespace treeline::http {

// How much more may come out than has gone in: `floor_bytes`, and `ratio` for
// each byte. gzip reaches 1032. Images that are sent as they are reach 10;
// black ones, as small as cameras have, fit below the floor.
struct InflationLimit {
  size_t floor_bytes = 2 << 20;
  size_t ratio = 64;
};

// One gzip member (RFC 1952). For one thread.
class Inflater {
 public:
  enum class Verdict {
    kOk,
    // Not gzip, or bytes behind its end.
    kBroken,
    // Beyond the limit.
    kTooLarge,
    // The sink wants no more.
    kStopped
  };

  explicit Inflater(const InflationLimit& limit = {});
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  // Hands to `sink` what comes out of the next `bytes`, up to 64 KiB at a time.
  Verdict Add(absl::string_view bytes,
              const std::function<bool(absl::string_view)>& sink);
  // Whether the member has ended.
  bool is_complete() const;

 private:
  struct State;
  const InflationLimit limit_;
  const std::unique_ptr<State> state_;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_INFLATER_H_
