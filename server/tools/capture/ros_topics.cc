#include "server/tools/capture/ros_topics.h"

#include <algorithm>
#include <functional>
#include <map>
#include <tuple>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"

namespace treeline::capture {
namespace {

bool IsDepthEncoding(absl::string_view encoding) {
  return absl::StrContains(encoding, "16UC1") ||
         absl::StrContains(encoding, "32FC1") ||
         absl::StrContains(encoding, "compressedDepth") || encoding == "mono16";
}

// Reads messages into contents, by type.
class ContentsReader {
 public:
  explicit ContentsReader(const bag::Bag& bag) : bag_(&bag) {}

  void Take(const bag::BagMessage& message) {
    const bag::BagTopic& topic = bag_->topics()[message.topic];
    const absl::Status status = TakeByType(topic, message);
    if (!status.ok()) {
      contents_.left_out.Add("a message cannot be read",
                             std::string(status.message()));
    }
  }

  RosContents Finish() && {
    for (auto& [topic, pictures] : pictures_) {
      std::ranges::stable_sort(pictures.pictures, {}, &RosPicture::stamp_ns);
      // clang 14 cannot read what std::ranges::unique returns.
      const auto twice =
          std::unique(pictures.pictures.begin(), pictures.pictures.end(),
                      [](const RosPicture& a, const RosPicture& b) {
                        return a.stamp_ns == b.stamp_ns;
                      });
      for (auto picture = twice; picture != pictures.pictures.end();
           ++picture) {
        contents_.left_out.Add("the time is that of another picture", topic);
      }
      pictures.pictures.erase(twice, pictures.pictures.end());
      contents_.pictures.push_back(std::move(pictures));
    }
    for (auto& [topic, poses] : poses_) {
      contents_.poses.push_back(std::move(poses));
    }
    return std::move(contents_);
  }

  void AddNote(std::string note) { contents_.notes.push_back(std::move(note)); }

 private:
  absl::Status TakeByType(const bag::BagTopic& topic,
                          const bag::BagMessage& message) {
    if (topic.type == messages::Image::kName) {
      return TakePicture<messages::Image>(
          topic, message, [](const messages::Image& i) { return i.encoding; });
    }
    if (topic.type == messages::CompressedImage::kName) {
      return TakePicture<messages::CompressedImage>(
          topic, message,
          [](const messages::CompressedImage& i) { return i.format; });
    }
    if (topic.type == messages::CameraInfo::kName) {
      return TakeCamera(topic, message);
    }
    if (topic.type == messages::TFMessage::kName) {
      TL_ASSIGN_OR_RETURN(const auto tf, bag::Decode<messages::TFMessage>(
                                             topic, message.bytes));
      if (absl::EndsWith(topic.name, "tf_static")) {
        contents_.transforms.AddStatic(tf);
      } else {
        contents_.transforms.Add(tf);
      }
      return absl::OkStatus();
    }
    return TakePose(topic, message);
  }

  template <typename M>
  absl::Status TakePicture(
      const bag::BagTopic& topic, const bag::BagMessage& message,
      const std::function<std::string(const M&)>& encoding) {
    TL_ASSIGN_OR_RETURN(const messages::Header header,
                        bag::DecodeHeader(topic, message.bytes));
    const auto found = pictures_.find(topic.name);
    if (found == pictures_.end()) {
      TL_ASSIGN_OR_RETURN(const M picture,
                          bag::Decode<M>(topic, message.bytes));
      RosPictureTopic& made = pictures_[topic.name];
      made.topic = topic;
      made.encoding = encoding(picture);
      made.is_depth = IsDepthEncoding(made.encoding);
      made.is_compressed = topic.type == messages::CompressedImage::kName;
      made.frame = header.frame_id;
    }
    pictures_[topic.name].pictures.push_back(
        {messages::Nanoseconds(header.stamp), message.place});
    return absl::OkStatus();
  }

