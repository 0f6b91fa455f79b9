#include "common/http/static_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "common/base/file.h"

namespace treeline::http {
namespace {

namespace fs = std::filesystem;

class StaticFilesTest : public ::testing::Test {
 protected:
  StaticFilesTest()
      : root_(fs::path(testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::remove_all(root_);
    fs::create_directories(root_ / "page/assets");
    Put("page/index.html", "<html>");
    Put("page/assets/a.js", "1");
    Put("secret.txt", "secret");
    Put("page-beside.txt", "secret");
  }
  ~StaticFilesTest() override { fs::remove_all(root_); }

  void Put(const std::string& name, const std::string& bytes) const {
    ASSERT_TRUE(base::WriteNewFile((root_ / name).string(), bytes).ok());
  }
  StaticFiles Files() const { return StaticFiles((root_ / "page").string()); }

  const fs::path root_;
};

TEST_F(StaticFilesTest, ServesWhatIsThere) {
  EXPECT_EQ(Files().Get("/")->bytes, "<html>");
  EXPECT_EQ(Files().Get("/")->content_type, "text/html; charset=utf-8");
  EXPECT_EQ(Files().Get("/assets/a.js")->bytes, "1");
  EXPECT_EQ(Files().Get("/assets/a.js")->content_type,
            "text/javascript; charset=utf-8");
  EXPECT_TRUE(Files().HasPage());
}

TEST_F(StaticFilesTest, NothingLeadsOut) {
  fs::create_symlink(root_ / "secret.txt", root_ / "page/link.txt");
  fs::create_directory_symlink(root_, root_ / "page/up");
  for (const std::string& path :
       {std::string("/../secret.txt"), std::string("/assets/../../secret.txt"),
        std::string("/.."), std::string("/./index.html"),
        std::string("//secret.txt"), std::string("/..\\secret.txt"),
        std::string("secret.txt"), std::string("/link.txt"),
        std::string("/up/secret.txt"), std::string("/../page-beside.txt"),
        std::string("/index.html\0.js", 15), std::string("/assets"),
        std::string("/assets/"), std::string("/.hidden"), std::string(),
        std::string("/" + std::string(2000, 'a')),
        (root_ / "secret.txt").string()}) {
    EXPECT_TRUE(absl::IsNotFound(Files().Get(path).status())) << path;
  }
}

TEST_F(StaticFilesTest, WithoutAPageThereIsNone) {
  const StaticFiles none("");
  EXPECT_FALSE(none.HasPage());
  EXPECT_TRUE(absl::IsNotFound(none.Get("/").status()));
  const StaticFiles missing((root_ / "nothing").string());
  EXPECT_FALSE(missing.HasPage());
  EXPECT_TRUE(absl::IsNotFound(missing.Get("/").status()));
}

TEST_F(StaticFilesTest, APageThatWasBuiltIsFound) {
  const std::string built = (root_ / "page").string();
  EXPECT_EQ(FindPageFolder("no-such-page", built), built);
  EXPECT_EQ(FindPageFolder("no-such-page", (root_ / "nothing").string()), "");
}

}  // namespace
}  // namespace treeline::http
