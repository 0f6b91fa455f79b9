#include "server/core/training/pose_convention.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>

#include "absl/strings/str_format.h"
#include "common/base/parallel_for.h"
#include "common/base/random.h"

namespace treeline::training {
namespace {

using geometry::Rigid3;
using geometry::Rotation3;

// Each frame is compared with those so many frames on: near enough to see the
// same, far enough for the poses to matter.
constexpr std::array<size_t, 3> kSteps = {1, 3, 7};
constexpr int kPointsPerPair = 200;
// Depths meet that differ by less than this share.
constexpr double kTolerance = 0.03;
constexpr double kNearest_m = 0.05;

// Another reading is named if at least this share meets under it, and so many
// times as much as under the one that was taken. Where the camera mostly turns,
// wrong units meet nearly as often as right ones.
constexpr double kMinAgreement = 0.3;
constexpr double kMinGain = 2;
constexpr double kMinUnitGain = 1.5;
// With another unit so many times as much as with no positions at all: of a
// camera that mostly turns, and whose positions are noisy, any unit that leaves
// little of them fits better.
constexpr double kMinPositionGain = 1.08;

struct Reading {
  const char* text;
  const char* remedy;
  // The pose that was meant, by the one that was read.
  std::function<Rigid3(const Rigid3&)> meant;
  // Metres per metre of the depth that was read.
  double depth_scale = 1;
};

// Of OpenGL's camera axes (x right, y up, z backwards).
Rigid3 FromOpenGl(const Rigid3& pose) {
  return pose * Rigid3{Rotation3{.w = 0, .x = 1, .y = 0, .z = 0}, {}};
}

// Of x right, y up, z forward, of the camera and of the world.
Rigid3 FromLeftHanded(const Rigid3& pose) {
  const Rotation3& q = pose.rotation;
  const geometry::Vec3& t = pose.translation;
  return {Rotation3{.w = q.w, .x = -q.x, .y = q.y, .z = -q.z},
          {t.x, -t.y, t.z}};
}

Rigid3 WithoutPosition(const Rigid3& pose) { return {pose.rotation, {}}; }

// Of w, x, y, z that were read as x, y, z, w, and the other way round.
Rigid3 FromWFirst(const Rigid3& pose) {
  const Rotation3& q = pose.rotation;
  return {Rotation3{.w = q.x, .x = q.y, .y = q.z, .z = q.w}, pose.translation};
}
Rigid3 FromWLast(const Rigid3& pose) {
  const Rotation3& q = pose.rotation;
  return {Rotation3{.w = q.z, .x = q.w, .y = q.x, .z = q.y}, pose.translation};
}

const std::vector<Reading>& OtherReadings() {
  static const auto& readings = *new std::vector<Reading>{
      {"the poses were the inverse of what is read", "invert them",
       [](const Rigid3& p) { return p.Inverse(); }},
      {"the camera's axes were OpenGL's (y up, z backwards)",
       "turn them to x right, y down, z forward", FromOpenGl},
      {"the axes were left-handed, as Unity's are (y up, z forward)",
       "mirror positions and rotations in y", FromLeftHanded},
      {"the poses were the inverse of what is read, with OpenGL's axes",
       "invert them, and turn the axes to x right, y down, z forward",
       [](const Rigid3& p) { return FromOpenGl(p.Inverse()); }},
      {"quaternions were qw qx qy qz, and are read as qx qy qz qw",
       "put qw last", FromWFirst},
      {"quaternions were qx qy qz qw, and are read as qw qx qy qz",
       "put qw first", FromWLast},
      {"the poses were the inverse of what is read, with quaternions qw qx "
       "qy qz that are read as qx qy qz qw",
       "invert them, and put qw last",
       [](const Rigid3& p) { return FromWFirst(p).Inverse(); }},
      {"the poses were the inverse of what is read, with quaternions qx qy "
       "qz qw that are read as qw qx qy qz",
       "invert them, and put qw first",
       [](const Rigid3& p) { return FromWLast(p).Inverse(); }},
      {"depth were 5 times as large",
       "give a --depth-unit 5 times as large, or positions in metres if they "
       "are not",
       nullptr, 5},
      {"depth were a fifth as large",
       "give a --depth-unit a fifth as large, or positions in metres if they "
       "are not",
       nullptr, 1.0 / 5},
      {"depth were 10 times as large",
       "give a --depth-unit 10 times as large, or positions in metres if they "
       "are not",
       nullptr, 10},
      {"depth were a tenth as large",
       "give a --depth-unit a tenth as large, or positions in metres if they "
       "are not",
       nullptr, 1.0 / 10},
      {"positions were in centimetres", "give metres", nullptr, 100},
      {"positions were in millimetres", "give metres", nullptr, 1000},
  };
  return readings;
}

// Compares the depth of pairs of frames under one reading of their poses.
class Agreement {
 public:
  Agreement(const std::vector<PosedDepth>& frames,
            const camera::RgbdCalibration& calibration, int threads)
      : frames_(frames), calibration_(calibration) {
    samples_.resize(frames.size());
    base::ParallelFor(static_cast<int64_t>(frames.size()), threads,
                      [&](int64_t i) { Draw(static_cast<size_t>(i)); });
  }

