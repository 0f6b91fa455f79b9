#include "server/tools/capture/ros_bag.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "common/ros2/bag/open_bag.h"
#include "common/ros2/conversions/camera_values.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/ros_topics.h"

namespace treeline::capture {
namespace {

// Colour and depth further apart are not of one moment: less than from one
// picture to the next at 30 Hz.
constexpr int64_t kSameMoment_ns = 20'000'000;
constexpr double kMillimetre = 0.001;
constexpr double kFarthest_mm = 65534;

absl::StatusOr<image::ColorImage> ColorIn(const RosPictureTopic& topic,
                                          std::span<const uint8_t> bytes,
                                          std::string& encoded) {
  if (!topic.is_compressed) {
    TL_ASSIGN_OR_RETURN(const auto message,
                        bag::Decode<messages::Image>(topic.topic, bytes));
    return conversions::ColorOf(message);
  }
  TL_ASSIGN_OR_RETURN(
      const auto message,
      bag::Decode<messages::CompressedImage>(topic.topic, bytes));
  encoded.assign(message.data.begin(), message.data.end());
  return conversions::ColorOf(message);
}

absl::StatusOr<image::DepthImage> DepthIn(const RosPictureTopic& topic,
                                          std::span<const uint8_t> bytes) {
  if (!topic.is_compressed) {
    TL_ASSIGN_OR_RETURN(const auto message,
                        bag::Decode<messages::Image>(topic.topic, bytes));
    return conversions::DepthOf(message);
  }
  TL_ASSIGN_OR_RETURN(
      const auto message,
      bag::Decode<messages::CompressedImage>(topic.topic, bytes));
  return conversions::DepthOf(message);
}

struct FramePlaces {
  bag::BagPlace color;
  std::optional<bag::BagPlace> depth;
};

class RosPictures final : public PictureSource {
 public:
  RosPictures(std::unique_ptr<bag::Bag> bag, RosPictureTopic color,
              std::optional<RosPictureTopic> depth, double depth_factor)
      : bag_(std::move(bag)),
        color_(std::move(color)),
        depth_(std::move(depth)),
        depth_factor_(depth_factor) {}

  void Add(const FramePlaces& places) { places_.push_back(places); }

  absl::StatusOr<Pictures> Load(size_t frame) override {
    const FramePlaces& places = places_.at(frame);
    Pictures pictures;
    TL_ASSIGN_OR_RETURN(const auto color_bytes, bag_->Fetch(places.color));
    auto color = ColorIn(color_, color_bytes, pictures.encoded_color);
    if (!color.ok()) return base::Annotate(color.status(), color_.topic.name);
    pictures.color = *std::move(color);
    if (!places.depth) return pictures;
    TL_ASSIGN_OR_RETURN(const auto depth_bytes, bag_->Fetch(*places.depth));
    auto depth = DepthIn(*depth_, depth_bytes);
    if (!depth.ok()) return base::Annotate(depth.status(), depth_->topic.name);
    pictures.depth = *std::move(depth);
    if (depth_factor_ == 1) return pictures;
    for (uint16_t& value : pictures.depth->values) {
      const double depth_mm = std::round(value * depth_factor_);
      value = depth_mm > kFarthest_mm ? 0 : static_cast<uint16_t>(depth_mm);
    }
    return pictures;
  }

