#include "simulation/ros2_robot/robot_orders.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::ros2_robot {
namespace {

constexpr const char* kOrders =
    "orders are: tour | kidnap X Y YAW | goal X Y YAW | place X Y YAW | "
    "silence scan|odom|clock SECONDS | jump SECONDS | nonsense";

constexpr std::array<std::pair<const char*, RobotOrder::Kind>, 7> kKinds = {
    {{"tour", RobotOrder::Kind::kTour},
     {"kidnap", RobotOrder::Kind::kKidnap},
     {"goal", RobotOrder::Kind::kGoal},
     {"place", RobotOrder::Kind::kPlace},
     {"silence", RobotOrder::Kind::kSilence},
     {"jump", RobotOrder::Kind::kJump},
     {"nonsense", RobotOrder::Kind::kNonsense}}};

bool IsTopic(const std::string& topic) {
  return topic == "scan" || topic == "odom" || topic == "clock";
}

}  // namespace

absl::StatusOr<RobotOrder> ParseOrder(const std::string& line) {
  std::istringstream words(line);
  std::string name;
  words >> name;
  const auto* kind = std::ranges::find_if(
      kKinds, [&name](const auto& known) { return name == known.first; });
  bool is_good = kind != kKinds.end();
  RobotOrder order;
  if (is_good) {
    order.kind = kind->second;
    switch (order.kind) {
      case RobotOrder::Kind::kKidnap:
      case RobotOrder::Kind::kGoal:
      case RobotOrder::Kind::kPlace:
        words >> order.x_m >> order.y_m >> order.yaw_rad;
        break;
      case RobotOrder::Kind::kSilence:
        words >> order.topic >> order.seconds;
        is_good = IsTopic(order.topic);
        break;
      case RobotOrder::Kind::kJump:
        words >> order.seconds;
        break;
      case RobotOrder::Kind::kTour:
      case RobotOrder::Kind::kNonsense:
        break;
    }
  }
  std::string more;
  if (is_good && !words.fail() && !(words >> more)) return order;
  return absl::InvalidArgumentError(
      absl::StrCat("'", line, "' is no order; ", kOrders));
}

std::vector<std::string> OrderReader::TakeLines() {
  std::vector<std::string> lines;
  std::array<char, 4096> bytes{};
  pollfd input = {.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  while (!is_over_ && poll(&input, 1, 0) > 0) {
    const ssize_t count = read(STDIN_FILENO, bytes.data(), bytes.size());
    // Nobody gives orders any more; the robot goes on.
    is_over_ = count <= 0;
    if (!is_over_) rest_.append(bytes.data(), static_cast<size_t>(count));
  }
  size_t begin = 0;
  for (size_t end = rest_.find('\n'); end != std::string::npos;
       end = rest_.find('\n', begin)) {
    if (end > begin) lines.push_back(rest_.substr(begin, end - begin));
    begin = end + 1;
  }
  rest_.erase(0, begin);
  return lines;
}

}  // namespace treeline::ros2_robot
