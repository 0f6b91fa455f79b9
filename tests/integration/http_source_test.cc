// Models from a real web server: what works, and what is asked of the server.
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "gmock/gmock.h"
#include "server/repository/testing_index_keys.h"
#include "tests/integration/http_source_fixture.h"

namespace treeline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class HttpSource : public HttpSourceTest {};

TEST_F(HttpSource, ListsWhatTheIndexHoldsAndFetchesItOnce) {
  Serve(Model(100000));
  Open();
  const auto listing = source_->List();
  ASSERT_TRUE(listing.ok()) << listing.status();
  ASSERT_THAT(listing->models, SizeIs(1));
  EXPECT_EQ(listing->models[0].scene, "kitchen");
  EXPECT_EQ(listing->models[0].version, "7");
  EXPECT_EQ(listing->models[0].bytes, 100000u);
  EXPECT_EQ(listing->models[0].fingerprint, DigestOf(model_));
  EXPECT_EQ(listing->scene_json.at("kitchen"), R"({"display_name":"Kitchen"})");
  for (int i = 0; i < 2; ++i) {
    const auto path = source_->Fetch(listing->models[0], {});
    ASSERT_TRUE(path.ok()) << path.status();
    EXPECT_EQ(base::ReadFile(*path).value(), model_);
  }
  EXPECT_THAT(server_->Requests("/model.treeline"), SizeIs(1));
  EXPECT_THAT(CachedNames(), ElementsAre(DigestOf(model_) + ".treeline"));
}

TEST_F(HttpSource, AFolderMeansTheIndexInIt) {
  Serve(Model(100));
  options_.url = server_->address() + "/";
  EXPECT_TRUE(Fetch().ok());
}

TEST_F(HttpSource, PresignedAddressesWorkAndAreNeverShown) {
  Serve(Model(100), {{}, {.status = 403}}, "model?X-Sig=SECRET&Expires=1");
  server_->Put("/index.json?sig=SECRET", "");
  EXPECT_TRUE(Fetch().ok());
  EXPECT_THAT(server_->Requests("/model?X-Sig=SECRET&Expires=1"), SizeIs(1));
  // The same answered with errors of every kind.
  for (const int status : {403, 404, 418, 500, 302}) {
    Serve(Model(100 + static_cast<size_t>(status)),
          {{.status = status, .headers = {{"Location", "/no?s=SECRET"}}}},
          "model?X-Sig=SECRET");
    source_.reset();
    const auto path = Fetch();
    ASSERT_FALSE(path.ok()) << status;
    EXPECT_EQ(path.status().ToString().find("SECRET"), std::string::npos)
        << path.status();
    EXPECT_THAT(path.status().ToString(), HasSubstr("127.0.0.1")) << status;
  }
}

TEST_F(HttpSource, UserAndPasswordAreSentAndNeverShown) {
  Serve(Model(100));
  options_.url = "http://me:SECRET@" +
                 server_->address().substr(std::string("http://").size()) +
                 "/index.json";
  EXPECT_TRUE(Fetch().ok());
  for (const WebRequest& request : server_->Requests("/")) {
    EXPECT_EQ(request.authorization, "Basic bWU6U0VDUkVU") << request.path;
  }
  server_->Put("/index.json", "{");
  const auto listing = source_->List();
  ASSERT_FALSE(listing.ok());
  EXPECT_EQ(listing.status().ToString().find("SECRET"), std::string::npos);
}

TEST_F(HttpSource, AnUnchangedIndexIsNotSentAgainEvenAfterARestart) {
  Serve(Model(100));
  Open();
  ASSERT_TRUE(source_->List().ok());
  ASSERT_TRUE(source_->List().ok());
  Open();
  const auto listing = source_->List();
  ASSERT_TRUE(listing.ok()) << listing.status();
  EXPECT_THAT(listing->models, SizeIs(1));
  const auto requests = server_->Requests("/index.json");
  ASSERT_THAT(requests, SizeIs(3));
  EXPECT_GT(requests[0].sent, 0u);
  EXPECT_EQ(requests[1].sent, 0u);
  EXPECT_EQ(requests[2].sent, 0u);
}

TEST_F(HttpSource, AChangedIndexIsSeen) {
  Serve(Model(100));
  ASSERT_TRUE(Fetch().ok());
  Serve(Model(200));
  const auto listing = source_->List();
  ASSERT_TRUE(listing.ok()) << listing.status();
  EXPECT_EQ(listing->models[0].bytes, 200u);
  EXPECT_EQ(base::ReadFile(Fetch().value()).value(), model_);
}

