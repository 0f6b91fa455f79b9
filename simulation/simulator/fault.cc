#include "simulation/simulator/fault.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace treeline::simulator {
namespace {

constexpr const char* kTargets[] = {"laser",  "camera",     "odometry",
                                    "base",   "left_wheel", "right_wheel",
                                    "server", "rear_laser"};
constexpr const char* kKinds[] = {"silent",       "frozen", "invalid", "dark",
                                  "stamp_offset", "delay",  "stuck",   "slip"};

bool Exists(FaultTarget target, FaultKind kind) {
  switch (target) {
    case FaultTarget::kLaser:
    case FaultTarget::kRearLaser:
      return kind <= FaultKind::kDelay && kind != FaultKind::kDark;
    case FaultTarget::kCamera:
      return kind <= FaultKind::kDelay;
    case FaultTarget::kOdometry:
      return kind <= FaultKind::kDelay && kind != FaultKind::kDark &&
             kind != FaultKind::kInvalid;
    case FaultTarget::kBase:
    case FaultTarget::kServer:
      return kind == FaultKind::kSilent;
    case FaultTarget::kLeftWheel:
    case FaultTarget::kRightWheel:
      return kind >= FaultKind::kStuck;
  }
  return false;
}

const char* NameOf(FaultTarget target) {
  return kTargets[static_cast<size_t>(target)];
}
const char* NameOf(FaultKind kind) { return kKinds[static_cast<size_t>(kind)]; }

}  // namespace

absl::Status Fault::Validate() const {
  if (!Exists(target, kind)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "there is no fault '", NameOf(kind), "' of '", NameOf(target), "'"));
  }
  if (duration <= SimTime(0) || start < SimTime(0)) {
    return absl::InvalidArgumentError(
        absl::StrCat(Name(), ": it must begin at 0 or later and last a while"));
  }
  const bool in_seconds =
      kind == FaultKind::kStampOffset || kind == FaultKind::kDelay;
  const double least = kind == FaultKind::kStampOffset ? -3600 : 0;
  const double most = in_seconds ? 3600 : 1;
  if (!(amount >= least && amount <= most)) {
    return absl::InvalidArgumentError(
        absl::StrCat(Name(), ": the amount must be from ", least, " to ", most,
                     in_seconds ? " s" : ""));
  }
  return absl::OkStatus();
}

std::string Fault::Name() const {
  std::string name = absl::StrCat(NameOf(target), " ", NameOf(kind));
  if (kind == FaultKind::kInvalid || kind == FaultKind::kSlip ||
      kind == FaultKind::kStampOffset || kind == FaultKind::kDelay) {
    absl::StrAppend(&name, " ", amount);
  }
  return name;
}

absl::StatusOr<FaultTarget> ParseFaultTarget(absl::string_view name) {
  const auto* found = std::find(std::begin(kTargets), std::end(kTargets), name);
  if (found == std::end(kTargets)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "'", name, "' is none of ", absl::StrJoin(kTargets, ", ")));
  }
  return static_cast<FaultTarget>(found - std::begin(kTargets));
}

absl::StatusOr<FaultKind> ParseFaultKind(absl::string_view name) {
  const auto* found = std::find(std::begin(kKinds), std::end(kKinds), name);
  if (found == std::end(kKinds)) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", name, "' is none of ", absl::StrJoin(kKinds, ", ")));
  }
  return static_cast<FaultKind>(found - std::begin(kKinds));
}

absl::Status FaultPlan::Add(const Fault& fault) {
  const absl::Status valid = fault.Validate();
  if (valid.ok()) faults_.push_back(fault);
  return valid;
}

void FaultPlan::End(FaultTarget target, SimTime now) {
  std::erase_if(faults_, [&](const Fault& fault) {
    return fault.target == target && fault.start >= now;
  });
  for (Fault& fault : faults_) {
    if (fault.target == target && fault.IsActiveAt(now)) {
      fault.duration = now - fault.start;
    }
  }
}

const Fault* FaultPlan::Find(FaultTarget target, FaultKind kind,
                             SimTime time) const {
  for (const Fault& fault : faults_) {
    if (fault.target == target && fault.kind == kind &&
        fault.IsActiveAt(time)) {
      return &fault;
    }
  }
  return nullptr;
}

WheelFaults FaultPlan::WheelsAt(SimTime time) const {
  const auto slip = [&](FaultTarget wheel) {
    const Fault* fault = Find(wheel, FaultKind::kSlip, time);
    return fault == nullptr ? 0 : fault->amount;
  };
  return {.left_stuck = Has(FaultTarget::kLeftWheel, FaultKind::kStuck, time),
          .right_stuck = Has(FaultTarget::kRightWheel, FaultKind::kStuck, time),
          .left_slip = slip(FaultTarget::kLeftWheel),
          .right_slip = slip(FaultTarget::kRightWheel)};
}

std::vector<Fault> FaultPlan::Began(SimTime after, SimTime until) const {
  std::vector<Fault> began;
  for (const Fault& fault : faults_) {
    if (fault.start > after && fault.start <= until) began.push_back(fault);
  }
  return began;
}

std::vector<Fault> FaultPlan::Ended(SimTime after, SimTime until) const {
  std::vector<Fault> ended;
  for (const Fault& fault : faults_) {
    if (fault.duration == SimTime::max()) continue;
    const SimTime end = fault.start + fault.duration;
    if (end > after && end <= until) ended.push_back(fault);
  }
  return ended;
}

}  // namespace treeline::simulator
