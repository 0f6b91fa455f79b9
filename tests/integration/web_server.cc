#include "tests/integration/web_server.h"

#include <httplib.h>
#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "server/repository/sha256.h"

namespace treeline {
namespace {

using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;
using Memory = std::unique_ptr<BIO, decltype(&BIO_free)>;

Key MakeKey() { return {EVP_EC_gen("P-256"), &EVP_PKEY_free}; }

void AddExtension(X509* certificate, X509* issuer, int id,
                  const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension =
      X509V3_EXT_conf_nid(nullptr, &context, id, value.c_str());
  X509_add_ext(certificate, extension, -1);
  X509_EXTENSION_free(extension);
}

// Signed by `issuer`; null: by itself, as an authority.
Certificate MakeCertificate(const std::string& name, EVP_PKEY* key,
                            X509* issuer, EVP_PKEY* issuer_key) {
  Certificate certificate(X509_new(), &X509_free);
  X509* made = certificate.get();
  X509_set_version(made, 2);
  ASN1_INTEGER_set(X509_get_serialNumber(made), issuer == nullptr ? 1 : 2);
  X509_gmtime_adj(X509_getm_notBefore(made), -3600);
  X509_gmtime_adj(X509_getm_notAfter(made), 3600);
  X509_set_pubkey(made, key);
  X509_NAME_add_entry_by_txt(
      X509_get_subject_name(made), "CN", MBSTRING_ASC,
      reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509* parent = issuer == nullptr ? made : issuer;
  X509_set_issuer_name(made, X509_get_subject_name(parent));
  if (issuer == nullptr) {
    AddExtension(made, parent, NID_basic_constraints, "critical,CA:TRUE");
    AddExtension(made, parent, NID_key_usage, "critical,keyCertSign");
  } else {
    AddExtension(made, parent, NID_subject_alt_name, "IP:" + name);
  }
  X509_sign(made, issuer_key, EVP_sha256());
  return certificate;
}

std::string Contents(const Memory& memory) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &data);
  return {data, static_cast<size_t>(size)};
}

std::string Pem(X509* certificate) {
  const Memory memory(BIO_new(BIO_s_mem()), &BIO_free);
  PEM_write_bio_X509(memory.get(), certificate);
  return Contents(memory);
}

std::string Pem(EVP_PKEY* key) {
  const Memory memory(BIO_new(BIO_s_mem()), &BIO_free);
  PEM_write_bio_PrivateKey(memory.get(), key, nullptr, nullptr, 0, nullptr,
                           nullptr);
  return Contents(memory);
}

std::unique_ptr<httplib::Server> MakeServer(const TestAuthority* authority) {
  if (authority == nullptr) return std::make_unique<httplib::Server>();
  const Memory certificate_pem(
      BIO_new_mem_buf(authority->certificate_pem.data(), -1), &BIO_free);
  const Memory key_pem(BIO_new_mem_buf(authority->key_pem.data(), -1),
                       &BIO_free);
  const Certificate certificate(
      PEM_read_bio_X509(certificate_pem.get(), nullptr, nullptr, nullptr),
      &X509_free);
  const Key key(
      PEM_read_bio_PrivateKey(key_pem.get(), nullptr, nullptr, nullptr),
      &EVP_PKEY_free);
  return std::make_unique<httplib::SSLServer>(certificate.get(), key.get());
}

// The first byte of "bytes=100-".
size_t FirstByteOf(absl::string_view range) {
  uint64_t first = 0;
  if (!absl::ConsumePrefix(&range, "bytes=") ||
      !absl::SimpleAtoi(absl::StripSuffix(range, "-"), &first)) {
    return 0;
  }
  return first;
}

}  // namespace

TestAuthority MakeAuthority(const std::string& ip_address,
                            const std::string& name) {
  const Key ca_key = MakeKey();
  const Certificate ca =
      MakeCertificate(name, ca_key.get(), nullptr, ca_key.get());
  const Key key = MakeKey();
  const Certificate certificate =
      MakeCertificate(ip_address, key.get(), ca.get(), ca_key.get());
  return {.ca_pem = Pem(ca.get()),
          .certificate_pem = Pem(certificate.get()),
          .key_pem = Pem(key.get())};
}

class WebServer::Impl {
 public:
  explicit Impl(const TestAuthority* authority)
      : server_(MakeServer(authority)) {
    server_->Get(".*", [this](const httplib::Request& request,
                              httplib::Response& response) {
      Answer(request, response);
    });
    server_->set_keep_alive_max_count(1);
  }

  httplib::Server& server() { return *server_; }