  absl::Status TakeCamera(const bag::BagTopic& topic,
                          const bag::BagMessage& message) {
    if (std::ranges::count(contents_.cameras, topic.name,
                           &RosCameraTopic::name) > 0) {
      return absl::OkStatus();
    }
    TL_ASSIGN_OR_RETURN(
        auto info, bag::Decode<messages::CameraInfo>(topic, message.bytes));
    contents_.cameras.push_back({topic.name, std::move(info)});
    return absl::OkStatus();
  }

  absl::Status TakePose(const bag::BagTopic& topic,
                        const bag::BagMessage& message) {
    messages::Header header;
    std::string child;
    absl::StatusOr<geometry::Rigid3> pose;
    if (topic.type == messages::Odometry::kName) {
      TL_ASSIGN_OR_RETURN(const auto value, bag::Decode<messages::Odometry>(
                                                topic, message.bytes));
      header = value.header;
      child = value.child_frame_id;
      pose = conversions::RigidOf(value.pose.pose);
    } else if (topic.type == messages::PoseStamped::kName) {
      TL_ASSIGN_OR_RETURN(const auto value, bag::Decode<messages::PoseStamped>(
                                                topic, message.bytes));
      header = value.header;
      pose = conversions::RigidOf(value.pose);
    } else if (topic.type == messages::PoseWithCovarianceStamped::kName) {
      TL_ASSIGN_OR_RETURN(const auto value,
                          bag::Decode<messages::PoseWithCovarianceStamped>(
                              topic, message.bytes));
      header = value.header;
      pose = conversions::RigidOf(value.pose.pose);
    } else {
      return absl::OkStatus();
    }
    TL_RETURN_IF_ERROR(base::Annotate(pose.status(), topic.name));
    RosPoseTopic& poses = poses_[topic.name];
    poses.name = topic.name;
    poses.type = topic.type;
    poses.frame = header.frame_id.empty() ? "world" : header.frame_id;
    poses.child_frame = child;
    poses.poses.emplace_back(messages::Nanoseconds(header.stamp), *pose);
    return absl::OkStatus();
  }

  const bag::Bag* bag_;
  RosContents contents_;
  std::map<std::string, RosPictureTopic> pictures_;
  std::map<std::string, RosPoseTopic> poses_;
};

bool SaysColor(const std::string& name) {
  const std::string lower = absl::AsciiStrToLower(name);
  return absl::StrContains(lower, "color") || absl::StrContains(lower, "rgb") ||
         absl::StrContains(lower, "colour");
}
bool SaysInfrared(const std::string& name) {
  const std::string lower = absl::AsciiStrToLower(name);
  return absl::StrContains(lower, "infra") || absl::StrContains(lower, "/ir");
}
bool SaysRegistered(const std::string& name) {
  return absl::StrContains(name, "aligned") ||
         absl::StrContains(name, "registered");
}

// "/a/image_raw/compressed" -> "/a/image_raw".
std::string WithoutTransport(const std::string& name) {
  for (const char* transport : {"/compressed", "/compressedDepth"}) {
    if (absl::EndsWith(name, transport)) {
      return name.substr(0, name.size() - std::string(transport).size());
    }
  }
  return name;
}

absl::Status Missing(const RosContents& contents, absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(what, ". There are:\n", contents.Listing()));
}

// What is named; null: there is no such topic of that kind.
const RosPictureTopic* Named(const RosContents& contents,
                             const std::string& name, bool is_depth) {
  for (const RosPictureTopic& topic : contents.pictures) {
    if (topic.topic.name == name && topic.is_depth == is_depth) return &topic;
  }
  return nullptr;
}

}  // namespace

std::string RosContents::Listing() const {
  std::string text;
  for (const RosPictureTopic& topic : pictures) {
    absl::StrAppend(&text, "  ", topic.topic.name, ": ", topic.pictures.size(),
                    topic.is_depth ? " depth maps, " : " pictures, ",
                    topic.encoding, "\n");
  }
  for (const RosCameraTopic& topic : cameras) {
    absl::StrAppend(&text, "  ", topic.name, ": camera_info of ",
                    topic.info.header.frame_id, "\n");
  }
  for (const RosPoseTopic& topic : poses) {
    absl::StrAppend(&text, "  ", topic.name, ": ", topic.poses.size(),
                    " poses, ", topic.type, "\n");
  }
  return text.empty() ? "  no pictures, cameras or poses\n" : text;
}

