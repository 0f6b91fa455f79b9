// Early return on absl::Status and absl::StatusOr.
#ifndef COMMON_BASE_STATUS_MACROS_H_
#define COMMON_BASE_STATUS_MACROS_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

#define TL_RETURN_IF_ERROR(expression)                              \
  do {                                                              \
    if (::absl::Status tl_status = (expression); !tl_status.ok()) { \
      return tl_status;                                             \
    }                                                               \
  } while (false)

#define TL_STATUS_CONCAT_INNER(a, b) a##b
#define TL_STATUS_CONCAT(a, b) TL_STATUS_CONCAT_INNER(a, b)

// TL_ASSIGN_OR_RETURN(auto image, DecodeJpeg(bytes));
#define TL_ASSIGN_OR_RETURN(declaration, expression)                  \
  TL_ASSIGN_OR_RETURN_IMPL(TL_STATUS_CONCAT(tl_status_or_, __LINE__), \
                           declaration, expression)

#define TL_ASSIGN_OR_RETURN_IMPL(status_or, declaration, expression) \
  auto status_or = (expression);                                     \
  if (!status_or.ok()) return std::move(status_or).status();         \
  declaration = *std::move(status_or)

namespace treeline::base {

// The same error with `context` in front: "reading scene.json: ...".
inline absl::Status Annotate(const absl::Status& status,
                             absl::string_view context) {
  if (status.ok()) return status;
  std::string message(context);
  message.append(": ").append(status.message().data(), status.message().size());
  return absl::Status(status.code(), message);
}

}  // namespace treeline::base

#endif  // COMMON_BASE_STATUS_MACROS_H_