  double Of(const Reading& reading, int threads) const {
    std::vector<Rigid3> world_from_depth;
    for (const PosedDepth& frame : frames_) {
      const Rigid3 pose = reading.meant ? reading.meant(frame.world_from_sensor)
                                        : frame.world_from_sensor;
      world_from_depth.push_back(calibration_.pose_sensor ==
                                         camera::RgbdSensor::kColor
                                     ? pose * calibration_.color_from_depth
                                     : pose);
    }
    std::vector<int> met(frames_.size(), 0);
    std::vector<int> carried(frames_.size(), 0);
    base::ParallelFor(
        static_cast<int64_t>(frames_.size()), threads, [&](int64_t number) {
          const size_t i = static_cast<size_t>(number);
          for (const size_t step : kSteps) {
            const size_t j = i + step;
            if (j >= frames_.size()) break;
            carried[i] += static_cast<int>(samples_[i].size());
            met[i] +=
                Met(i, j, world_from_depth[j].Inverse() * world_from_depth[i],
                    reading.depth_scale);
          }
        });
    const int all = std::reduce(carried.begin(), carried.end());
    return all == 0
               ? 0
               : static_cast<double>(std::reduce(met.begin(), met.end())) / all;
  }

 private:
  // A point of a frame (m), in its depth camera's frame, as read.
  void Draw(size_t frame) {
    const image::DepthImage& depth = frames_[frame].depth;
    if (depth.values.empty()) return;
    base::Random random(/*seed=*/0, /*stream=*/frame);
    for (int attempt = 0; attempt < kPointsPerPair; ++attempt) {
      const uint32_t pixel =
          random.NextBelow(static_cast<uint32_t>(depth.values.size()));
      const uint16_t value = depth.values[pixel];
      if (!image::IsMeasured(value)) continue;
      const uint32_t width = static_cast<uint32_t>(depth.width);
      const auto ray =
          calibration_.depth.Unproject({static_cast<double>(pixel % width),
                                        static_cast<double>(pixel / width)});
      if (!ray) continue;
      const double z = value * depth.unit_m * calibration_.depth_scale;
      samples_[frame].push_back({ray->x * z, ray->y * z, z});
    }
  }

  int Met(size_t from, size_t to, const Rigid3& to_from, double scale) const {
    const image::DepthImage& depth = frames_[to].depth;
    int met = 0;
    for (const geometry::Vec3& point : samples_[from]) {
      const geometry::Vec3 moved = to_from * (scale * point);
      if (moved.z < kNearest_m) continue;
      const camera::Pixel p = calibration_.depth.Project(moved);
      // Not so if it is NaN.
      if (!(p.x > -0.5 && p.y > -0.5 && p.x < depth.width - 0.5 &&
            p.y < depth.height - 0.5)) {
        continue;
      }
      const size_t pixel = static_cast<size_t>(std::lround(p.y)) *
                               static_cast<size_t>(depth.width) +
                           static_cast<size_t>(std::lround(p.x));
      const uint16_t value = depth.values[pixel];
      if (!image::IsMeasured(value)) continue;
      const double z = scale * value * depth.unit_m * calibration_.depth_scale;
      met += std::abs(moved.z - z) < kTolerance * z;
    }
    return met;
  }

  const std::vector<PosedDepth>& frames_;
  const camera::RgbdCalibration& calibration_;
  std::vector<std::vector<geometry::Vec3>> samples_;  // frame by frame
};

}  // namespace

std::optional<OtherConvention> FindOtherConvention(
    const std::vector<PosedDepth>& frames,
    const camera::RgbdCalibration& calibration, int threads) {
  const Agreement agreement(frames, calibration, threads);
  OtherConvention found;
  found.agreement_as_read = agreement.Of({}, threads);
  const double by_turning = agreement.Of({"", "", WithoutPosition}, threads);
  for (const Reading& reading : OtherReadings()) {
    const double share = agreement.Of(reading, threads);
    const double gain = reading.meant ? kMinGain : kMinUnitGain;
    if (share < std::max(kMinAgreement, gain * found.agreement_as_read) ||
        share <= found.agreement ||
        (!reading.meant && share < kMinPositionGain * by_turning)) {
      continue;
    }
    found.agreement = share;
    found.reading = reading.text;
    found.remedy = reading.remedy;
  }
  if (found.reading.empty()) return std::nullopt;
  return found;
}

absl::Status ConventionError(const std::string& name,
                             const OtherConvention& other) {
  return absl::FailedPreconditionError(absl::StrFormat(
      "%s: poses and depth do not fit together: of the depth that they carry "
      "into another frame, %.0f %% meets what was measured there. It would be "
      "%.0f %% if %s: %s. docs/frames.md says what is expected",
      name, 100 * other.agreement_as_read, 100 * other.agreement, other.reading,
      other.remedy));
}

}  // namespace treeline::training
