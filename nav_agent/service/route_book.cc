#include "nav_agent/service/route_book.h"

#include <span>

#include "common/base/status_macros.h"
#include "nav_agent/routes/route_file.h"

namespace treeline::agent_service {
namespace {

// 1000 routes of 100 waypoints with long names take 16 MB.
constexpr uint64_t kMaxBytes = 32u << 20;

}  // namespace

RouteBook::RouteBook(int levels, const std::string& folder)
    : KeptByName({.one = "route",
                  .many = "routes",
                  .max_bytes = kMaxBytes,
                  .text = routes::RouteFileText,
                  .parse = routes::ParseRouteFile,
                  .check =
                      [levels](std::span<const routes::Route> all) {
                        return routes::CheckRoutes(all, levels);
                      }},
                 folder),
      levels_(levels) {}

absl::StatusOr<std::unique_ptr<RouteBook>> RouteBook::Open(
    int levels, const std::string& folder) {
  auto book = std::make_unique<RouteBook>(levels, folder);
  TL_RETURN_IF_ERROR(book->Load());
  return book;
}

}  // namespace treeline::agent_service
