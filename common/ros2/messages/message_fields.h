// How a message names its fields, once for all that is made of them.
//
// A message is a plain struct with the fields of the public definition (.msg)
// in their order and under their names and units. It has
//   static constexpr char kName[]     its name in ROS 2, "std_msgs/msg/Header"
//   static constexpr auto Fields()    a tuple of Field, in the same order.
#ifndef COMMON_ROS2_MESSAGES_MESSAGE_FIELDS_H_
#define COMMON_ROS2_MESSAGES_MESSAGE_FIELDS_H_

#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace treeline::messages {

template <typename M, typename T>
struct Field {
  const char* name;
  T M::*member;
};

template <typename M, typename T>
constexpr Field<M, T> Named(const char* name, T M::*member) {
  return {name, member};
}

template <typename T>
concept Message = requires {
  T::kName;
  T::Fields();
};

// What an array or sequence is of; void for all else.
template <typename T>
struct Elements {
  using Type = void;
};
template <typename T>
struct Elements<std::vector<T>> {
  using Type = T;
};
template <typename T, size_t kCount>
struct Elements<std::array<T, kCount>> {
  using Type = T;
};
template <typename T>
inline constexpr bool kIsArray =
    !std::is_void_v<typename Elements<T>::Type> && requires {
  std::tuple_size<T>::value;
};
template <typename T>
inline constexpr bool kIsSequence =
    !std::is_void_v<typename Elements<T>::Type> && !kIsArray<T>;

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_MESSAGE_FIELDS_H_
