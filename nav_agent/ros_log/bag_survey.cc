#include "nav_agent/ros_log/bag_survey.h"

#include <algorithm>
#include <initializer_list>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "nav_agent/ros_log/log_topics.h"
#include "nav_agent/ros_log/robot_text.h"

namespace treeline::ros_log {
namespace {

// As many messages that cannot be read are named.
constexpr size_t kNamedFaults = 5;

std::string Listing(const bag::Bag& bag, const std::vector<int64_t>& counts) {
  std::string text;
  if (bag.topics().empty()) return "  no topics at all\n";
  for (size_t i = 0; i < bag.topics().size(); ++i) {
    absl::StrAppend(&text, "  ", bag.topics()[i].name, ": ", counts[i], " of ",
                    bag.topics()[i].type, "\n");
  }
  return text;
}

absl::StatusOr<std::optional<size_t>> Choose(
    const bag::Bag& bag, const std::vector<int64_t>& counts,
    const std::string& wanted, const std::string& usual,
    std::initializer_list<const char*> types, bool guesses) {
  std::optional<size_t> best;
  for (size_t i = 0; i < bag.topics().size(); ++i) {
    const bag::BagTopic& topic = bag.topics()[i];
    if (std::ranges::count(types, topic.type) == 0) continue;
    if (topic.name == (wanted.empty() ? usual : wanted)) return i;
    if (guesses && (!best || counts[i] > counts[*best])) best = i;
  }
  if (wanted.empty()) return best;
  return absl::InvalidArgumentError(
      absl::StrCat("there is no topic ", wanted, " of type ", *types.begin(),
                   ". There are:\n", Listing(bag, counts)));
}

absl::Status SurveyMessage(const bag::BagTopic& topic,
                           const bag::BagMessage& message, BagSurvey& survey) {
  if (topic.type == messages::TFMessage::kName) {
    TL_ASSIGN_OR_RETURN(const auto tf,
                        bag::Decode<messages::TFMessage>(topic, message.bytes));
    if (absl::EndsWith(topic.name, "tf_static")) {
      survey.transforms.AddStatic(tf);
    } else {
      survey.transforms.Add(tf);
    }
  } else if (topic.type == messages::CameraInfo::kName) {
    if (survey.cameras.count(topic.name) > 0) return absl::OkStatus();
    TL_ASSIGN_OR_RETURN(
        survey.cameras[topic.name],
        bag::Decode<messages::CameraInfo>(topic, message.bytes));
  } else if (topic.type == messages::Odometry::kName) {
    if (survey.base_frames.count(message.topic) > 0) return absl::OkStatus();
    TL_ASSIGN_OR_RETURN(const auto odometry,
                        bag::Decode<messages::Odometry>(topic, message.bytes));
    survey.base_frames[message.topic] = odometry.child_frame_id;
  } else if (topic.name == kRobotTopic &&
             topic.type == messages::String::kName) {
    TL_ASSIGN_OR_RETURN(const auto text,
                        bag::Decode<messages::String>(topic, message.bytes));
    TL_ASSIGN_OR_RETURN(survey.robot, ParseRobotText(text.data));
    survey.has_robot = true;
  }
  return absl::OkStatus();
}

// Frames, and where pictures are.
void SurveyHeader(const bag::BagTopic& topic, const bag::BagMessage& message,
                  BagSurvey& survey) {
  const bool is_picture = topic.type == messages::Image::kName ||
                          topic.type == messages::CompressedImage::kName;
  if (!is_picture && topic.type != messages::LaserScan::kName) return;
  const auto header = bag::DecodeHeader(topic, message.bytes);
  if (!header.ok()) return;
  survey.frames.emplace(message.topic, header->frame_id);
  if (!is_picture) return;
  survey.pictures[message.topic][messages::Nanoseconds(header->stamp)] =
      message.place;
}

std::string ValueOr(const std::map<size_t, std::string>& values,
                    const std::optional<size_t>& topic,
                    const std::string& otherwise) {
  const auto found = topic ? values.find(*topic) : values.end();
  return found == values.end() || found->second.empty() ? otherwise
                                                        : found->second;
}

}  // namespace

std::string BagSurvey::FrameOf(const std::optional<size_t>& topic) const {
  return ValueOr(frames, topic, "");
}

std::string BagSurvey::BaseFrame(const std::optional<size_t>& odometry) const {
  return ValueOr(base_frames, odometry, kBaseFrame);
}

absl::StatusOr<BagSurvey> SurveyBag(bag::Bag& bag) {
  BagSurvey survey;
  survey.counts.resize(bag.topics().size());
  TL_RETURN_IF_ERROR(bag.Read([&](const bag::BagMessage& message) {
    const bag::BagTopic& topic = bag.topics()[message.topic];
    ++survey.counts[message.topic];
    if (survey.first_ns == 0) survey.first_ns = message.time_ns;
    SurveyHeader(topic, message, survey);
    const absl::Status status = SurveyMessage(topic, message, survey);
    if (!status.ok() && survey.notes.size() < kNamedFaults) {
      survey.notes.push_back(
          absl::StrCat("left out: ", std::string(status.message())));
    }
    return absl::OkStatus();
  }));
  if (!bag.is_closed()) {
    survey.notes.emplace_back(
        "the recording was not closed: its end is missing");
  }
  return survey;
}

absl::StatusOr<BagTopics> ChooseTopics(const bag::Bag& bag,
                                       const BagLogOptions& options,
                                       const BagSurvey& survey) {
  BagTopics topics;
  TL_ASSIGN_OR_RETURN(topics.scan,
                      Choose(bag, survey.counts, options.scan_topic, kScanTopic,
                             {messages::LaserScan::kName}, true));
  TL_ASSIGN_OR_RETURN(
      topics.odometry,
      Choose(bag, survey.counts, options.odometry_topic, kOdometryTopic,
             {messages::Odometry::kName}, true));
  if (options.with_frames) {
    const auto pictures = {messages::CompressedImage::kName,
                           messages::Image::kName};
    TL_ASSIGN_OR_RETURN(topics.color,
                        Choose(bag, survey.counts, options.color_topic,
                               kColorTopic, pictures, false));
    TL_ASSIGN_OR_RETURN(topics.depth,
                        Choose(bag, survey.counts, options.depth_topic,
                               kDepthTopic, pictures, false));
  }
  if (topics.scan || topics.color) return topics;
  return absl::InvalidArgumentError(absl::StrCat(
      "there are no scans (sensor_msgs/LaserScan), and no pictures under the "
      "names that are looked for. There are:\n",
      Listing(bag, survey.counts)));
}

}  // namespace treeline::ros_log
