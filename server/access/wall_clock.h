// The time of day, which tokens and certificates expire by. Injected.
#ifndef SERVER_ACCESS_WALL_CLOCK_H_
#define SERVER_ACCESS_WALL_CLOCK_H_

#include <chrono>
#include <cstdint>

namespace treeline::access {

class WallClock {
 public:
  virtual ~WallClock() = default;
  // Seconds since 1970-01-01 00:00 UTC, without leap seconds.
  virtual int64_t UnixSeconds() const = 0;
};

class SystemWallClock final : public WallClock {
 public:
  int64_t UnixSeconds() const override {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
  }
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_WALL_CLOCK_H_
