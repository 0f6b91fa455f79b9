// The arguments of a program, as CLI11 reads them: help of at most 80 columns,
// and what a misspelt option or command was probably meant to be.
#ifndef COMMON_CLI_ARGUMENTS_H_
#define COMMON_CLI_ARGUMENTS_H_

#include <memory>
#include <optional>
#include <string>

namespace CLI {
class App;
class FormatterBase;
}  // namespace CLI

namespace treeline::cli {

// To be set before commands are added, which take it over.
std::shared_ptr<CLI::FormatterBase> HelpFormatter();

// The first argument that is neither an option nor a command where it stands,
// with what is like it: "no option is called --modles; did you mean --models?".
// Empty if all are known.
std::string UnknownArgument(const CLI::App& app, int argc,
                            const char* const* argv);

// nullopt: the program goes on. Else all has been said, and this is the exit
// code: 0 after --help and --version, 2 after wrong usage.
std::optional<int> ParseArguments(CLI::App& app, int argc,
                                  const char* const* argv);

}  // namespace treeline::cli

#endif  // COMMON_CLI_ARGUMENTS_H_
