// Data files of a program: where it was installed, or where it was built.
#ifndef COMMON_BASE_INSTALLED_FILE_H_
#define COMMON_BASE_INSTALLED_FILE_H_

#include <string>

namespace treeline::base {

// ../share/treeline/NAME beside this program, or else source_place; empty if
// neither is a file.
std::string FindInstalledFile(const std::string& name,
                              const std::string& source_place);

}  // namespace treeline::base

#endif  // COMMON_BASE_INSTALLED_FILE_H_
