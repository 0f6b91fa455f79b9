// What is in a folder.
#ifndef COMMON_BASE_FOLDER_H_
#define COMMON_BASE_FOLDER_H_

#include <string>
#include <vector>

namespace treeline::base {

// Whether there is a file of that name: no folder, and nothing special.
bool IsFile(const std::string& path);

// The names in `folder`, sorted. A folder that cannot be read has none.
std::vector<std::string> SortedNamesIn(const std::string& folder);

}  // namespace treeline::base

#endif  // COMMON_BASE_FOLDER_H_
