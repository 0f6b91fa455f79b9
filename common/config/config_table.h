// Settings tied to the fields of a struct, each declared once.
#ifndef COMMON_CONFIG_CONFIG_TABLE_H_
#define COMMON_CONFIG_CONFIG_TABLE_H_

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/config/effective_config.h"
#include "common/config/setting.h"

namespace treeline::config {

// Of a struct with defaults,
//
//   struct Options { int queue = 64; };
//   ConfigTable<Options> table;
//   table.Add(&Options::queue, {.name = "queue", .help = "Queries that may
//   wait",
//                               .min = 1, .max = 1000});
//
// the table makes settings for ResolveConfig, whose defaults and types are the
// fields', and a struct of what that returned. Fields are bool, int, int64_t,
// double, std::string or std::vector<std::string>; the bounds of an int must
// fit into it, and are its own where there are none.
template <typename Config>
class ConfigTable {
 public:
  template <typename Field>
  void Add(Field Config::*field, Setting setting) {
    if constexpr (std::is_same_v<Field, int>) {
      if (setting.min > setting.max) {
        setting.min = std::numeric_limits<int>::min();
        setting.max = std::numeric_limits<int>::max();
      }
    }
    setting.default_value = Stored<Field>(Config().*field);
    settings_.push_back(std::move(setting));
    setters_.push_back([field](const ConfigValue& value, Config& config) {
      config.*field = static_cast<Field>(std::get<Stored<Field>>(value));
    });
  }

  const std::vector<Setting>& settings() const { return settings_; }

  // `config` must come from ResolveConfig with settings().
  Config Make(const EffectiveConfig& config) const {
    Config made;
    for (size_t i = 0; i < settings_.size(); ++i) {
      setters_[i](config.at(settings_[i].name).value, made);
    }
    return made;
  }

 private:
  template <typename Field>
  using Stored = std::conditional_t<std::is_same_v<Field, int>, int64_t, Field>;

  std::vector<Setting> settings_;
  std::vector<std::function<void(const ConfigValue&, Config&)>> setters_;
};

}  // namespace treeline::config

#endif  // COMMON_CONFIG_CONFIG_TABLE_H_
