#include "nav_agent/calibration/calibration_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/calibration/parameters.h"

namespace treeline::calibration {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi;

Quantity At(int i) { return static_cast<Quantity>(i); }

std::string ValueText(Quantity quantity, double value) {
  switch (quantity) {
    case Quantity::kLaserYaw:
      return absl::StrFormat("%.2f deg", kDegPerRad * value);
    case Quantity::kLaserDelay:
      return absl::StrFormat("%.1f ms", 1000 * value);
    case Quantity::kLeftScale:
    case Quantity::kRightScale:
      return absl::StrFormat("x %.4f", value);
    default:
      return absl::StrFormat("%.4f m", value);
  }
}

std::string SigmaText(Quantity quantity, double sigma) {
  switch (quantity) {
    case Quantity::kLaserYaw:
      return absl::StrFormat("%.2f deg", kDegPerRad * sigma);
    case Quantity::kLaserDelay:
      return absl::StrFormat("%.1f ms", 1000 * sigma);
    case Quantity::kLeftScale:
    case Quantity::kRightScale:
      return absl::StrFormat("%.4f", sigma);
    default:
      return absl::StrFormat("%.4f m", sigma);
  }
}

std::string Rows(const Calibration& calibration) {
  std::string text = absl::StrFormat("%-12s %12s %12s  %s\n", "", "assumed",
                                     "found", "1 standard deviation");
  std::set<std::string> drives;
  for (int i = 0; i < kQuantities; ++i) {
    const Estimate& estimate = calibration.Of(At(i));
    const std::string assumed =
        ValueText(At(i), ValueOf(calibration.assumed, At(i)));
    if (estimate.is_known) {
      absl::StrAppendFormat(&text, "%-12s %12s %12s  %s\n", NameOf(At(i)),
                            assumed, ValueText(At(i), estimate.value),
                            SigmaText(At(i), estimate.sigma));
    } else {
      absl::StrAppendFormat(&text,
                            "%-12s %12s %12s  not observable in this "
                            "drive (would be %s)\n",
                            NameOf(At(i)), assumed, "-",
                            SigmaText(At(i), estimate.sigma));
      drives.insert(DriveFor(At(i)));
    }
  }
  for (const std::string& drive : drives) {
    absl::StrAppend(&text, "  to observe what is missing: ", drive, "\n");
  }
  return text;
}

void AddResiduals(const char* name, const Residuals& residuals,
                  std::string& text) {
  absl::StrAppendFormat(
      &text,
      "  %-10s %6.1f mm, %5.2f deg (rms), half below "
      "%5.1f mm, %5.2f deg\n",
      name, 1000 * residuals.rms_m, kDegPerRad * residuals.rms_rad,
      1000 * residuals.median_m, kDegPerRad * residuals.median_rad);
}

nlohmann::json ResidualsJson(const Residuals& residuals) {
  return {{"rms_m", residuals.rms_m},
          {"rms_rad", residuals.rms_rad},
          {"median_m", residuals.median_m},
          {"median_rad", residuals.median_rad}};
}

std::string Number(double value) { return absl::StrFormat("%.4f", value); }

std::string Uncertainty(Quantity quantity, const Calibration& calibration) {
  return absl::StrCat("+- ",
                      SigmaText(quantity, calibration.Of(quantity).sigma));
}

// Less than the least is not told.
std::string NoiseUncertainty(double share, double sigma) {
  return share > kNoiseFloor ? absl::StrFormat("+- %.4f", sigma) : "or less";
}

void AddNoise(const Calibration& calibration, const char* section,
              std::vector<FileEntry>& entries) {
  if (!calibration.noise) return;
  for (const auto& [name, value] : core::kNoiseKeys) {
    entries.push_back({section, name, Number(calibration.noise->noise.*value),
                       NoiseUncertainty(calibration.noise->noise.*value,
                                        calibration.noise->sigma.*value)});
  }
}

std::string CameraText(CameraQuantity quantity, double value) {
  switch (quantity) {
    case CameraQuantity::kX:
    case CameraQuantity::kY:
    case CameraQuantity::kZ:
      return absl::StrFormat("%.4f m", value);
    case CameraQuantity::kDelay:
      return absl::StrFormat("%.1f ms", 1000 * value);
    default:
      return absl::StrFormat("%.2f deg", kDegPerRad * value);
  }
}

std::string CameraUncertainty(CameraQuantity quantity,
                              const CameraCalibration& calibration) {
  return absl::StrCat("+- ",
                      CameraText(quantity, calibration.Of(quantity).sigma));
}

}  // namespace

