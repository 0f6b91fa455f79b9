// A model's provenance in words, for terminals and pages.
#ifndef SERVER_TOOLS_MODEL_DESCRIPTION_H_
#define SERVER_TOOLS_MODEL_DESCRIPTION_H_

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/core/forest/model_file.h"
#include "server/core/forest/model_info.h"

namespace treeline::tools {

// Name and value of one line.
using DescriptionRow = std::pair<std::string, std::string>;

struct DescriptionSection {
  std::string title;
  std::vector<DescriptionRow> rows;
};

// Everything in `model`, in the order in which a person asks: where it comes
// from, how large it is, how its cameras are calibrated, how it was trained.
std::vector<DescriptionSection> DescribeModel(const forest::ModelInfo& model);

// What takes the bytes of a model's file, and what that becomes in memory.
DescriptionSection DescribeSizes(std::span<const forest::SectionSize> sections);

// The sections as aligned plain text, one row a line.
std::string DescriptionText(const std::vector<DescriptionSection>& sections);

// "34.2 MB" (powers of ten).
std::string FormatBytes(uint64_t bytes);

// 1234567 -> "1,234,567".
std::string FormatCount(int64_t count);

// "%.3f" and the like for one number; "-" if it is not finite.
std::string FormatNumber(const char* format, double value);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_MODEL_DESCRIPTION_H_
