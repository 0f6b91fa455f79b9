#include "nav_agent/recording/log_payload.h"

#include <array>
#include <bit>
#include <chrono>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

namespace treeline::recording {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written as they lie in memory");

enum Kind : uint16_t {
  kInformation = 1,
  kRangeSensorInfo = 2,
  kCalibration = 3,
  kRobotModel = 4,
  kScan = 16,
  kBaseReading = 17,
  kFrame = 18,
  kTruePose = 19,
  kEvent = 20,
  kCommand = 21
};

int64_t NanosecondsOf(base::MonotonicTime stamp) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             stamp.time_since_epoch())
      .count();
}
base::MonotonicTime StampOf(int64_t stamp_ns) {
  return base::MonotonicTime(
      std::chrono::duration_cast<base::MonotonicTime::duration>(
          std::chrono::nanoseconds(stamp_ns)));
}

class Writer {
 public:
  template <typename T>
  void Number(T value) {
    static_assert(std::is_arithmetic_v<T>);
    Raw(&value, sizeof(value));
  }
  template <typename T>
  void Array(const std::vector<T>& values) {
    Number(static_cast<uint32_t>(values.size()));
    Raw(values.data(), sizeof(T) * values.size());
  }
  void Text(absl::string_view text) {
    Number(static_cast<uint32_t>(text.size()));
    bytes.append(text.data(), text.size());
  }
  void Rigid(const geometry::Rigid3& a) {
    for (const double value :
         {a.rotation.w, a.rotation.x, a.rotation.y, a.rotation.z,
          a.translation.x, a.translation.y, a.translation.z}) {
      Number(value);
    }
  }

  std::string bytes;

 private:
  void Raw(const void* data, size_t size) {
    if (size > 0) bytes.append(static_cast<const char*>(data), size);
  }
};

// Reads what Writer wrote; is_good() is false once something was missing.
class Reader {
 public:
  explicit Reader(absl::string_view bytes) : rest_(bytes) {}

  template <typename T>
  T Number() {
    T value{};
    Raw(&value, sizeof(value));
    return value;
  }
  template <typename T>
  std::vector<T> Array() {
    const uint64_t count = Number<uint32_t>();
    if (!is_good_ || count * sizeof(T) > rest_.size()) {
      is_good_ = false;
      return {};
    }
    std::vector<T> values(static_cast<size_t>(count));
    Raw(values.data(), sizeof(T) * values.size());
    return values;
  }
  std::string Text() {
    const size_t size = Number<uint32_t>();
    if (!is_good_ || size > rest_.size()) {
      is_good_ = false;
      return {};
    }
    std::string text(rest_.substr(0, size));
    rest_.remove_prefix(size);
    return text;
  }
  geometry::Rigid3 Rigid() {
    geometry::Rigid3 a;
    for (double* value :
         {&a.rotation.w, &a.rotation.x, &a.rotation.y, &a.rotation.z,
          &a.translation.x, &a.translation.y, &a.translation.z}) {
      *value = Number<double>();
    }
    if (!geometry::IsFinite(a)) is_good_ = false;
    return a;
  }
  bool is_good() const { return is_good_; }

 private:
  void Raw(void* data, size_t size) {
    if (!is_good_ || size > rest_.size()) {
      is_good_ = false;
      return;
    }
    if (size > 0) std::memcpy(data, rest_.data(), size);
    rest_.remove_prefix(size);
  }

  absl::string_view rest_;
  bool is_good_ = true;
};

// The numbers of a robot model, in the format's order.
template <typename Model>
auto NumbersOf(Model& robot) {
  return std::array{&robot.front_m,
                    &robot.rear_m,
                    &robot.half_width_m,
                    &robot.height_m,
                    &robot.ground_clearance_m,
                    &robot.wheel_track_m,
                    &robot.wheel_radius_m,
                    &robot.caster_m,
                    &robot.max_step_m,
                    &robot.max_slope_rad,
                    &robot.max_forward_mps,
                    &robot.max_backward_mps,
                    &robot.max_yaw_rate_radps,
                    &robot.max_acceleration_mps2,
                    &robot.max_deceleration_mps2,
                    &robot.max_yaw_acceleration_radps2};
}

