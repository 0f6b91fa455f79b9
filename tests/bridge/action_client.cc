// A client of the action NavigateToPose, as nodes of ROS 2 have one: by the
// services of rmw_fastrtps_cpp, over Fast DDS alone, or by those of
// rmw_cyclonedds_cpp.
//
//   action_client DOMAIN fastrtps|cyclonedds
//
// Lines on standard input, which wait until the server was found; N is a number
// from 1 to 255 that stands for an id:
//   goal N FRAME X Y YAW [TREE]   "nan" is a number, too
//   cancel N                      0: all
// On standard output:
//   ready                         the server was found
//   accepted N MS | rejected N MS   since it was sent
//   canceling CODE COUNT
//   status N:STATUS ...           whenever it changes
//   feedback N TO_GO_M TIME_S RECOVERIES X Y
//   result N STATUS ERROR_CODE MESSAGE
#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "common/ros2/messages/action_messages.h"
#include "common/ros2/messages/message_codec.h"
#include "nav_agent/bridge/dds/domain.h"
#include "nav_agent/bridge/dds/node.h"
#include "nav_agent/bridge/dds/testing_client.h"
#include "nav_agent/bridge/fast_dds/testing_fast_client.h"

namespace treeline {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr char kInside[] = "/navigate_to_pose/_action/";

// One of the three services, or one of the two topics, whoever carries it.
struct ServiceClient {
  std::function<bool()> is_matched;
  std::function<int64_t(const Bytes&)> ask;
  std::function<std::optional<Bytes>(int64_t)> reply_to;
};
using Listener = std::function<std::vector<Bytes>()>;

struct Carrier {
  std::function<ServiceClient(const std::string& name, const std::string& type)>
      client;
  std::function<Listener(const std::string& name, const std::string& type,
                         bool is_latched)>
      listener;
};

Carrier OverFastDds(int domain) {
  return {
      .client =
          [domain](const std::string& name, const std::string& type) {
            auto client = std::make_shared<fast_dds::TestingFastClient>(
                domain, kInside + name, type);
            return ServiceClient{
                .is_matched = [client] { return client->IsMatched(); },
                .ask = [client](const Bytes& b) { return client->Ask(b); },
                .reply_to = [client](int64_t n) { return client->ReplyTo(n); }};
          },
      .listener = [domain](const std::string& name, const std::string& type,
                           bool is_latched) -> Listener {
        auto topic = std::make_shared<fast_dds::TestingFastSubscription>(
            domain, kInside + name, type, is_latched);
        return [topic] { return topic->Take(); };
      }};
}

Carrier OverCyclone(int id) {
  std::shared_ptr<dds::Domain> domain =
      dds::Domain::Join({.id = id, .interface = "lo"}).value();
  std::shared_ptr<dds::Node> node =
      dds::Node::Create(*domain, {.node = "client", .remappings = {}}).value();
  return {
      .client =
          [domain](const std::string& name, const std::string& type) {
            auto client = std::make_shared<dds::TestingClient>(
                *domain, kInside + name, type);
            return ServiceClient{
                .is_matched = [client] { return client->IsMatched(); },
                .ask = [client](const Bytes& b) { return client->Ask(b); },
                .reply_to = [client](int64_t n) { return client->ReplyTo(n); }};
          },
      .listener = [domain, node](const std::string& name,
                                 const std::string& type,
                                 bool is_latched) -> Listener {
        std::shared_ptr<dds::Subscription> topic =
            node->Subscribe(kInside + name, type,
                            {.is_latched = is_latched, .depth = 10})
                .value();
        return [topic, node] {
          std::vector<Bytes> all;
          for (dds::Sample& sample : topic->Take()) {
            all.push_back(std::move(sample.bytes));
          }
          return all;
        };
      }};
}

messages::Uuid IdOf(int number) {
  messages::Uuid id;
  // Of 0, that of nobody.
  if (number != 0) id.uuid = {1, 2, 3, static_cast<uint8_t>(number)};
  return id;
}

class Player {
 public:
  explicit Player(const Carrier& carrier)
      : send_goal_(carrier.client("send_goal",
                                  "nav2_msgs/action/NavigateToPose_SendGoal")),
        cancel_goal_(
            carrier.client("cancel_goal", "action_msgs/srv/CancelGoal")),
        get_result_(carrier.client(
            "get_result", "nav2_msgs/action/NavigateToPose_GetResult")),
        feedback_(carrier.listener(
            "feedback", messages::NavigateToPoseFeedbackMessage::kName, false)),
        status_(carrier.listener("status", messages::GoalStatusArray::kName,
                                 true)) {}

  bool IsReady() const {
    return send_goal_.is_matched() && cancel_goal_.is_matched() &&
           get_result_.is_matched();
  }
  void Take(const std::string& line);
  void Tell();

 private:
  template <typename M>
  static std::optional<M> Reply(const ServiceClient& client, int64_t asked) {
    const std::optional<Bytes> bytes = client.reply_to(asked);
    if (!bytes.has_value()) return std::nullopt;
    return messages::Decode<M>(*bytes).value();
  }
  void TellReplies();

