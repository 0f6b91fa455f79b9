#include "nav_agent/service/dock_book.h"

#include <span>
#include <utility>

#include "common/base/status_macros.h"
#include "nav_agent/docking/dock_file.h"

namespace treeline::agent_service {
namespace {

// 100 docks with long names take 20 kB.
constexpr uint64_t kMaxBytes = 1u << 20;

}  // namespace

DockBook::DockBook(std::shared_ptr<const behavior::NavigatorMap> map,
                   const std::string& folder)
    : KeptByName(
          {.one = "dock",
           .many = "docks",
           .max_bytes = kMaxBytes,
           .text = docking::DockFileText,
           .parse = docking::ParseDockFile,
           .check =
               [map = std::move(map)](std::span<const docking::Dock> all) {
                 return docking::CheckDocks(all, map->levels);
               }},
          folder) {}

absl::StatusOr<std::unique_ptr<DockBook>> DockBook::Open(
    std::shared_ptr<const behavior::NavigatorMap> map,
    const std::string& folder) {
  auto book = std::make_unique<DockBook>(std::move(map), folder);
  TL_RETURN_IF_ERROR(book->Load());
  return book;
}

}  // namespace treeline::agent_service