template <typename Reading>
auto NumbersOfReading(Reading& reading) {
  return std::array{
      &reading.left_wheel_m,     &reading.right_wheel_m,   &reading.forward_mps,
      &reading.yaw_rate_radps,   &reading.pitch_rad,       &reading.roll_rad,
      &reading.pitch_rate_radps, &reading.roll_rate_radps, &reading.battery_v};
}

struct Encoder {
  LogPayload operator()(const LogInformation& a) const {
    return {kInformation, 0, a.text};
  }
  LogPayload operator()(const core::RangeSensorInfo& a) const {
    Writer out;
    out.Number(a.angle_min_rad);
    out.Number(a.angle_increment_rad);
    out.Number(static_cast<int32_t>(a.beams));
    out.Number(a.range_min_m);
    out.Number(a.range_max_m);
    out.Number(a.beam_interval_s);
    out.Number(a.scan_interval_s);
    return {kRangeSensorInfo, 0, std::move(out.bytes)};
  }
  LogPayload operator()(const camera::RgbdCalibration& a) const {
    Writer out;
    for (const camera::Camera* camera : {&a.color, &a.depth}) {
      out.Number(static_cast<int32_t>(camera->width()));
      out.Number(static_cast<int32_t>(camera->height()));
      out.Text(camera::CameraModelName(camera->model()));
      for (const double value : camera->parameters()) out.Number(value);
    }
    out.Rigid(a.color_from_depth);
    out.Number(a.depth_scale);
    out.Number(static_cast<uint8_t>(a.pose_sensor));
    return {kCalibration, 0, std::move(out.bytes)};
  }
  LogPayload operator()(const core::RobotModel& a) const {
    Writer out;
    for (const double* value : NumbersOf(a)) out.Number(*value);
    out.Rigid(a.base_from_laser);
    out.Rigid(a.base_from_camera);
    return {kRobotModel, 0, std::move(out.bytes)};
  }
  LogPayload operator()(const core::LaserScan& a) const {
    Writer out;
    out.Array(a.ranges_m);
    out.Array(a.intensities);
    return {kScan, NanosecondsOf(a.stamp), std::move(out.bytes)};
  }
  LogPayload operator()(const core::BaseReading& a) const {
    Writer out;
    for (const double* value : NumbersOfReading(a)) out.Number(*value);
    out.Number(static_cast<uint8_t>(a.motors_enabled ? 1 : 0));
    return {kBaseReading, NanosecondsOf(a.stamp), std::move(out.bytes)};
  }
  LogPayload operator()(const LogFrame& a) const {
    Writer out;
    out.Number(a.sequence);
    out.Number(a.depth_unit_m);
    out.Text(a.color);
    out.Text(a.depth);
    return {kFrame, NanosecondsOf(a.stamp), std::move(out.bytes)};
  }
  LogPayload operator()(const LogTruePose& a) const {
    Writer out;
    out.Rigid(a.world_from_base);
    return {kTruePose, NanosecondsOf(a.stamp), std::move(out.bytes)};
  }
  LogPayload operator()(const LogEvent& a) const {
    return {kEvent, NanosecondsOf(a.stamp), a.text};
  }
  LogPayload operator()(const LogCommand& a) const {
    Writer out;
    out.Number(a.command.forward_mps);
    out.Number(a.command.yaw_rate_radps);
    return {kCommand, NanosecondsOf(a.stamp), std::move(out.bytes)};
  }
};

core::RangeSensorInfo ReadRangeSensorInfo(Reader& in) {
  core::RangeSensorInfo info;
  info.angle_min_rad = in.Number<double>();
  info.angle_increment_rad = in.Number<double>();
  info.beams = in.Number<int32_t>();
  info.range_min_m = in.Number<double>();
  info.range_max_m = in.Number<double>();
  info.beam_interval_s = in.Number<double>();
  info.scan_interval_s = in.Number<double>();
  return info;
}

