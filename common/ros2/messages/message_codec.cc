#include "common/ros2/messages/message_codec.h"

#include <cstddef>
#include <tuple>

#include "common/base/status_macros.h"
#include "common/ros2/cdr/cdr_reader.h"
#include "common/ros2/cdr/cdr_writer.h"
#include "common/ros2/messages/action_messages.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/ros1_reader.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::messages {
namespace {

// The fewest bytes that a value takes, padding left out.
template <typename T>
constexpr size_t MinBytes() {
  if constexpr (Message<T>) {
    return std::apply(
        [](auto... field) {
          return (size_t{0} + ... + [](auto member) {
            using Value =
                std::remove_reference_t<decltype(std::declval<T>().*member)>;
            return MinBytes<Value>();
          }(field.member));
        },
        T::Fields());
  } else if constexpr (kIsArray<T>) {
    return std::tuple_size_v<T> * MinBytes<typename Elements<T>::Type>();
  } else if constexpr (kIsSequence<T> || std::same_as<T, std::string>) {
    return sizeof(uint32_t);
  } else {
    return sizeof(T);
  }
}

template <typename T>
void Put(const T& value, cdr::CdrWriter& writer) {
  if constexpr (Message<T>) {
    std::apply([&](auto... field) { (Put(value.*field.member, writer), ...); },
               T::Fields());
  } else if constexpr (std::same_as<T, std::string>) {
    writer.WriteString(value);
  } else if constexpr (std::same_as<T, std::byte>) {
    writer.Write(static_cast<uint8_t>(value));
  } else if constexpr (cdr::Primitive<T>) {
    writer.Write(value);
  } else {
    using Element = typename Elements<T>::Type;
    if constexpr (kIsSequence<T>) writer.WriteCount(value.size());
    if constexpr (cdr::Primitive<Element>) {
      writer.WriteArray(std::span<const Element>(value));
    } else {
      for (const Element& element : value) Put(element, writer);
    }
  }
}

// Reader: cdr::CdrReader or Ros1Reader.
template <typename T, typename Reader>
void Get(T& value, Reader& reader) {
  if constexpr (std::same_as<T, Header> && std::same_as<Reader, Ros1Reader>) {
    reader.template Read<uint32_t>();  // a number in sequence
  }
  if constexpr (Message<T>) {
    std::apply([&](auto... field) { (Get(value.*field.member, reader), ...); },
               T::Fields());
  } else if constexpr (std::same_as<T, std::string>) {
    value = reader.ReadString();
  } else if constexpr (std::same_as<T, std::byte>) {
    value = static_cast<std::byte>(reader.template Read<uint8_t>());
  } else if constexpr (cdr::Primitive<T>) {
    value = reader.template Read<T>();
  } else {
    using Element = typename Elements<T>::Type;
    if constexpr (kIsSequence<T>) {
      value.resize(reader.ReadCount(MinBytes<Element>()));
    }
    if constexpr (cdr::Primitive<Element>) {
      reader.ReadArray(std::span<Element>(value));
    } else {
      for (Element& element : value) Get(element, reader);
    }
  }
}

template <typename M, typename Reader>
absl::StatusOr<M> DecodeBy(std::span<const uint8_t> bytes) {
  Reader reader(bytes);
  M message;
  Get(message, reader);
  if (absl::Status status = reader.Finish(); !status.ok()) {
    return base::Annotate(status, M::kName);
  }
  return message;
}

template <typename Reader>
absl::StatusOr<Header> HeaderBy(std::span<const uint8_t> bytes) {
  Reader reader(bytes);
  Header header;
  Get(header, reader);
  if (!reader.status().ok()) {
    return base::Annotate(reader.status(), Header::kName);
  }
  return header;
}

}  // namespace

template <Message M>
std::vector<uint8_t> Encode(const M& message) {
  cdr::CdrWriter writer;
  Put(message, writer);
  return std::move(writer).Take();
}

template <Message M>
absl::StatusOr<M> Decode(std::span<const uint8_t> bytes) {
  return DecodeBy<M, cdr::CdrReader>(bytes);
}