std::string CalibrationTable(const Calibration& calibration) {
  std::string text = Rows(calibration);
  if (calibration.gyroscope) {
    const Gyroscope& gyroscope = *calibration.gyroscope;
    absl::StrAppendFormat(
        &text, "%-12s %12s %12s  %.4f; bias %.3f deg/s +- %.3f%s\n",
        "gyroscope", "x 1.0000",
        gyroscope.scale.is_known
            ? absl::StrFormat("x %.4f", gyroscope.scale.value)
            : "-",
        gyroscope.scale.sigma, kDegPerRad * gyroscope.bias_radps.value,
        kDegPerRad * gyroscope.bias_radps.sigma,
        gyroscope.scale.is_known ? "" : "; scale not observable");
  }
  absl::StrAppendFormat(
      &text,
      "\n%d stretches of the drive, %d with scans that match, %d of them "
      "outliers\nlaser by wheels beside laser by scans:\n",
      calibration.stretches, calibration.motions.size(), calibration.outliers);
  AddResiduals("before", calibration.before, text);
  AddResiduals("after", calibration.after, text);
  AddResiduals("held out", calibration.held_out, text);
  if (calibration.noise) {
    text += "odometry noise, calibrated, at most:";
    for (const auto& [name, value] : core::kNoiseKeys) {
      absl::StrAppendFormat(&text, "%s %s %.4f %s",
                            value == core::kNoiseKeys[0].value ? "" : ",", name,
                            calibration.noise->noise.*value,
                            NoiseUncertainty(calibration.noise->noise.*value,
                                             calibration.noise->sigma.*value));
    }
    text += "\n";
  } else {
    text +=
        "odometry noise: not observable in this drive; drive both straight "
        "ahead and turns\n";
  }
  return text;
}

std::string CalibrationJson(const Calibration& calibration) {
  nlohmann::json json;
  for (int i = 0; i < kQuantities; ++i) {
    const Estimate& estimate = calibration.Of(At(i));
    json["quantities"].push_back(
        {{"name", NameOf(At(i))},
         {"unit", UnitOf(At(i))},
         {"assumed", ValueOf(calibration.assumed, At(i))},
         {"value", estimate.value},
         {"sigma", estimate.sigma},
         {"known", estimate.is_known}});
  }
  json["covariance"] = calibration.covariance;
  if (calibration.gyroscope) {
    const Gyroscope& gyroscope = *calibration.gyroscope;
    json["gyroscope"] = {{"scale", gyroscope.scale.value},
                         {"scale_sigma", gyroscope.scale.sigma},
                         {"bias_radps", gyroscope.bias_radps.value},
                         {"bias_sigma_radps", gyroscope.bias_radps.sigma},
                         {"known", gyroscope.scale.is_known}};
  }
  if (calibration.noise) {
    for (const auto& [name, value] : core::kNoiseKeys) {
      json["noise"][name] = calibration.noise->noise.*value;
      json["noise_sigma"][name] = calibration.noise->sigma.*value;
    }
  }
  json["stretches"] = calibration.stretches;
  json["matched"] = calibration.motions.size();
  json["outliers"] = calibration.outliers;
  json["before"] = ResidualsJson(calibration.before);
  json["after"] = ResidualsJson(calibration.after);
  json["held_out"] = ResidualsJson(calibration.held_out);
  return json.dump(2);
}