  void Put(const std::string& path, const std::string& contents,
           std::vector<WebAnswer> answers) {
    absl::MutexLock lock(&mutex_);
    files_[path] = {contents, std::move(answers), 0};
  }

  std::vector<WebRequest> Requests(const std::string& path_prefix) const {
    absl::MutexLock lock(&mutex_);
    std::vector<WebRequest> found;
    for (const WebRequest& request : requests_) {
      if (request.path.rfind(path_prefix, 0) == 0) found.push_back(request);
    }
    return found;
  }

 private:
  struct File {
    std::string contents;
    std::vector<WebAnswer> answers;
    size_t next = 0;
  };

  void Answer(const httplib::Request& request, httplib::Response& response) {
    std::string contents;
    WebAnswer answer{.status = 404};
    size_t number = 0;
    {
      absl::MutexLock lock(&mutex_);
      number = requests_.size();
      requests_.push_back(
          {.path = request.target,
           .range = request.get_header_value("Range"),
           .if_none_match = request.get_header_value("If-None-Match"),
           .authorization = request.get_header_value("Authorization")});
      const auto file = files_.find(request.target);
      if (file != files_.end()) {
        File& found = file->second;
        contents = found.contents;
        answer =
            found.answers[std::min(found.next++, found.answers.size() - 1)];
      }
    }
    response.status = answer.status;
    for (const auto& [name, value] : answer.headers) {
      response.set_header(name, value);
    }
    if (answer.status == 200) Send(request, answer, contents, number, response);
  }

  void Send(const httplib::Request& request, const WebAnswer& answer,
            const std::string& contents, size_t number,
            httplib::Response& response) {
    repository::Sha256 hash;
    hash.Update(contents);
    const std::string etag = "\"" + hash.Finish() + "\"";
    response.set_header("ETag", etag);
    if (request.get_header_value("If-None-Match") == etag) {
      response.status = 304;
      return;
    }
    const size_t first =
        answer.ranges ? FirstByteOf(request.get_header_value("Range")) : 0;
    if (first > 0 && first >= contents.size()) {
      response.status = 416;
      return;
    }
    if (first > 0) {
      response.status = 206;
      response.set_header("Content-Range", absl::StrCat("bytes ", first, "-",
                                                        contents.size() - 1,
                                                        "/", contents.size()));
    }
    // The library must not cut the range itself.
    const_cast<httplib::Request&>(request).ranges.clear();
    const std::string body = contents.substr(first);
    if (body.empty()) return;  // a provider of nothing is asked for ever
    const size_t stop =
        answer.stop_after < 0
            ? body.size()
            : std::min(body.size(), static_cast<size_t>(answer.stop_after));
    response.set_content_provider(
        body.size(), "application/octet-stream",
        [this, body, stop, answer, number](size_t offset, size_t /*length*/,
                                           httplib::DataSink& sink) {
          const size_t count = std::min<size_t>(stop - offset, 16384);
          if (count > 0 && !sink.write(body.data() + offset, count)) {
            return false;
          }
          absl::MutexLock lock(&mutex_);
          requests_[number].sent += count;
          if (offset + count < stop || stop == body.size()) return true;
          mutex_.Unlock();
          if (answer.at_stop) answer.at_stop();
          mutex_.Lock();
          return false;
        });
  }

  std::unique_ptr<httplib::Server> server_;
  mutable absl::Mutex mutex_;
  std::map<std::string, File> files_ ABSL_GUARDED_BY(mutex_);
  std::vector<WebRequest> requests_ ABSL_GUARDED_BY(mutex_);
};

WebServer::WebServer(const TestAuthority* authority)
    : impl_(std::make_unique<Impl>(authority)) {
  const int port = impl_->server().bind_to_any_port("127.0.0.1");
  address_ = absl::StrCat(authority == nullptr ? "http" : "https",
                          "://127.0.0.1:", port);
  thread_ = std::thread([this] { impl_->server().listen_after_bind(); });
  // stop() is lost on a server that does not listen yet.
  while (!impl_->server().is_running()) std::this_thread::yield();
}

WebServer::~WebServer() { Stop(); }

void WebServer::Stop() {
  impl_->server().stop();
  if (thread_.joinable()) thread_.join();
}

void WebServer::Put(const std::string& path, const std::string& contents,
                    std::vector<WebAnswer> answers) {
  impl_->Put(path, contents, std::move(answers));
}

std::vector<WebRequest> WebServer::Requests(
    const std::string& path_prefix) const {
  return impl_->Requests(path_prefix);
}

}  // namespace treeline
