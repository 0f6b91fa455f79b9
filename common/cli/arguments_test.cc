#include "common/cli/arguments.h"

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "gtest/gtest.h"

namespace treeline::cli {
namespace {

// A program with the commands ask (--server, needed; --seed) and map, which has
// commands of its own.
class ArgumentsTest : public testing::Test {
 protected:
  ArgumentsTest() {
    app_.require_subcommand(1);
    CLI::App* ask = app_.add_subcommand("ask", "");
    ask->add_option("--server", server_, "")->required();
    ask->add_option("--depth-unit", depth_unit_, "");
    ask->add_flag("--quiet", quiet_, "");
    CLI::App* map = app_.add_subcommand("map", "");
    map->require_subcommand(1);
    map->add_subcommand("save", "");
  }
  std::string Unknown(std::vector<const char*> arguments) const {
    arguments.insert(arguments.begin(), "program");
    return UnknownArgument(app_, static_cast<int>(arguments.size()),
                           arguments.data());
  }
  std::optional<int> Parse(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "program");
    return ParseArguments(app_, static_cast<int>(arguments.size()),
                          arguments.data());
  }

  CLI::App app_;
  std::string server_;
  double depth_unit_ = 1;
  bool quiet_ = false;
};

TEST_F(ArgumentsTest, AMisspeltOptionIsNamedThoughAnotherIsMissing) {
  EXPECT_EQ(Unknown({"ask", "--sever", "a:1"}),
            "no option is called --sever; did you mean --server?");
  EXPECT_EQ(Unknown({"ask", "--depth_unit=2"}),
            "no option is called --depth_unit; did you mean --depth-unit?");
  EXPECT_EQ(Unknown({"ask", "--server", "a:1", "--frobnicate"}),
            "no option is called --frobnicate");
  testing::internal::CaptureStderr();
  EXPECT_EQ(Parse({"ask", "--sever", "a:1"}), 2);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "no option is called --sever; did you mean --server?\n"
            "Run with --help for more information.\n");
}

TEST_F(ArgumentsTest, CommandsThatAreMissingAreNamed) {
  const auto told = [this](const std::vector<const char*>& arguments) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(Parse(arguments), 2);
    const std::string text = testing::internal::GetCapturedStderr();
    return text.substr(0, text.find('\n'));
  };
  EXPECT_EQ(told({"map"}), "a command of map is missing: save");
  EXPECT_EQ(told({"ask"}), "--server is required");
}

TEST_F(ArgumentsTest, AMisspeltCommandIsNamed) {
  EXPECT_EQ(Unknown({"aks"}), "no command is called 'aks'; did you mean ask?");
  EXPECT_EQ(Unknown({"map", "sav"}),
            "no command is called 'sav'; did you mean save?");
}

TEST_F(ArgumentsTest, ValuesAreNoCommandsAndWhatIsKnownIsNot) {
  EXPECT_EQ(Unknown({"ask", "--server", "save", "--depth-unit", "-1"}), "");
  EXPECT_EQ(Unknown({"ask", "--quiet", "--", "--what"}), "");
  EXPECT_EQ(Unknown({"map", "save"}), "");
  EXPECT_EQ(Unknown({}), "");
  EXPECT_EQ(Parse({"ask", "--server", "a:1"}), std::nullopt);
  EXPECT_EQ(server_, "a:1");
}

}  // namespace
}  // namespace treeline::cli