std::vector<FileEntry> RobotFileEntries(const Calibration& calibration,
                                        double laser_z_m) {
  std::vector<FileEntry> entries;
  const auto add = [&](Quantity quantity, const char* section,
                       const char* key) {
    if (!calibration.Of(quantity).is_known) return;
    entries.push_back({section, key, Number(calibration.Of(quantity).value),
                       Uncertainty(quantity, calibration)});
  };
  add(Quantity::kTrack, "", "wheel_track_m");
  add(Quantity::kLeftScale, "odometry", "left_scale");
  add(Quantity::kRightScale, "odometry", "right_scale");
  add(Quantity::kLaserDelay, "odometry", "laser_delay_s");
  AddNoise(calibration, "odometry", entries);
  const Estimate& x = calibration.Of(Quantity::kLaserX);
  const Estimate& y = calibration.Of(Quantity::kLaserY);
  if (x.is_known || y.is_known) {
    entries.push_back(
        {"laser", "at",
         absl::StrCat("[", Number(x.value), ", ", Number(y.value), ", ",
                      Number(laser_z_m), "]"),
         Uncertainty(x.is_known ? Quantity::kLaserX : Quantity::kLaserY,
                     calibration)});
  }
  add(Quantity::kLaserYaw, "laser", "yaw_rad");
  return entries;
}

std::vector<FileEntry> HardwareFileEntries(const Calibration& calibration) {
  std::vector<FileEntry> entries;
  const std::pair<Quantity, const char*> keys[] = {
      {Quantity::kTrack, "wheel_track_m"},
      {Quantity::kLeftScale, "left_wheel_scale"},
      {Quantity::kRightScale, "right_wheel_scale"},
      {Quantity::kLaserDelay, "laser_delay_s"},
      {Quantity::kLaserX, "laser_x_m"},
      {Quantity::kLaserY, "laser_y_m"},
      {Quantity::kLaserYaw, "laser_yaw_rad"}};
  for (const auto& [quantity, key] : keys) {
    if (!calibration.Of(quantity).is_known) continue;
    entries.push_back({"", key, Number(calibration.Of(quantity).value),
                       Uncertainty(quantity, calibration)});
  }
  AddNoise(calibration, "", entries);
  return entries;
}

std::vector<FileEntry> RosFileEntries(const Calibration& calibration,
                                      double wheel_track_m, double laser_z_m) {
  std::vector<FileEntry> entries;
  for (const auto& [quantity, key] :
       {std::pair{Quantity::kLeftScale, "left_wheel_scale"},
        {Quantity::kRightScale, "right_wheel_scale"},
        {Quantity::kLaserDelay, "laser_delay_s"}}) {
    if (!calibration.Of(quantity).is_known) continue;
    entries.push_back({"", key, Number(calibration.Of(quantity).value),
                       Uncertainty(quantity, calibration)});
  }
  const Estimate& track = calibration.Of(Quantity::kTrack);
  if (track.is_known) {
    entries.push_back(
        {"", "turn_scale", Number(wheel_track_m / track.value),
         absl::StrFormat("+- %.4f", wheel_track_m * track.sigma /
                                        (track.value * track.value))});
  }
  AddNoise(calibration, "", entries);
  const Estimate& x = calibration.Of(Quantity::kLaserX);
  const Estimate& y = calibration.Of(Quantity::kLaserY);
  const Estimate& yaw = calibration.Of(Quantity::kLaserYaw);
  if (x.is_known || y.is_known || yaw.is_known) {
    entries.push_back(
        {"", "base_from_laser",
         absl::StrCat("[", Number(x.value), ", ", Number(y.value), ", ",
                      Number(laser_z_m), ", ", Number(yaw.value), "]"),
         Uncertainty(x.is_known ? Quantity::kLaserX : Quantity::kLaserYaw,
                     calibration)});
  }
  return entries;
}

std::string CameraTable(const CameraCalibration& calibration) {
  std::string text;
  std::set<std::string> drives;
  for (int i = 0; i < kCameraQuantities; ++i) {
    const auto quantity = static_cast<CameraQuantity>(i);
    const Estimate& estimate = calibration.Of(quantity);
    const std::string assumed =
        CameraText(quantity, calibration.assumed[static_cast<size_t>(i)]);
    const std::string sigma = CameraText(quantity, estimate.sigma);
    absl::StrAppendFormat(
        &text, "%-12s %12s %12s  %s\n", NameOf(quantity), assumed,
        estimate.is_known ? CameraText(quantity, estimate.value) : "-",
        estimate.is_known
            ? sigma
            : absl::StrCat("not observable in this drive (would be ", sigma,
                           ")"));
    if (!estimate.is_known) drives.insert(DriveFor(quantity));
  }
  for (const std::string& drive : drives) {
    absl::StrAppend(&text, "  to observe what is missing: ", drive, "\n");
  }
  absl::StrAppendFormat(&text,
                        "%d stretches with pictures, %d of them outliers\n",
                        calibration.stretches, calibration.outliers);
  AddResiduals("before", calibration.before, text);
  AddResiduals("after", calibration.after, text);
  return text;
}