TEST_F(HttpSource, WithoutTheServerTheLastIndexAndWhatIsCachedServe) {
  Serve(Model(100));
  ASSERT_TRUE(Fetch().ok());
  server_->Stop();
  Open();
  const auto listing = source_->List();
  ASSERT_TRUE(listing.ok()) << listing.status();
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("going on with the last")));
  const auto path = source_->Fetch(listing->models[0], {});
  ASSERT_TRUE(path.ok()) << path.status();
  EXPECT_EQ(base::ReadFile(*path).value(), model_);
}

TEST_F(HttpSource, WithoutTheServerAndALastIndexItSaysWhatIsWrong) {
  server_->Stop();
  Open();
  const auto listing = source_->List();
  EXPECT_TRUE(absl::IsUnavailable(listing.status())) << listing.status();
  EXPECT_EQ(base::ErrorInfoOf(listing.status()).reason, "SOURCE_UNREACHABLE");
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("nothing new is served")));
  EXPECT_THAT(pauses_, SizeIs(4));
}

TEST_F(HttpSource, ADamagedLastIndexIsNotAskedFor) {
  Serve(Model(100));
  ASSERT_TRUE(Fetch().ok());
  // "{" is no index; its ETag stays.
  const std::string path =
      absl::StrCat(folder_, "/index/", DigestOf(options_.url));
  const std::string kept = base::ReadFile(path).value();
  ASSERT_TRUE(
      base::WriteFileAtomically(path, kept.substr(0, kept.find('\n') + 2))
          .ok());
  Open();
  EXPECT_TRUE(source_->List().ok());
  EXPECT_EQ(base::ReadFile(path).value(), kept);
}

TEST_F(HttpSource, AnIndexThatIsNoneIsRefusedAndNotKept) {
  Serve(Model(100));
  ASSERT_TRUE(Fetch().ok());
  server_->Put("/index.json", R"({"models":[],"x":1})");
  const auto broken = source_->List();
  EXPECT_TRUE(absl::IsInvalidArgument(broken.status()));
  EXPECT_EQ(base::ErrorInfoOf(broken.status()).reason, "INDEX_INVALID");
  server_->Put("/index.json", R"({"models":[]})" +
                                  std::string(repository::kMaxIndexBytes, ' '));
  EXPECT_EQ(base::ErrorInfoOf(source_->List().status()).reason,
            "INDEX_INVALID");
  server_->Stop();
  EXPECT_TRUE(source_->List().ok());
}

TEST_F(HttpSource, RedirectsAreFollowed) {
  Serve(Model(100));
  server_->Put("/index.json", "",
               {{.status = 302, .headers = {{"Location", "/a"}}}});
  server_->Put(
      "/a", "",
      {{.status = 308, .headers = {{"Location", server_->address() + "/b"}}}});
  server_->Put("/b", R"({"models":[]})");
  Open();
  EXPECT_TRUE(source_->List().ok());
}

TEST_F(HttpSource, RedirectsInACircleEnd) {
  server_->Put("/index.json", "",
               {{.status = 302, .headers = {{"Location", "/index.json"}}}});
  Open();
  const auto listing = source_->List();
  EXPECT_EQ(base::ErrorInfoOf(listing.status()).reason, "SOURCE_REFUSED");
  EXPECT_THAT(server_->Requests("/index.json"), SizeIs(6));
}

TEST_F(HttpSource, WhatIsNoLongerInTheIndexIsNotFetched) {
  Serve(Model(100));
  Open();
  server_->Put("/index.json", R"({"models":[]})");
  ASSERT_TRUE(source_->List().ok());
  const auto path = Fetch();
  EXPECT_TRUE(absl::IsNotFound(path.status()));
  EXPECT_EQ(base::ErrorInfoOf(path.status()).reason, "NOT_IN_INDEX");
  EXPECT_THAT(server_->Requests("/model.treeline"), IsEmpty());
}

class HttpsSource : public HttpSourceTest {
 protected:
  // A server whose certificate is for `ip_address`.
  void StartServer(const std::string& ip_address) {
    const TestAuthority authority = MakeAuthority(ip_address);
    server_ = std::make_unique<WebServer>(&authority);
    options_.url = server_->address() + "/";
    options_.http.ca_file = folder_ + "-ca.pem";
    ASSERT_TRUE(
        base::WriteFileAtomically(options_.http.ca_file, authority.ca_pem)
            .ok());
    Serve(Model(100000));
  }
  void TearDown() override {
    unlink(options_.http.ca_file.c_str());
    HttpSourceTest::TearDown();
  }
};

TEST_F(HttpsSource, AnAuthorityOfOnesOwnIsTrusted) {
  StartServer("127.0.0.1");
  const auto path = Fetch();
  ASSERT_TRUE(path.ok()) << path.status();
  EXPECT_EQ(base::ReadFile(*path).value(), model_);
}

