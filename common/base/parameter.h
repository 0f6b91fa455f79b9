// A tuned or derived constant with what a reader must know of it.
#ifndef COMMON_BASE_PARAMETER_H_
#define COMMON_BASE_PARAMETER_H_

#include <charconv>
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

// The value as short as it can be without changing when it is read again.
template <typename T>
ParameterRow RowOf(const Parameter<T>& parameter) {
  char digits[32];
  const std::to_chars_result end =
      std::to_chars(digits, digits + sizeof(digits), parameter.value);
  return {parameter.name, std::string(digits, end.ptr), parameter.unit,
          parameter.origin, parameter.why};
}

}  // namespace treeline::base

#endif  // COMMON_BASE_PARAMETER_H_
