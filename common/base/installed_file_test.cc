#include "common/base/installed_file.h"

#include "common/base/testing_folder.h"
#include "gtest/gtest.h"

namespace treeline::base {
namespace {

// This test is not installed: no file lies beside it.
TEST(FindInstalledFile, TakesThePlaceInTheSourcesElse) {
  const TestingFolder folder;
  folder.Write("model", "bytes");
  EXPECT_EQ(FindInstalledFile("models/none", folder.Path("model")),
            folder.Path("model"));
  EXPECT_EQ(FindInstalledFile("models/none", folder.Path("nowhere")), "");
  // A folder is no file.
  EXPECT_EQ(FindInstalledFile("models/none", folder.Path("")), "");
}

}  // namespace
}  // namespace treeline::base
