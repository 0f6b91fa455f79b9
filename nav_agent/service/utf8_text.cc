#include "nav_agent/service/utf8_text.h"

#include <nlohmann/json.hpp>

namespace treeline::agent_service {

std::string Utf8(const std::string& text) {
  const std::string quoted =
      nlohmann::json(text).dump(-1, ' ', /*ensure_ascii=*/false,
                                nlohmann::json::error_handler_t::replace);
  return nlohmann::json::parse(quoted).get<std::string>();
}

}  // namespace treeline::agent_service
