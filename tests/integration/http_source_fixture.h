// An HttpModelSource, a web server, and a cache of their own.
#ifndef TESTS_INTEGRATION_HTTP_SOURCE_FIXTURE_H_
#define TESTS_INTEGRATION_HTTP_SOURCE_FIXTURE_H_

#include <chrono>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "gmock/gmock.h"
#include "server/repository/http_model_source.h"
#include "tests/integration/web_server.h"

namespace treeline {

class HttpSourceTest : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  // Bytes that no part of repeats another.
  static std::string Model(size_t bytes, char first = 'm');
  static std::string DigestOf(const std::string& bytes);
  // Adds a model to the server's index, at `url`, with what the server says.
  void Serve(const std::string& model, std::vector<WebAnswer> answers = {{}},
             const std::string& url = "model.treeline");
  // Opens the source anew, as after a restart.
  void Open();
  // Of the model that was served last, listed first if it must be.
  absl::StatusOr<std::string> Fetch(const std::stop_token& stop = {});
  // The same, in the child of a fork; _exits with 0 if it could be fetched.
  [[noreturn]] void FetchAndExit();
  repository::ModelRef RefOf(const std::string& model) const;
  // Names in the cache's folder of models.
  std::set<std::string> CachedNames() const;

  std::unique_ptr<WebServer> server_ = {};
  std::string folder_ = {};
  base::SteadyClock clock_ = {};
  // Pauses that were asked for and not made.
  std::vector<std::chrono::milliseconds> pauses_ = {};
  std::vector<std::string> warnings_ = {};
  repository::HttpModelSourceOptions options_ = {};
  std::unique_ptr<repository::HttpModelSource> source_ = {};
  std::string model_ = {};
};

}  // namespace treeline

#endif  // TESTS_INTEGRATION_HTTP_SOURCE_FIXTURE_H_
