#include "common/cli/arguments.h"

#include <cstdio>
#include <sstream>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "common/base/nearest_name.h"

namespace treeline::cli {
namespace {

constexpr int kUsage = 2;

// Help of at most 80 columns: CLI11 2.1 does not break lines itself.
class WrappingFormatter final : public CLI::Formatter {
 public:
  WrappingFormatter() { column_width(kColumn); }

  std::string make_description(const CLI::App* app) const override {
    return Wrapped(CLI::Formatter::make_description(app), kWidth);
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return Wrapped(CLI::Formatter::make_option_desc(option), kWidth - kColumn);
  }
  std::string make_subcommand(const CLI::App* command) const override {
    std::ostringstream out;
    CLI::detail::format_help(
        out, command->get_name(),
        Wrapped(command->get_description(), kWidth - kColumn), kColumn);
    return out.str();
  }

 private:
  static constexpr size_t kWidth = 80;
  static constexpr size_t kColumn = 28;

  static std::string Wrapped(const std::string& text, size_t width) {
    std::string wrapped;
    size_t column = 0;
    for (const absl::string_view word : absl::StrSplit(text, ' ')) {
      if (column > 0 && column + 1 + word.size() > width) {
        wrapped += '\n';
        column = 0;
      } else if (column > 0) {
        wrapped += ' ';
        ++column;
      }
      absl::StrAppend(&wrapped, word);
      column += word.size();
    }
    return wrapped;
  }
};

// "; did you mean --models?", or nothing. Names of options begin with dashes.
std::string Suggestion(absl::string_view unknown,
                       const std::vector<std::string>& known) {
  std::vector<std::string> keys;
  for (const std::string& name : known) {
    keys.push_back(absl::StrReplaceAll(name, {{"-", "_"}}));
  }
  const std::vector<absl::string_view> views(keys.begin(), keys.end());
  const std::string nearest = base::NearestName(unknown, views);
  for (size_t i = 0; i < keys.size(); ++i) {
    if (!nearest.empty() && keys[i] == nearest) {
      return absl::StrCat("; did you mean ", known[i], "?");
    }
  }
  return "";
}

std::vector<std::string> LongOptions(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      names.push_back("--" + name);
    }
  }
  return names;
}

std::vector<std::string> Commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command :
       app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

// Names what there is, where the last command that was given wants another;
// else empty.
std::string MissingCommand(const CLI::App& app) {
  const CLI::App* chosen = &app;
  while (!chosen->get_subcommands().empty()) {
    chosen = chosen->get_subcommands().front();
  }
  if (chosen->get_require_subcommand_min() == 0) return "";
  return absl::StrCat("a command of ", chosen->get_name(),
                      " is missing: ", absl::StrJoin(Commands(*chosen), ", "));
}

}  // namespace

std::shared_ptr<CLI::FormatterBase> HelpFormatter() {
  return std::make_shared<WrappingFormatter>();
}

std::string UnknownArgument(const CLI::App& app, int argc,
                            const char* const* argv) {
  const CLI::App* command = &app;
  bool is_value = false;  // of the option before
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") return "";
    if (absl::StartsWith(word, "--")) {
      const std::string name = word.substr(0, word.find('='));
      const CLI::Option* option = command->get_option_no_throw(name);
      if (option == nullptr) {
        return absl::StrCat("no option is called ", name,
                            Suggestion(name, LongOptions(*command)));
      }
      is_value = name == word && option->get_items_expected_max() > 0;
      continue;
    }
    if (is_value || absl::StartsWith(word, "-")) {
      is_value = false;
      continue;
    }
    const std::vector<std::string> commands = Commands(*command);
    if (std::ranges::find(commands, word) != commands.end()) {
      command = command->get_subcommand(word);
    } else if (command->get_require_subcommand_min() > 0) {
      return absl::StrCat("no command is called '", word, "'",
                          Suggestion(word, commands));
    }
  }
  return "";
}

std::optional<int> ParseArguments(CLI::App& app, int argc,
                                  const char* const* argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    // CLI11 first says what else is missing.
    std::string what;
    if (error.get_exit_code() != 0) what = UnknownArgument(app, argc, argv);
    if (what.empty() && dynamic_cast<const CLI::RequiredError*>(&error)) {
      what = MissingCommand(app);
    }
    if (what.empty()) return app.exit(error) == 0 ? 0 : kUsage;
    std::fprintf(stderr, "%s\nRun with --help for more information.\n",
                 what.c_str());
    return kUsage;
  }
}

}  // namespace treeline::cli
