// A tuned or derived constant with what a reader must know of it.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace treeline::base {

// Where a parameter's value comes from.
enum class ParameterOrigin {
  kGeometry,  // of the robot, its sensors or a grid
  kPhysics,   // a law, or a limit of the hardware
  kMeasured,  // noise or time that was measured; `why` says where
  kTuned,     // chosen by trial; `why` says on what
};

// One constant: reads like a number, and prints itself. Each folder keeps its
// own in its parameters.h, in one table that `--print-config` prints and from
// which docs/reference/parameters.md is generated.
//
//   inline constexpr Parameter<double> kStandstillSpeed{
//       .name = "standstill_speed", .value = 0.02, .unit = "m/s",
//       .origin = ParameterOrigin::kMeasured,
//       .why = "twice the resolution of the wheel encoders"};
template <typename T>
struct Parameter {
  const char* name;  // snake_case, without its unit
  T value;
  const char* unit;  // SI; "" for a number or a ratio
  ParameterOrigin origin;
  const char* why;  // one line

  // NOLINTNEXTLINE(google-explicit-constructor): reads like its value.
  constexpr operator T() const { return value; }
};

// A row of a folder's table.
struct ParameterRow {
  std::string_view name;
  std::string value;
  std::string_view unit;
  ParameterOrigin origin;
  std::string_view why;
};

template <typename T>
ParameterRow RowOf(const Parameter<T>& parameter) {
  std::string value = std::to_string(parameter.value);
  if (value.find('.') != std::string::npos) {
    value.erase(value.find_last_not_of('0') + 1);
    if (value.back() == '.') value.pop_back();
  }
  return {parameter.name, value, parameter.unit, parameter.origin,
          parameter.why};
}

}  // namespace treeline::base
