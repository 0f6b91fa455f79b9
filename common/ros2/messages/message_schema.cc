#include "common/ros2/messages/message_schema.h"

#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::messages {
namespace {

// "std_msgs/msg/Header" -> "std_msgs/Header".
std::string ShortName(absl::string_view name) {
  const size_t first = name.find('/');
  const size_t last = name.rfind('/');
  return absl::StrCat(name.substr(0, first), name.substr(last));
}

template <typename T>
std::string TypeText() {
  if constexpr (Message<T>) {
    return ShortName(T::kName);
  } else if constexpr (kIsArray<T>) {
    return absl::StrCat(TypeText<typename Elements<T>::Type>(), "[",
                        std::tuple_size_v<T>, "]");
  } else if constexpr (kIsSequence<T>) {
    return absl::StrCat(TypeText<typename Elements<T>::Type>(), "[]");
  } else if constexpr (std::same_as<T, std::string>) {
    return "string";
  } else if constexpr (std::same_as<T, std::byte>) {
    return "byte";
  } else if constexpr (std::same_as<T, bool>) {
    return "bool";
  } else if constexpr (std::floating_point<T>) {
    return absl::StrCat("float", 8 * sizeof(T));
  } else {
    return absl::StrCat(std::is_signed_v<T> ? "int" : "uint", 8 * sizeof(T));
  }
}

// In the order in which they are met; each once.
struct Definitions {
  std::vector<std::pair<std::string, std::string>> text_of_name;

  bool Has(const std::string& name) const {
    for (const auto& [known, text] : text_of_name) {
      if (known == name) return true;
    }
    return false;
  }
};

template <typename T>
void Define(Definitions& definitions) {
  if constexpr (kIsArray<T> || kIsSequence<T>) {
    Define<typename Elements<T>::Type>(definitions);
  } else if constexpr (Message<T>) {
    const std::string name = ShortName(T::kName);
    if (definitions.Has(name)) return;
    std::string text;
    const auto add = [&text](auto field) {
      using Value =
          std::remove_reference_t<decltype(std::declval<T>().*field.member)>;
      absl::StrAppend(&text, TypeText<Value>(), " ", field.name, "\n");
    };
    std::apply([&](auto... field) { (add(field), ...); }, T::Fields());
    definitions.text_of_name.emplace_back(name, std::move(text));
    const auto descend = [&definitions](auto field) {
      using Value =
          std::remove_reference_t<decltype(std::declval<T>().*field.member)>;
      Define<Value>(definitions);
    };
    std::apply([&](auto... field) { (descend(field), ...); }, T::Fields());
  }
}

}  // namespace

template <Message M>
std::string SchemaText() {
  Definitions definitions;
  Define<M>(definitions);
  std::string text;
  for (const auto& [name, fields] : definitions.text_of_name) {
    if (!text.empty()) {
      absl::StrAppend(&text, std::string(80, '='), "\nMSG: ", name, "\n");
    }
    absl::StrAppend(&text, fields);
  }
  return text;
}

template std::string SchemaText<Empty>();
template std::string SchemaText<Clock>();
template std::string SchemaText<DiagnosticArray>();
template std::string SchemaText<PoseStamped>();
template std::string SchemaText<PoseWithCovarianceStamped>();
template std::string SchemaText<Twist>();
template std::string SchemaText<TwistStamped>();
template std::string SchemaText<TFMessage>();
template std::string SchemaText<LaserScan>();
template std::string SchemaText<PointCloud2>();
template std::string SchemaText<Image>();
template std::string SchemaText<CompressedImage>();
template std::string SchemaText<CameraInfo>();
template std::string SchemaText<Odometry>();
template std::string SchemaText<OccupancyGrid>();
template std::string SchemaText<Path>();
template std::string SchemaText<String>();
template std::string SchemaText<Bool>();
template std::string SchemaText<Float64>();
template std::string SchemaText<Log>();
template std::string SchemaText<JointState>();
template std::string SchemaText<Imu>();

}  // namespace treeline::messages
