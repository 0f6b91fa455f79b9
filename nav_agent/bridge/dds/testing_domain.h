// A DDS domain that tests of other programs, and of other checkouts on the same
// machine, do not join as a rule.
#ifndef NAV_AGENT_BRIDGE_DDS_TESTING_DOMAIN_H_
#define NAV_AGENT_BRIDGE_DDS_TESTING_DOMAIN_H_

#include <unistd.h>

namespace treeline::dds {

// From 1 to 100: above 101 the ports are those that Linux gives to clients.
inline int TestingDomain() { return 1 + static_cast<int>(getpid() % 100); }

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_TESTING_DOMAIN_H_