  const ServiceClient send_goal_;
  const ServiceClient cancel_goal_;
  const ServiceClient get_result_;
  const Listener feedback_;
  const Listener status_;
  // Requests that are not answered, and of which goal they are.
  struct SentGoal {
    int number = 0;
    std::chrono::steady_clock::time_point sent;
  };
  std::map<int64_t, SentGoal> goals_;
  std::map<int64_t, int> cancels_;
  std::map<int64_t, int> results_;
};

void Player::Take(const std::string& line) {
  std::istringstream words(line);
  std::string order;
  int number = 0;
  words >> order >> number;
  if (order == "cancel") {
    messages::CancelGoalRequest request;
    request.goal_info.goal_id = IdOf(number);
    cancels_[cancel_goal_.ask(messages::Encode(request))] = number;
    return;
  }
  std::string x;
  std::string y;
  double yaw = 0;
  messages::NavigateToPoseSendGoalRequest request;
  words >> request.goal.pose.header.frame_id >> x >> y >> yaw >>
      request.goal.behavior_tree;
  request.goal_id = IdOf(number);
  request.goal.pose.pose.position = {std::atof(x.c_str()), std::atof(y.c_str()),
                                     0};
  request.goal.pose.pose.orientation.z = std::sin(yaw / 2);
  request.goal.pose.pose.orientation.w = std::cos(yaw / 2);
  const int64_t asked = send_goal_.ask(messages::Encode(request));
  goals_[asked] = {.number = number, .sent = std::chrono::steady_clock::now()};
}

void Player::TellReplies() {
  std::erase_if(goals_, [this](const auto& goal) {
    const auto reply =
        Reply<messages::NavigateToPoseSendGoalResponse>(send_goal_, goal.first);
    if (!reply.has_value()) return false;
    const std::chrono::duration<double, std::milli> took =
        std::chrono::steady_clock::now() - goal.second.sent;
    std::printf("%s %d %.1f\n", reply->accepted ? "accepted" : "rejected",
                goal.second.number, took.count());
    if (reply->accepted) {
      results_[get_result_.ask(
          messages::Encode(messages::NavigateToPoseGetResultRequest{
              .goal_id = IdOf(goal.second.number)}))] = goal.second.number;
    }
    return true;
  });
  std::erase_if(cancels_, [this](const auto& cancel) {
    const auto reply =
        Reply<messages::CancelGoalResponse>(cancel_goal_, cancel.first);
    if (!reply.has_value()) return false;
    std::printf("canceling %d %zu\n", reply->return_code,
                reply->goals_canceling.size());
    return true;
  });
  std::erase_if(results_, [this](const auto& result) {
    const auto reply = Reply<messages::NavigateToPoseGetResultResponse>(
        get_result_, result.first);
    if (!reply.has_value()) return false;
    std::printf("result %d %d %d %s\n", result.second, reply->status,
                reply->result.error_code, reply->result.error_msg.c_str());
    return true;
  });
}

void Player::Tell() {
  for (const Bytes& bytes : status_()) {
    std::printf("status");
    const auto array = messages::Decode<messages::GoalStatusArray>(bytes);
    for (const messages::GoalStatus& goal : array.value().status_list) {
      std::printf(" %d:%d", goal.goal_info.goal_id.uuid[3], goal.status);
    }
    std::printf("\n");
  }
  for (const Bytes& bytes : feedback_()) {
    const auto message =
        messages::Decode<messages::NavigateToPoseFeedbackMessage>(bytes)
            .value();
    const messages::NavigateToPoseFeedback& feedback = message.feedback;
    std::printf(
        "feedback %d %.2f %.2f %d %.2f %.2f\n", message.goal_id.uuid[3],
        static_cast<double>(feedback.distance_remaining),
        feedback.navigation_time.sec + 1e-9 * feedback.navigation_time.nanosec,
        feedback.number_of_recoveries, feedback.current_pose.pose.position.x,
        feedback.current_pose.pose.position.y);
  }
  TellReplies();
  std::fflush(stdout);
}

// What stands on standard input, line by line, without waiting.
class Lines {
 public:
  Lines() { fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK); }
  // False: it has ended.
  bool Take(const std::function<void(const std::string&)>& line) {
    char bytes[512];
    const ssize_t got = read(STDIN_FILENO, bytes, sizeof(bytes));
    if (got == 0) return false;
    if (got > 0) text_.append(bytes, static_cast<size_t>(got));
    for (size_t end = text_.find('\n'); end != std::string::npos;
         end = text_.find('\n')) {
      line(text_.substr(0, end));
      text_.erase(0, end + 1);
    }
    return true;
  }

 private:
  std::string text_;
};

int Main(int domain, const std::string& rmw) {
  // It has the domain, which all the rest is in.
  const Carrier carrier =
      rmw == "fastrtps" ? OverFastDds(domain) : OverCyclone(domain);
  Player player(carrier);
  Lines lines;
  bool is_ready = false;
  // As a client that waits for its server.
  std::vector<std::string> orders;
  while (lines.Take([&](const std::string& line) { orders.push_back(line); })) {
    if (!is_ready && player.IsReady()) {
      is_ready = true;
      std::printf("ready\n");
    }
    if (is_ready) {
      for (const std::string& order : orders) player.Take(order);
      orders.clear();
    }
    player.Tell();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return 0;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s DOMAIN fastrtps|cyclonedds\n", argv[0]);
    return 2;
  }
  return treeline::Main(std::atoi(argv[1]), argv[2]);
}
