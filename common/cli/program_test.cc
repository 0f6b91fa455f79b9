#include "common/cli/program.h"

#include <array>
#include <string>

#include "CLI/CLI.hpp"
#include "gtest/gtest.h"

namespace treeline::cli {
namespace {

// Once: RunProgram takes the process's signals.
TEST(RunProgram, ErrorsNameAllCommandsThatWereChosen) {
  std::array<std::string, 3> words = {"program", "log", "convert"};
  std::array<char*, 4> arguments = {words[0].data(), words[1].data(),
                                    words[2].data(), nullptr};
  testing::internal::CaptureStderr();
  const int code = RunProgram(
      {"program", "What it does"},
      [](CLI::App& app) {
        CLI::App* group = app.add_subcommand("log", "");
        group->require_subcommand(1);
        CLI::App* convert = group->add_subcommand("convert", "");
        return std::vector<Command>{{convert, [](const std::stop_token&) {
                                       return absl::NotFoundError("no file");
                                     }}};
      },
      3, arguments.data());
  EXPECT_EQ(code, 1);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "program log convert: no file\n");
}

}  // namespace
}  // namespace treeline::cli
