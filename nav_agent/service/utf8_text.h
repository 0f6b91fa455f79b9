// Text of devices, libraries and files, as messages may have it.
#ifndef NAV_AGENT_SERVICE_UTF8_TEXT_H_
#define NAV_AGENT_SERVICE_UTF8_TEXT_H_

#include <string>

namespace treeline::agent_service {

// What is not UTF-8 becomes U+FFFD.
std::string Utf8(const std::string& text);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_UTF8_TEXT_H_
