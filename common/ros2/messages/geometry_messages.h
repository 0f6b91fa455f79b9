// Messages of geometry_msgs and tf2_msgs. m, rad, m/s and rad/s.
#ifndef COMMON_ROS2_MESSAGES_GEOMETRY_MESSAGES_H_
#define COMMON_ROS2_MESSAGES_GEOMETRY_MESSAGES_H_

#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/message_fields.h"

namespace treeline::messages {

struct Vector3 {
  double x = 0;
  double y = 0;
  double z = 0;

  bool operator==(const Vector3&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/Vector3";
  static constexpr auto Fields() {
    return std::make_tuple(Named("x", &Vector3::x), Named("y", &Vector3::y),
                           Named("z", &Vector3::z));
  }
};

struct Point {
  double x = 0;
  double y = 0;
  double z = 0;

  bool operator==(const Point&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/Point";
  static constexpr auto Fields() {
    return std::make_tuple(Named("x", &Point::x), Named("y", &Point::y),
                           Named("z", &Point::z));
  }
};

struct Quaternion {
  double x = 0;
  double y = 0;
  double z = 0;
  double w = 1;

  bool operator==(const Quaternion&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/Quaternion";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("x", &Quaternion::x), Named("y", &Quaternion::y),
        Named("z", &Quaternion::z), Named("w", &Quaternion::w));
  }
};

struct Pose {
  Point position;
  Quaternion orientation;

  bool operator==(const Pose&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/Pose";
  static constexpr auto Fields() {
    return std::make_tuple(Named("position", &Pose::position),
                           Named("orientation", &Pose::orientation));
  }
};

struct PoseStamped {
  Header header;
  Pose pose;

  bool operator==(const PoseStamped&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/PoseStamped";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &PoseStamped::header),
                           Named("pose", &PoseStamped::pose));
  }
};

// The covariance is row-major, of x, y, z and of rotations about these axes:
// the order of geometry::PoseCovariance.
struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance = {};

  bool operator==(const PoseWithCovariance&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/PoseWithCovariance";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("pose", &PoseWithCovariance::pose),
        Named("covariance", &PoseWithCovariance::covariance));
  }
};

struct PoseWithCovarianceStamped {
  Header header;
  PoseWithCovariance pose;

  bool operator==(const PoseWithCovarianceStamped&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/PoseWithCovarianceStamped";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &PoseWithCovarianceStamped::header),
                           Named("pose", &PoseWithCovarianceStamped::pose));
  }
};

struct Twist {
  Vector3 linear;
  Vector3 angular;

  bool operator==(const Twist&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/Twist";
  static constexpr auto Fields() {
    return std::make_tuple(Named("linear", &Twist::linear),
                           Named("angular", &Twist::angular));
  }
};

struct TwistStamped {
  Header header;
  Twist twist;

  bool operator==(const TwistStamped&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/TwistStamped";
  static constexpr auto Fields() {
    return std::make_tuple(Named("header", &TwistStamped::header),
                           Named("twist", &TwistStamped::twist));
  }
};

struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance = {};

  bool operator==(const TwistWithCovariance&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/TwistWithCovariance";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("twist", &TwistWithCovariance::twist),
        Named("covariance", &TwistWithCovariance::covariance));
  }
};

struct Transform {
  Vector3 translation;
  Quaternion rotation;

  bool operator==(const Transform&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/Transform";
  static constexpr auto Fields() {
    return std::make_tuple(Named("translation", &Transform::translation),
                           Named("rotation", &Transform::rotation));
  }
};

// Takes points of child_frame_id into header.frame_id.
struct TransformStamped {
  Header header;
  std::string child_frame_id;
  Transform transform;

  bool operator==(const TransformStamped&) const = default;
  static constexpr char kName[] = "geometry_msgs/msg/TransformStamped";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("header", &TransformStamped::header),
        Named("child_frame_id", &TransformStamped::child_frame_id),
        Named("transform", &TransformStamped::transform));
  }
};

struct TFMessage {
  std::vector<TransformStamped> transforms;

  bool operator==(const TFMessage&) const = default;
  static constexpr char kName[] = "tf2_msgs/msg/TFMessage";
  static constexpr auto Fields() {
    return std::make_tuple(Named("transforms", &TFMessage::transforms));
  }
};

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_GEOMETRY_MESSAGES_H_
