// Models from a web server or an object store, kept in a folder.
#ifndef SERVER_REPOSITORY_HTTP_MODEL_SOURCE_H_
#define SERVER_REPOSITORY_HTTP_MODEL_SOURCE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/repository/digest_cache.h"
#include "server/repository/http_get.h"
#include "server/repository/index_signature.h"
#include "server/repository/model_index.h"
#include "server/repository/model_source.h"
#include "server/repository/retry.h"

namespace treeline::repository {

struct HttpModelSourceOptions {
  // http or https. One that ends with / is a folder that holds index.json;
  // else it is the index itself. May have a query and user:password@.
  std::string url;
  DigestCacheOptions cache = {};
  HttpOptions http = {};
  RetryOptions retry = {};
  // Of which one must have signed the index; null: none need have.
  std::shared_ptr<const IndexKeys> keys = nullptr;
  // Of the pauses between attempts.
  uint64_t seed = 0;
  // Ends List() and Fetch(), beside the token that Fetch() is given.
  std::stop_token stop = {};
  // Told, without a lock being held, what goes on working but should be known.
  std::function<void(absl::string_view)> warn = {};

  // INVALID_ARGUMENT
  absl::Status Validate() const;
};

// Whether --models names a web server rather than a folder.
bool IsModelUrl(absl::string_view models);

// The last index that could be read is kept in the cache's folder: List()
// answers with it while the server cannot be reached or what it has is not
// signed as it must be, also after a restart. A fingerprint is the file's
// SHA-256.
//
// List():  UNAVAILABLE or FAILED_PRECONDITION with the reasons of http_get.h
//          and no index kept; NOT_FOUND, PERMISSION_DENIED: what the server
//          says of the index; INVALID_ARGUMENT, INDEX_INVALID: what it holds;
//          FAILED_PRECONDITION, INDEX_UNSIGNED, INDEX_SIGNATURE_WRONG.
// Fetch(): the same of the model; DATA_LOSS, MODEL_CORRUPT: it is not what the
//          index promises; RESOURCE_EXHAUSTED, CACHE_FULL: no space for it;
//          NOT_FOUND, NOT_IN_INDEX: it is no longer listed.
class HttpModelSource final : public ModelSource {
 public:
  // Needs no network. `clock` and `sleep` outlive it.
  static absl::StatusOr<std::unique_ptr<HttpModelSource>> Open(
      HttpModelSourceOptions options, const base::Clock& clock,
      Sleeper sleep = &SleepUnlessStopped);

  absl::StatusOr<SourceListing> List() override;
  absl::StatusOr<std::string> LocalPath(const ModelRef& model) override;
  absl::StatusOr<std::string> Fetch(const ModelRef& model,
                                    const std::stop_token& stop) override;
  std::shared_ptr<const void> Keep(const ModelRef& model) override;

 private:
  // An index as it was read, and what the server calls it.
  struct KeptIndex {
    std::string etag;
    std::string text;
    bool empty() const { return text.empty(); }
  };

  HttpModelSource(HttpModelSourceOptions options, std::string index_url,
                  std::unique_ptr<DigestCache> cache, const base::Clock& clock,
                  Sleeper sleep);
  std::string IndexPath() const;
  KeptIndex ReadKeptIndex() const;
  void KeepIndex(const KeptIndex& kept) const;
  // What an index holds, if it may be believed.
  absl::StatusOr<ModelIndex> Read(const KeptIndex& index) const;
  // The same of what comes after `before`, where there is one.
  absl::StatusOr<ModelIndex> ReadNext(
      const KeptIndex& index, const absl::StatusOr<ModelIndex>& before) const;
  // List() without a warning.
  absl::StatusOr<SourceListing> ListNow();
  // The index now; `kept` where it has not changed.
  absl::StatusOr<KeptIndex> GetIndex(const KeptIndex& kept) const;
  absl::Status Download(const std::string& url, CacheDownload& download,
                        const std::stop_token& stop) const;
  absl::StatusOr<std::string> FetchOnce(const ModelRef& model,
                                        const std::string& url,
                                        const std::stop_token& stop,
                                        bool& resumed) const;
  void Warn(absl::string_view message) const;

  const HttpModelSourceOptions options_;
  const std::string index_url_;
  const std::unique_ptr<DigestCache> cache_;
  const base::Clock& clock_;
  const Sleeper sleep_;
  absl::Mutex mutex_;
  // Of the last listing: absolute, by digest.
  std::map<std::string, std::string> urls_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_HTTP_MODEL_SOURCE_H_
