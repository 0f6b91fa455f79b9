// HTTP/2 frames for tests.
#ifndef COMMON_FLOOD_GUARD_TESTING_FRAMES_H_
#define COMMON_FLOOD_GUARD_TESTING_FRAMES_H_

#include <string>

namespace treeline::flood_guard {

inline constexpr int kTestData = 0;
inline constexpr int kTestHeaders = 1;
inline constexpr int kTestReset = 3;
inline constexpr int kTestSettings = 4;
inline constexpr int kTestPing = 6;
inline constexpr int kTestContinuation = 9;
inline constexpr int kTestAck = 1;
inline constexpr int kTestEndHeaders = 4;

inline const std::string& kTestPreface =
    *new std::string("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n");

// RFC 9113, section 4.1.
inline std::string TestFrame(int type, int flags, int stream,
                             const std::string& payload) {
  std::string frame;
  const auto put = [&frame](unsigned value, int bytes) {
    for (int i = bytes - 1; i >= 0; --i) {
      frame.push_back(static_cast<char>(value >> (8 * i) & 0xff));
    }
  };
  put(static_cast<unsigned>(payload.size()), 3);
  put(static_cast<unsigned>(type), 1);
  put(static_cast<unsigned>(flags), 1);
  put(static_cast<unsigned>(stream), 4);
  return frame + payload;
}

}  // namespace treeline::flood_guard

#endif  // COMMON_FLOOD_GUARD_TESTING_FRAMES_H_
