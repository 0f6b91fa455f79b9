// A few settings of every type, for tests.
#ifndef COMMON_CONFIG_TESTING_SETTINGS_H_
#define COMMON_CONFIG_TESTING_SETTINGS_H_

#include <string>
#include <vector>

#include "common/config/config_table.h"

namespace treeline::config {

struct TestOptions {
  std::string models;
  int queue = 64;
  double drain_s = 1;
  bool load_all = false;
  std::vector<std::string> cors_origin;
  std::string log_level = "info";
  std::string password;
};

inline ConfigTable<TestOptions> TestTable() {
  ConfigTable<TestOptions> table;
  table.Add(&TestOptions::models, {.name = "models",
                                   .value_name = "DIR|URL",
                                   .help = "Where the scenes are",
                                   .required = true,
                                   .secrecy = Secrecy::kAddress});
  table.Add(&TestOptions::queue, {.name = "queue",
                                  .help = "Queries that may wait",
                                  .min = 1,
                                  .max = 100000});
  table.Add(&TestOptions::drain_s, {.name = "drain_s",
                                    .help = "Seconds to go on answering",
                                    .min = 0,
                                    .max = 3600,
                                    .live = true});
  table.Add(&TestOptions::load_all, {.name = "load_all", .help = "Load all"});
  table.Add(&TestOptions::cors_origin,
            {.name = "cors_origin", .help = "Origins", .live = true});
  table.Add(&TestOptions::log_level, {.name = "log_level",
                                      .help = "What is logged",
                                      .choices = {"debug", "info", "error"},
                                      .live = true});
  table.Add(
      &TestOptions::password,
      {.name = "password", .help = "A secret", .secrecy = Secrecy::kSecret});
  return table;
}

}  // namespace treeline::config

#endif  // COMMON_CONFIG_TESTING_SETTINGS_H_