std::vector<FileEntry> CameraFileEntries(const CameraCalibration& calibration) {
  std::vector<FileEntry> entries;
  const Estimate& x = calibration.Of(CameraQuantity::kX);
  const Estimate& y = calibration.Of(CameraQuantity::kY);
  const Estimate& z = calibration.Of(CameraQuantity::kZ);
  if (x.is_known || y.is_known || z.is_known) {
    entries.push_back({"camera", "at",
                       absl::StrCat("[", Number(x.value), ", ", Number(y.value),
                                    ", ", Number(z.value), "]"),
                       CameraUncertainty(CameraQuantity::kX, calibration)});
  }
  for (const auto& [quantity, key] :
       {std::pair{CameraQuantity::kYaw, "yaw_rad"},
        {CameraQuantity::kDown, "down_rad"}}) {
    const Estimate& estimate = calibration.Of(quantity);
    if (!estimate.is_known) continue;
    entries.push_back({"camera", key, Number(estimate.value),
                       CameraUncertainty(quantity, calibration)});
  }
  const Estimate& delay = calibration.Of(CameraQuantity::kDelay);
  if (delay.is_known) {
    entries.push_back({"odometry", "camera_delay_s", Number(delay.value),
                       CameraUncertainty(CameraQuantity::kDelay, calibration)});
  }
  return entries;
}

std::vector<FileEntry> CameraHardwareEntries(
    const CameraCalibration& calibration) {
  std::vector<FileEntry> entries;
  const std::pair<CameraQuantity, const char*> keys[] = {
      {CameraQuantity::kX, "camera_x_m"},
      {CameraQuantity::kY, "camera_y_m"},
      {CameraQuantity::kZ, "camera_z_m"},
      {CameraQuantity::kDown, "camera_down_rad"},
      {CameraQuantity::kDelay, "camera_delay_s"}};
  for (const auto& [quantity, key] : keys) {
    const Estimate& estimate = calibration.Of(quantity);
    if (!estimate.is_known) continue;
    entries.push_back({"", key, Number(estimate.value),
                       CameraUncertainty(quantity, calibration)});
  }
  return entries;
}

std::vector<FileEntry> CameraRosEntries(const CameraCalibration& calibration) {
  std::vector<FileEntry> entries;
  const bool is_found =
      std::ranges::any_of(calibration.estimates, [&](const Estimate& estimate) {
        return estimate.is_known &&
               &estimate != &calibration.Of(CameraQuantity::kDelay);
      });
  if (is_found) {
    const geometry::Rigid3 camera = calibration.BaseFromCamera();
    const geometry::Rotation3& q = camera.rotation;
    entries.push_back(
        {"", "base_from_camera",
         absl::StrCat("[", Number(camera.translation.x), ", ",
                      Number(camera.translation.y), ", ",
                      Number(camera.translation.z), ", ", Number(q.x), ", ",
                      Number(q.y), ", ", Number(q.z), ", ", Number(q.w), "]"),
         CameraUncertainty(CameraQuantity::kX, calibration)});
  }
  const Estimate& delay = calibration.Of(CameraQuantity::kDelay);
  if (delay.is_known) {
    entries.push_back({"", "camera_delay_s", Number(delay.value),
                       CameraUncertainty(CameraQuantity::kDelay, calibration)});
  }
  return entries;
}

std::string EntriesYaml(const std::vector<FileEntry>& entries,
                        const std::string& title) {
  std::string text = absl::StrCat("# ", title, "\n");
  std::string section;
  for (const FileEntry& entry : entries) {
    if (entry.section != section) {
      section = entry.section;
      if (!section.empty()) absl::StrAppend(&text, section, ":\n");
    }
    absl::StrAppendFormat(&text, "%s%s: %s  # %s\n",
                          section.empty() ? "" : "  ", entry.key, entry.value,
                          entry.uncertainty);
  }
  return text;
}

}  // namespace treeline::calibration