 private:
  const std::unique_ptr<bag::Bag> bag_;
  const RosPictureTopic color_;
  const std::optional<RosPictureTopic> depth_;
  // From what the messages say in mm.
  const double depth_factor_;
  std::vector<FramePlaces> places_;
};

// The picture of `topic` that is nearest to the time, if near enough.
const RosPicture* NearestTo(const RosPictureTopic& topic, int64_t stamp_ns) {
  const auto next = std::ranges::lower_bound(topic.pictures, stamp_ns, {},
                                             &RosPicture::stamp_ns);
  const RosPicture* best = nullptr;
  double best_ns = kSameMoment_ns;
  const auto consider = [&](const RosPicture& picture) {
    // Stamps are from outside: their difference need not fit.
    const double apart_ns = std::abs(static_cast<double>(picture.stamp_ns) -
                                     static_cast<double>(stamp_ns));
    if (apart_ns > best_ns) return;
    best = &picture;
    best_ns = apart_ns;
  };
  if (next != topic.pictures.end()) consider(*next);
  if (next != topic.pictures.begin()) consider(*std::prev(next));
  return best;
}

bool IsRectified(const RosPictureTopic& topic) {
  return absl::StrContains(topic.topic.name, "rect");
}

// The frame whose pose is asked for, and the world that it is asked in.
struct PoseSource {
  std::string world;
  std::string description;
};

absl::Status NoPoses(const RosContents& contents, absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(
      what,
      ". Record /tf and /tf_static while a SLAM or odometry runs, or name a "
      "topic with --pose-topic; depth without poses goes through "
      "`treeline-agent map --rgbd`. There are:\n",
      contents.Listing()));
}

// The world on the way from the camera up, if anything moves there.
std::optional<std::string> WorldOfTransforms(
    const conversions::TransformHistory& transforms,
    const std::string& camera_frame, const std::string& wanted) {
  const std::vector<std::string> chain = transforms.ChainFrom(camera_frame);
  // Where each frame of the chain is in the next one up.
  std::vector<std::string> moving;
  bool has_moved = false;
  for (size_t i = 1; i < chain.size(); ++i) {
    has_moved |= transforms.Moves(chain[i - 1]);
    if (has_moved) moving.push_back(chain[i]);
  }
  if (!wanted.empty()) {
    return std::ranges::count(moving,
                              std::string(absl::StripPrefix(wanted, "/"))) > 0
               ? std::optional(wanted)
               : std::nullopt;
  }
  for (const char* usual : {"map", "world", "odom"}) {
    if (std::ranges::count(moving, usual) > 0) return usual;
  }
  if (moving.empty()) return std::nullopt;
  return moving.back();
}

// Decides where poses come from; those of a topic go into the transforms.
absl::StatusOr<PoseSource> ChoosePoses(RosContents& contents,
                                       const RosOptions& options,
                                       const std::string& camera_frame) {
  if (options.pose_topic.empty() || options.pose_topic == "tf") {
    const auto world = WorldOfTransforms(contents.transforms, camera_frame,
                                         options.world_frame);
    if (world) {
      return PoseSource{*world, absl::StrCat("poses: /tf, frame ", camera_frame,
                                             " in ", *world)};
    }
    if (options.pose_topic == "tf" || !options.world_frame.empty()) {
      return NoPoses(
          contents,
          absl::StrCat("/tf does not tell how ", camera_frame, " moves",
                       options.world_frame.empty() ? "" : " in ",
                       options.world_frame));
    }
    if (contents.poses.empty()) {
      return NoPoses(contents, "nothing tells where the camera was");
    }
    if (contents.poses.size() > 1) {
      return NoPoses(contents,
                     "several topics tell poses; choose one with --pose-topic");
    }
  }
  const auto topic =
      std::ranges::find_if(contents.poses, [&](const RosPoseTopic& known) {
        return options.pose_topic.empty() || known.name == options.pose_topic;
      });
  if (topic == contents.poses.end()) {
    return NoPoses(contents, absl::StrCat("there is no topic ",
                                          options.pose_topic, " of poses"));
  }
  std::string child =
      options.pose_frame.empty() ? topic->child_frame : options.pose_frame;
  if (child.empty()) child = camera_frame;
  for (const auto& [time_ns, pose] : topic->poses) {
    contents.transforms.AddPose(topic->frame, child, time_ns, pose);
  }
  const std::vector<std::string> chain =
      contents.transforms.ChainFrom(camera_frame);
  if (std::ranges::count(chain, std::string(absl::StripPrefix(child, "/"))) ==
      0) {
    return NoPoses(
        contents,
        absl::StrCat(topic->name, " tells where ", child,
                     " is, but nothing where the camera's frame ", camera_frame,
                     " is on it (name the frame with --pose-frame)"));
  }
  return PoseSource{topic->frame,
                    absl::StrCat("poses: ", topic->name, ", frame ", child,
                                 " in ", topic->frame)};
}

// Its camera, and where it is on the colour camera; a note where it has to be
// left out.
struct DepthCamera {
  std::optional<camera::Camera> camera;
  geometry::Rigid3 color_from_depth;
};

absl::StatusOr<DepthCamera> DepthCameraOf(const RosContents& contents,
                                          const RosPictureTopic& depth,
                                          const RosPictureTopic& color,
                                          const RosOptions& options) {
  DepthCamera made;
  const bool is_same = depth.frame == color.frame;
  const auto info = ChooseCamera(contents, depth, options.depth_camera_info,
                                 "--depth-camera-info");
  if (info.ok()) {
    auto camera = conversions::CameraOf((*info)->info, IsRectified(depth));
    if (!camera.ok()) {
      return base::Annotate(camera.status(), (*info)->name);
    }
    made.camera = *std::move(camera);
  } else if (!options.depth_camera_info.empty() || !is_same) {
    return info.status();
  }
  if (is_same) return made;
  const auto color_from_depth = contents.transforms.Find(
      color.frame, depth.frame, color.pictures.front().stamp_ns);
  if (!color_from_depth.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(
        depth.topic.name, " is not registered to colour, and ",
        color_from_depth.status().message(),
        "; record /tf_static, or registered depth, or leave depth out with "
        "--depth-topic none"));
  }
  made.color_from_depth = *color_from_depth;
  return made;
}