std::optional<camera::Camera> ReadCamera(Reader& in) {
  const int width = in.Number<int32_t>();
  const int height = in.Number<int32_t>();
  const std::string name = in.Text();
  std::array<double, camera::Camera::kMaxParameters> parameters{};
  for (double& value : parameters) value = in.Number<double>();
  const auto model = camera::ParseCameraModel(name);
  if (!in.is_good() || !model.ok()) return std::nullopt;
  const auto camera =
      camera::Camera::Create(*model, width, height, parameters.data(),
                             camera::CameraParameterCount(*model));
  return camera.ok() ? std::optional(*camera) : std::nullopt;
}

std::optional<LogEntry> ReadCalibration(Reader& in) {
  const auto color = ReadCamera(in);
  const auto depth = ReadCamera(in);
  if (!color.has_value() || !depth.has_value()) return std::nullopt;
  camera::RgbdCalibration calibration;
  calibration.color = *color;
  calibration.depth = *depth;
  calibration.color_from_depth = in.Rigid();
  calibration.depth_scale = in.Number<double>();
  const uint8_t sensor = in.Number<uint8_t>();
  if (sensor > 1) return std::nullopt;
  calibration.pose_sensor = static_cast<camera::RgbdSensor>(sensor);
  return calibration;
}

core::RobotModel ReadRobotModel(Reader& in) {
  core::RobotModel robot;
  for (double* value : NumbersOf(robot)) *value = in.Number<double>();
  robot.base_from_laser = in.Rigid();
  robot.base_from_camera = in.Rigid();
  return robot;
}

core::LaserScan ReadScan(Reader& in, int64_t stamp_ns) {
  core::LaserScan scan;
  scan.stamp = StampOf(stamp_ns);
  scan.ranges_m = in.Array<float>();
  scan.intensities = in.Array<uint16_t>();
  return scan;
}

core::BaseReading ReadBaseReading(Reader& in, int64_t stamp_ns) {
  core::BaseReading reading;
  reading.stamp = StampOf(stamp_ns);
  for (double* value : NumbersOfReading(reading)) *value = in.Number<double>();
  reading.motors_enabled = in.Number<uint8_t>() != 0;
  return reading;
}

LogFrame ReadFrame(Reader& in, int64_t stamp_ns) {
  LogFrame frame;
  frame.stamp = StampOf(stamp_ns);
  frame.sequence = in.Number<int64_t>();
  frame.depth_unit_m = in.Number<double>();
  frame.color = in.Text();
  frame.depth = in.Text();
  return frame;
}

std::optional<LogEntry> Read(Reader& in, uint16_t kind, int64_t stamp_ns) {
  switch (kind) {
    case kRangeSensorInfo:
      return ReadRangeSensorInfo(in);
    case kCalibration:
      return ReadCalibration(in);
    case kRobotModel:
      return ReadRobotModel(in);
    case kScan:
      return ReadScan(in, stamp_ns);
    case kBaseReading:
      return ReadBaseReading(in, stamp_ns);
    case kFrame:
      return ReadFrame(in, stamp_ns);
    case kTruePose:
      return LogTruePose{StampOf(stamp_ns), in.Rigid()};
    case kCommand: {
      const double forward_mps = in.Number<double>();
      return LogCommand{StampOf(stamp_ns), {forward_mps, in.Number<double>()}};
    }
    default:
      return std::nullopt;
  }
}

}  // namespace

LogPayload EncodeLogPayload(const LogEntry& entry) {
  return std::visit(Encoder{}, entry);
}

std::optional<LogEntry> DecodeLogPayload(uint16_t kind, int64_t stamp_ns,
                                         absl::string_view bytes) {
  if (kind == kInformation) return LogInformation{std::string(bytes)};
  if (kind == kEvent) return LogEvent{StampOf(stamp_ns), std::string(bytes)};
  Reader in(bytes);
  std::optional<LogEntry> entry = Read(in, kind, stamp_ns);
  return in.is_good() ? entry : std::nullopt;
}

}  // namespace treeline::recording