absl::StatusOr<RosContents> ReadRosContents(bag::Bag& bag) {
  ContentsReader reader(bag);
  const absl::Status status = bag.Read([&](const bag::BagMessage& message) {
    reader.Take(message);
    return absl::OkStatus();
  });
  // What came before a broken part is as good as ever.
  if (!status.ok()) {
    reader.AddNote(
        absl::StrCat("the recording is broken, and read as far as "
                     "it goes: ",
                     status.message()));
  }
  return std::move(reader).Finish();
}

absl::StatusOr<const RosPictureTopic*> ChooseColor(const RosContents& contents,
                                                   const std::string& wanted) {
  if (!wanted.empty()) {
    const RosPictureTopic* named = Named(contents, wanted, false);
    if (named != nullptr) return named;
    return Missing(contents, absl::StrCat("there is no topic ", wanted,
                                          " with colour pictures"));
  }
  const RosPictureTopic* best = nullptr;
  const auto rank = [](const RosPictureTopic& topic) {
    return std::tuple(!SaysInfrared(topic.topic.name),
                      SaysColor(topic.topic.name), topic.pictures.size(),
                      !topic.is_compressed);
  };
  for (const RosPictureTopic& topic : contents.pictures) {
    if (topic.is_depth) continue;
    if (best == nullptr || rank(topic) > rank(*best)) best = &topic;
  }
  if (best != nullptr) return best;
  return Missing(contents,
                 "there are no colour pictures (sensor_msgs/Image or "
                 "CompressedImage)");
}

absl::StatusOr<const RosPictureTopic*> ChooseDepth(const RosContents& contents,
                                                   const RosPictureTopic& color,
                                                   const std::string& wanted) {
  if (wanted == "none") return nullptr;
  if (!wanted.empty()) {
    const RosPictureTopic* named = Named(contents, wanted, true);
    if (named != nullptr) return named;
    return Missing(contents, absl::StrCat("there is no topic ", wanted,
                                          " with depth (16UC1 or 32FC1)"));
  }
  const RosPictureTopic* best = nullptr;
  const auto rank = [&](const RosPictureTopic& topic) {
    return std::tuple(topic.frame == color.frame,
                      SaysRegistered(topic.topic.name), topic.pictures.size(),
                      !topic.is_compressed);
  };
  for (const RosPictureTopic& topic : contents.pictures) {
    if (!topic.is_depth) continue;
    if (best == nullptr || rank(topic) > rank(*best)) best = &topic;
  }
  return best;
}

absl::StatusOr<const RosCameraTopic*> ChooseCamera(
    const RosContents& contents, const RosPictureTopic& pictures,
    const std::string& wanted, const char* flag) {
  const auto find = [&](const auto& fits) -> const RosCameraTopic* {
    const auto found = std::ranges::find_if(contents.cameras, fits);
    return found == contents.cameras.end() ? nullptr : &*found;
  };
  if (!wanted.empty()) {
    const RosCameraTopic* named = find(
        [&](const RosCameraTopic& camera) { return camera.name == wanted; });
    if (named != nullptr) return named;
    return Missing(contents, absl::StrCat("there is no topic ", wanted,
                                          " of type sensor_msgs/CameraInfo"));
  }
  const std::string base = WithoutTransport(pictures.topic.name);
  const std::string beside =
      absl::StrCat(base.substr(0, base.rfind('/') + 1), "camera_info");
  if (const RosCameraTopic* camera =
          find([&](const RosCameraTopic& c) { return c.name == beside; })) {
    return camera;
  }
  if (const RosCameraTopic* camera = find([&](const RosCameraTopic& c) {
        return !pictures.frame.empty() &&
               c.info.header.frame_id == pictures.frame;
      })) {
    return camera;
  }
  return Missing(contents,
                 absl::StrCat("there is no camera_info beside ",
                              pictures.topic.name, ", nor one of frame \"",
                              pictures.frame, "\"; name it with ", flag));
}

}  // namespace treeline::capture