// Adds the frames that have a pose, and where their pictures come from.
void AddFrames(const RosContents& contents, const RosPictureTopic& color,
               const RosPictureTopic* depth, const PoseSource& poses,
               const camera::Camera& camera, const geometry::Rotation3& z_up,
               std::unique_ptr<RosPictures> pictures, Capture& capture) {
  int without_depth = 0;
  for (const RosPicture& picture : color.pictures) {
    const std::string name = absl::StrFormat(
        "%s at %d.%09d", color.topic.name, picture.stamp_ns / 1'000'000'000,
        std::abs(picture.stamp_ns % 1'000'000'000));
    const auto pose =
        contents.transforms.Find(poses.world, color.frame, picture.stamp_ns);
    if (!pose.ok()) {
      capture.left_out.Add("there is no pose at its time",
                           absl::StrCat(name, ": ", pose.status().message()));
      continue;
    }
    FramePlaces places = {.color = picture.place, .depth = {}};
    if (depth != nullptr) {
      const RosPicture* nearest = NearestTo(*depth, picture.stamp_ns);
      if (nearest != nullptr) {
        places.depth = nearest->place;
      } else {
        ++without_depth;
      }
    }
    capture.frames.push_back({name, camera, Rotated(z_up, *pose)});
    pictures->Add(places);
  }
  if (without_depth > 0) {
    capture.notes.push_back(absl::StrCat(
        without_depth, " pictures have no depth map within 20 ms"));
  }
  capture.pictures = std::move(pictures);
}

}  // namespace

bool IsRosBag(const std::string& path) { return bag::IsBag(path); }

absl::StatusOr<Capture> OpenRosBag(const std::string& path,
                                   const OpenOptions& options) {
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "z"));
  TL_ASSIGN_OR_RETURN(std::unique_ptr<bag::Bag> opened, bag::OpenBag(path));
  TL_ASSIGN_OR_RETURN(RosContents contents, ReadRosContents(*opened));
  const RosOptions& ros = options.ros;
  TL_ASSIGN_OR_RETURN(const RosPictureTopic* color,
                      ChooseColor(contents, ros.color_topic));
  TL_ASSIGN_OR_RETURN(const RosPictureTopic* depth,
                      ChooseDepth(contents, *color, ros.depth_topic));
  TL_ASSIGN_OR_RETURN(
      const RosCameraTopic* info,
      ChooseCamera(contents, *color, ros.camera_info, "--camera-info"));
  const auto camera = conversions::CameraOf(info->info, IsRectified(*color));
  if (!camera.ok()) return base::Annotate(camera.status(), info->name);

  Capture capture;
  capture.format = "rosbag";
  capture.left_out = contents.left_out;
  capture.notes = contents.notes;
  if (depth != nullptr) {
    TL_ASSIGN_OR_RETURN(const DepthCamera depth_camera,
                        DepthCameraOf(contents, *depth, *color, ros));
    capture.depth = depth_camera.camera;
    capture.color_from_depth = depth_camera.color_from_depth;
  }
  capture.notes.push_back(absl::StrCat(
      "colour: ", color->topic.name, ", ", color->encoding,
      "; camera: ", info->name, IsRectified(*color) ? ", rectified" : ""));
  capture.notes.push_back(
      depth == nullptr
          ? "depth: none"
          : absl::StrCat("depth: ", depth->topic.name, ", ", depth->encoding));
  TL_ASSIGN_OR_RETURN(const PoseSource poses,
                      ChoosePoses(contents, ros, color->frame));
  capture.notes.push_back(poses.description);

  AddFrames(
      contents, *color, depth, poses, *camera, z_up,
      std::make_unique<RosPictures>(
          std::move(opened), *color,
          depth == nullptr ? std::nullopt : std::optional(*depth),
          options.depth_unit_m > 0 ? options.depth_unit_m / kMillimetre : 1),
      capture);
  return capture;
}

}  // namespace treeline::capture