TEST_F(HttpsSource, OtherAuthoritiesAreNot) {
  StartServer("127.0.0.1");
  ASSERT_TRUE(
      base::WriteFileAtomically(options_.http.ca_file,
                                MakeAuthority("127.0.0.1", "Another").ca_pem)
          .ok());
  EXPECT_EQ(base::ErrorInfoOf(Fetch().status()).reason, "SOURCE_UNTRUSTED");
  EXPECT_THAT(server_->Requests("/"), IsEmpty());
}

TEST_F(HttpsSource, NorIsACertificateForAnotherAddress) {
  StartServer("127.0.0.2");
  EXPECT_EQ(base::ErrorInfoOf(Fetch().status()).reason, "SOURCE_UNTRUSTED");
  EXPECT_THAT(server_->Requests("/"), IsEmpty());
}

TEST_F(HttpsSource, RedirectsToPlainHttpAreRefused) {
  StartServer("127.0.0.1");
  WebServer plain;
  plain.Put("/model", model_);
  server_->Put(
      "/model.treeline", "",
      {{.status = 302, .headers = {{"Location", plain.address() + "/model"}}}});
  const auto path = Fetch();
  EXPECT_EQ(base::ErrorInfoOf(path.status()).reason, "SOURCE_UNTRUSTED");
  EXPECT_THAT(plain.Requests("/"), IsEmpty());
}

// An index that must be signed.
class SignedSource : public HttpSourceTest {
 protected:
  void SetUp() override {
    HttpSourceTest::SetUp();
    options_.keys = std::make_shared<const repository::IndexKeys>(
        repository::IndexKeys::FromPem(key_.open).value());
    model_ = Model(1000);
    server_->Put("/model.treeline", model_);
  }
  // With `version` of kitchen, published then.
  void Publish(const std::string& version, uint64_t published,
               const std::string& secret) {
    repository::ModelIndex index{.models = {{.scene = "kitchen",
                                             .version = version,
                                             .bytes = model_.size(),
                                             .sha256 = DigestOf(model_),
                                             .url = "model.treeline"}},
                                 .scene_json = {},
                                 .published_unix_s = published,
                                 .signature = {}};
    if (!secret.empty()) {
      ASSERT_TRUE(repository::IndexSigner::FromPem(secret)->Sign(index).ok());
    }
    server_->Put("/index.json", repository::ModelIndexJson(index).value());
  }
  // The version that is listed; else why none is.
  std::string Listed() {
    const auto listing = source_->List();
    return listing.ok() ? listing->models.at(0).version
                        : base::ErrorInfoOf(listing.status()).reason;
  }

  const repository::TestKeyPair key_ = repository::MakeTestKeyPair();
  const std::string stranger_ = repository::MakeTestKeyPair().secret;
};

TEST_F(SignedSource, OnlyWhatIsSignedIsListed) {
  Publish("7", 100, "");
  Open();
  EXPECT_EQ(Listed(), "INDEX_UNSIGNED");
  Publish("7", 100, stranger_);
  EXPECT_EQ(Listed(), "INDEX_SIGNATURE_WRONG");
  Publish("7", 100, key_.secret);
  EXPECT_EQ(Listed(), "7");
  EXPECT_TRUE(Fetch().ok());
}

TEST_F(SignedSource, TheLastOneStandsInForOneThatIsNotBelieved) {
  Publish("7", 100, key_.secret);
  Open();
  EXPECT_EQ(Listed(), "7");
  Publish("8", 200, stranger_);
  EXPECT_EQ(Listed(), "7");
  EXPECT_THAT(warnings_.back(), HasSubstr("going on with the last index"));
  // After a restart, too.
  Open();
  EXPECT_EQ(Listed(), "7");
  Publish("8", 200, key_.secret);
  EXPECT_EQ(Listed(), "8");
}

TEST_F(SignedSource, AnOlderOneIsNotBelieved) {
  Publish("8", 200, key_.secret);
  Open();
  EXPECT_EQ(Listed(), "8");
  Publish("7", 100, key_.secret);
  EXPECT_EQ(Listed(), "8");
  EXPECT_THAT(warnings_.back(), HasSubstr("older than the last one"));
}

TEST_F(SignedSource, WhatWasKeptBeforeKeysWereAskedForMustBeSigned) {
  const auto keys = std::exchange(options_.keys, nullptr);
  Publish("7", 100, "");
  Open();
  EXPECT_EQ(Listed(), "7");
  options_.keys = keys;
  Open();
  EXPECT_EQ(Listed(), "INDEX_UNSIGNED");
}

TEST_F(HttpsSource, PlainHttpToOtherMachinesIsRefusedAtTheStart) {
  options_.url = "http://models.example/";
  EXPECT_TRUE(absl::IsInvalidArgument(
      repository::HttpModelSource::Open(options_, clock_).status()));
  options_.http.allow_plain_http = true;
  EXPECT_TRUE(repository::HttpModelSource::Open(options_, clock_).ok());
}

}  // namespace
}  // namespace treeline
