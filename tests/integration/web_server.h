// A real web server on loopback that serves models as a test wants it to.
#ifndef TESTS_INTEGRATION_WEB_SERVER_H_
#define TESTS_INTEGRATION_WEB_SERVER_H_

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace treeline {

// How a file is answered. Each request takes the next of the list; the last
// one stays.
struct WebAnswer {
  int status = 200;
  // Header names and values.
  std::vector<std::pair<std::string, std::string>> headers = {};
  // Of a body of which less is sent than announced: how much. -1: all.
  int64_t stop_after = -1;
  // After these bytes, before the connection is closed.
  std::function<void()> at_stop = {};
  // Whether a Range is answered with 206.
  bool ranges = true;
};

struct WebRequest {
  std::string path;  // with the query
  std::string range;
  std::string if_none_match;
  std::string authorization;
  // Bytes of the body that were sent.
  size_t sent = 0;
};

// Certificates for tests, in PEM.
struct TestAuthority {
  std::string ca_pem;
  std::string certificate_pem;
  std::string key_pem;
};
// A new authority, and a certificate of it for this address.
TestAuthority MakeAuthority(const std::string& ip_address,
                            const std::string& name = "Test authority");

class WebServer {
 public:
  // Encrypted with this certificate; none: plain http.
  explicit WebServer(const TestAuthority* authority = nullptr);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  // "http://127.0.0.1:34567"
  const std::string& address() const { return address_; }

  // ETags are digests of the contents.
  void Put(const std::string& path, const std::string& contents,
           std::vector<WebAnswer> answers = {{}});
  std::vector<WebRequest> Requests(const std::string& path_prefix) const;
  // No longer answers; its port is closed.
  void Stop();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
  std::string address_;
  std::thread thread_;
};

}  // namespace treeline

#endif  // TESTS_INTEGRATION_WEB_SERVER_H_