template <Message M>
absl::StatusOr<M> DecodeRos1(std::span<const uint8_t> bytes) {
  return DecodeBy<M, Ros1Reader>(bytes);
}

absl::StatusOr<Header> DecodeHeader(std::span<const uint8_t> bytes) {
  return HeaderBy<cdr::CdrReader>(bytes);
}

absl::StatusOr<Header> DecodeHeaderRos1(std::span<const uint8_t> bytes) {
  return HeaderBy<Ros1Reader>(bytes);
}

template std::vector<uint8_t> Encode(const Time&);
template absl::StatusOr<Time> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Header&);
template absl::StatusOr<Header> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Empty&);
template absl::StatusOr<Empty> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Clock&);
template absl::StatusOr<Clock> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const String&);
template absl::StatusOr<String> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Bool&);
template absl::StatusOr<Bool> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Float64&);
template absl::StatusOr<Float64> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Log&);
template absl::StatusOr<Log> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const JointState&);
template absl::StatusOr<JointState> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Imu&);
template absl::StatusOr<Imu> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const KeyValue&);
template absl::StatusOr<KeyValue> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const DiagnosticStatus&);
template absl::StatusOr<DiagnosticStatus> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const DiagnosticArray&);
template absl::StatusOr<DiagnosticArray> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Vector3&);
template absl::StatusOr<Vector3> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Point&);
template absl::StatusOr<Point> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Quaternion&);
template absl::StatusOr<Quaternion> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Pose&);
template absl::StatusOr<Pose> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const PoseStamped&);
template absl::StatusOr<PoseStamped> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const PoseWithCovarianceStamped&);
template absl::StatusOr<PoseWithCovarianceStamped> Decode(
    std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Twist&);
template absl::StatusOr<Twist> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const TwistStamped&);
template absl::StatusOr<TwistStamped> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const TransformStamped&);
template absl::StatusOr<TransformStamped> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const TFMessage&);
template absl::StatusOr<TFMessage> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const LaserScan&);
template absl::StatusOr<LaserScan> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const BatteryState&);
template absl::StatusOr<BatteryState> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const PointCloud2&);
template absl::StatusOr<PointCloud2> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Image&);
template absl::StatusOr<Image> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const CompressedImage&);
template absl::StatusOr<CompressedImage> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const CameraInfo&);
template absl::StatusOr<CameraInfo> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Odometry&);
template absl::StatusOr<Odometry> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const OccupancyGrid&);
template absl::StatusOr<OccupancyGrid> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const Path&);
template absl::StatusOr<Path> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const GoalStatusArray&);
template absl::StatusOr<GoalStatusArray> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const CancelGoalRequest&);
template absl::StatusOr<CancelGoalRequest> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const CancelGoalResponse&);
template absl::StatusOr<CancelGoalResponse> Decode(std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const NavigateToPoseSendGoalRequest&);
template absl::StatusOr<NavigateToPoseSendGoalRequest> Decode(
    std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const NavigateToPoseSendGoalResponse&);
template absl::StatusOr<NavigateToPoseSendGoalResponse> Decode(
    std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const NavigateToPoseGetResultRequest&);
template absl::StatusOr<NavigateToPoseGetResultRequest> Decode(
    std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const NavigateToPoseGetResultResponse&);
template absl::StatusOr<NavigateToPoseGetResultResponse> Decode(
    std::span<const uint8_t>);
template std::vector<uint8_t> Encode(const NavigateToPoseFeedbackMessage&);
template absl::StatusOr<NavigateToPoseFeedbackMessage> Decode(
    std::span<const uint8_t>);
template absl::StatusOr<PoseStamped> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<PoseWithCovarianceStamped> DecodeRos1(
    std::span<const uint8_t>);
template absl::StatusOr<TransformStamped> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<TFMessage> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<LaserScan> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<Image> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<CompressedImage> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<CameraInfo> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<Odometry> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<String> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<Bool> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<Float64> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<JointState> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<Imu> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<Twist> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<TwistStamped> DecodeRos1(std::span<const uint8_t>);
template absl::StatusOr<Log> DecodeRos1(std::span<const uint8_t>);

}  // namespace treeline::messages
