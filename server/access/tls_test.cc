#include "server/access/tls.h"

#include <sys/stat.h>

#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/access/certificate_maker.h"
#include "server/access/fake_clocks.h"

namespace treeline::access {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int64_t kDay_s = 86400;

class CertificateFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "/tls-" +
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    options_ = {.certificate_file = folder_ + "/tls.crt",
                .key_file = folder_ + "/tls.key"};
    Put(first_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Put(const std::string& path, const std::string& bytes) {
    ASSERT_TRUE(base::WriteFileAtomically(path, bytes).ok());
    ASSERT_EQ(chmod(path.c_str(), 0600), 0);
  }
  void Put(const MadeCertificate& made) {
    Put(options_.certificate_file, made.certificate);
    Put(options_.key_file, made.key);
  }

  absl::StatusOr<std::unique_ptr<CertificateFiles>> Open() {
    return CertificateFiles::Open(
        options_, clock_, wall_,
        [this](TrustSeverity, const std::string& message) {
          log_.push_back(message);
        });
  }
  void NextPoll() { clock_.Advance(std::chrono::seconds(1)); }

  std::string folder_;
  TlsOptions options_;
  FakeClock clock_;
  FakeWallClock wall_{std::time(nullptr)};
  std::vector<std::string> log_;
  const MadeCertificate authority_ = MakeAuthority("Test CA");
  const MadeCertificate first_ = MakeCertificate(authority_, {});
  const MadeCertificate second_ = MakeCertificate(authority_, {});
};

TEST_F(CertificateFilesTest, TakeANewPairWithinTheInterval) {
  const auto files = Open();
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_EQ((*files)->Current()->certificate, first_.certificate);
  Put(second_);
  EXPECT_EQ((*files)->Current()->certificate, first_.certificate);
  NextPoll();
  EXPECT_EQ((*files)->Current()->certificate, second_.certificate);
  EXPECT_EQ((*files)->Current()->key, second_.key);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("read again")));
}

TEST_F(CertificateFilesTest, WaitForTheSecondFileOfAPair) {
  const auto files = Open();
  ASSERT_TRUE(files.ok());
  Put(options_.certificate_file, second_.certificate);
  for (int i = 0; i < 3; ++i) {
    NextPoll();
    EXPECT_EQ((*files)->Current()->certificate, first_.certificate);
    EXPECT_EQ((*files)->Current()->key, first_.key);
  }
  EXPECT_THAT(log_, ElementsAre(HasSubstr("not the key of")));
  Put(options_.key_file, second_.key);
  NextPoll();
  EXPECT_EQ((*files)->Current()->certificate, second_.certificate);
}

TEST_F(CertificateFilesTest, KeepWhatTheyHaveWhenFilesBreakOrVanish) {
  const auto files = Open();
  ASSERT_TRUE(files.ok());
  Put(options_.certificate_file, first_.certificate.substr(0, 200));
  NextPoll();
  EXPECT_EQ((*files)->Current()->certificate, first_.certificate);
  std::filesystem::remove(options_.certificate_file);
  NextPoll();
  EXPECT_EQ((*files)->Current()->certificate, first_.certificate);
}

TEST_F(CertificateFilesTest, DoNotReplaceAGoodCertificateByAnExpiredOne) {
  const auto files = Open();
  ASSERT_TRUE(files.ok());
  Put(MakeCertificate(authority_, {.ends_s = -10}));
  NextPoll();
  EXPECT_EQ((*files)->Current()->certificate, first_.certificate);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("it has expired")));
}

TEST_F(CertificateFilesTest, ReplaceAnExpiredCertificateByAnyOther) {
  Put(MakeCertificate(authority_, {.ends_s = -10}));
  const auto files = Open();
  ASSERT_TRUE(files.ok());
  EXPECT_THAT(log_, ElementsAre(HasSubstr("has expired")));
  Put(second_);
  NextPoll();
  EXPECT_EQ((*files)->Current()->certificate, second_.certificate);
}

TEST_F(CertificateFilesTest, SayInTimeThatACertificateEnds) {
  const auto files = Open();
  ASSERT_TRUE(files.ok());
  EXPECT_THAT(log_, IsEmpty());
  const int64_t end = (*files)->Current()->expires_unix_s;
  EXPECT_NEAR(static_cast<double>(end - wall_.UnixSeconds()), 90.0 * kDay_s,
              60);
  for (const int64_t left : {15, 13, 12, 6, 5, -1}) {
    wall_.Set(end - left * kDay_s - 10);
    NextPoll();
    (*files)->Current();
  }
  EXPECT_THAT(log_, ElementsAre(HasSubstr("in 13 days"), HasSubstr("in 6 days"),
                                HasSubstr("has expired")));
}

TEST_F(CertificateFilesTest, TellEachReaderOnceWhatIsNew) {
  const auto files = Open();
  ASSERT_TRUE(files.ok());
  CertificateFiles::Reader& a = (*files)->NewReader();
  EXPECT_NE(a.Next(), nullptr);
  EXPECT_EQ(a.Next(), nullptr);
  CertificateFiles::Reader& b = (*files)->NewReader();
  EXPECT_NE(b.Next(), nullptr);
  Put(second_);
  NextPoll();
  EXPECT_NE(b.Next(), nullptr);
  EXPECT_NE(a.Next(), nullptr);
  EXPECT_EQ(a.Next(), nullptr);
}

TEST_F(CertificateFilesTest, WarnOfAKeyThatEveryoneMayRead) {
  ASSERT_EQ(chmod(options_.key_file.c_str(), 0644), 0);
  ASSERT_TRUE(Open().ok());
  EXPECT_THAT(log_, ElementsAre(HasSubstr("chmod 600")));
}

TEST_F(CertificateFilesTest, SayWhatIsWrongBeforeTheServerStarts) {
  EXPECT_TRUE(options_.Validate().ok());
  options_.require_client_certificate = true;
  EXPECT_THAT(options_.Validate().message(), HasSubstr("nobody is named"));
  options_.client_ca_file = folder_ + "/none.crt";
  EXPECT_EQ(options_.Validate().code(), absl::StatusCode::kNotFound);
  Put(options_.client_ca_file, "nonsense");
  EXPECT_THAT(options_.Validate().message(), HasSubstr("none.crt"));
  options_.client_ca_file = "";
  options_.require_client_certificate = false;
  Put(options_.key_file, second_.key);
  EXPECT_THAT(options_.Validate().message(), HasSubstr("not the key of"));
  Put(options_.key_file, first_.certificate);
  EXPECT_THAT(options_.Validate().message(), HasSubstr("no private key"));
  options_.key_file = "";
  EXPECT_FALSE(options_.Validate().ok());
}

}  // namespace
}  // namespace treeline::access
