// Settings from the command line.
#ifndef COMMON_CONFIG_CONFIG_FLAGS_H_
#define COMMON_CONFIG_CONFIG_FLAGS_H_

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/config/setting.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace treeline::config {

// One flag for each setting that is not a secret. The flags only collect text:
// what it means is decided where the environment's is.
class ConfigFlags {
 public:
  // Adds the flags to `app`, which must outlive this object, and their help:
  // default, bounds and whether a change needs a restart.
  ConfigFlags(CLI::App& app, const std::vector<Setting>& settings);

  // What stood on the command line, by the setting's name, after app.parse().
  // A list given several times is joined.
  std::map<std::string, std::string> Given() const;

 private:
  std::vector<std::pair<Setting, CLI::Option*>> flags_;
};

}  // namespace treeline::config

#endif  // COMMON_CONFIG_CONFIG_FLAGS_H_
