#include "client/cli/watch_command.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "client/cli/connection_flags.h"
#include "client/cli/metrics_source.h"
#include "client/scrape/server_figures.h"
#include "client/scrape/watch_text.h"
#include "common/base/status_macros.h"

namespace treeline::client_cli {
namespace {

constexpr const char* kFooter = R"(
Reads the server's own metrics, so it asks nothing of it and adds no load. On a
terminal the view is drawn in place, elsewhere there is a line each time. A
server that goes away is waited for.

Examples:
  treeline-client watch http://127.0.0.1:8080
  treeline-client watch http://127.0.0.1:8080 --count 1

Exit codes: 0 done, 1 failed (no metrics at first, or none of a
treeline-server), 2 wrong usage, 130 interrupted.)";

constexpr size_t kMaxHistory = 500;
constexpr int kDefaultColumns = 80;
constexpr const char* kHome = "\x1b[H\x1b[J";
constexpr const char* kOtherScreen = "\x1b[?1049h\x1b[?25l";
constexpr const char* kOwnScreen = "\x1b[?25h\x1b[?1049l";

struct WatchFlags {
  std::string url;
  ConnectionFlags connection;
  double every_s = 1;
  int count = 0;  // 0: until interrupted
};

double UnixNow_s() {
  return std::chrono::duration<double>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

int Columns() {
  winsize size = {};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0
             ? size.ws_col
             : kDefaultColumns;
}

struct Look {
  scrape::MetricsSnapshot metrics;
  double at_unix_s = 0;
};

absl::StatusOr<Look> TakeLook(const MetricsSource& source) {
  TL_ASSIGN_OR_RETURN(const std::string text, source.Fetch());
  absl::StatusOr<scrape::MetricsSnapshot> metrics =
      scrape::MetricsSnapshot::Parse(text);
  if (!metrics.ok()) return base::Annotate(metrics.status(), source.url());
  if (!scrape::IsServer(*metrics)) {
    return absl::FailedPreconditionError(absl::StrCat(
        source.url(), " has metrics, but not those of a treeline-server"));
  }
  return Look{.metrics = *std::move(metrics), .at_unix_s = UnixNow_s()};
}

// Standard output, as a screen of its own or line by line.
class View {
 public:
  explicit View(std::string server)
      : server_(std::move(server)), terminal_(isatty(STDOUT_FILENO) == 1) {
    if (terminal_) std::fputs(kOtherScreen, stdout);
  }
  ~View() {
    if (!terminal_) return;
    std::fputs(kOwnScreen, stdout);
    // The last view stays to be read.
    std::fputs(last_.c_str(), stdout);
    std::fflush(stdout);
  }
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  // Whether it could be written.
  bool Show(const scrape::ServerFigures& figures) {
    history_.push_back(figures);
    if (history_.size() > kMaxHistory) history_.pop_front();
    if (!terminal_) {
      std::fprintf(stdout, "%s\n", scrape::WatchLine(figures).c_str());
      return FlushOutput();
    }
    last_ = scrape::WatchScreen(server_, history_, Columns());
    std::fprintf(stdout, "%s%s\n  Ctrl-C ends this.\n", kHome, last_.c_str());
    return FlushOutput();
  }

  bool ShowMissing(const absl::Status& why) {
    std::fprintf(terminal_ ? stdout : stderr, "%streeline-client: %s\n",
                 terminal_ ? kHome : "", std::string(why.message()).c_str());
    return FlushOutput();
  }

 private:
  const std::string server_;
  const bool terminal_;
  std::deque<scrape::ServerFigures> history_;
  std::string last_;
};

// Whether there was no stop.
bool Pause(double s, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, std::chrono::duration<double>(s),
                 [&] { return stop.stop_requested(); });
  return !stop.stop_requested();
}

int RunWatch(const WatchFlags& flags, const std::stop_token& stop) {
  const auto source =
      MetricsSource::Open(flags.url, ConnectOptionsOf(flags.connection));
  if (!source.ok()) {
    ReportLocalFailure(source.status());
    return kExitUsage;
  }
  absl::StatusOr<Look> before = TakeLook(*source);
  if (!before.ok()) return ReportLocalFailure(before.status());
  View view(source->url());
  for (int shown = 0; flags.count == 0 || shown < flags.count;) {
    if (!Pause(flags.every_s, stop)) return kExitInterrupted;
    absl::StatusOr<Look> now = TakeLook(*source);
    if (!now.ok()) {
      if (!view.ShowMissing(now.status())) return kExitFailed;
    } else if (before.ok() && now->at_unix_s > before->at_unix_s) {
      if (!view.Show(scrape::FiguresBetween(before->metrics, now->metrics,
                                            now->at_unix_s - before->at_unix_s,
                                            now->at_unix_s))) {
        return kExitFailed;
      }
      ++shown;
    }
    before = std::move(now);
  }
  return kExitLocalized;
}

}  // namespace

ClientCommand AddWatchCommand(CLI::App& app) {
  auto flags = std::make_shared<WatchFlags>();
  CLI::App* command =
      app.add_subcommand("watch", "Show how a server does, live");
  command->footer(kFooter);
  command
      ->add_option("url", flags->url,
                   "The server's HTTP listener: http://HOST:PORT")
      ->required()
      ->type_name("URL");
  AddSecurityFlags(*command, flags->connection);
  command->add_option("--every-s", flags->every_s, "Seconds between two looks")
      ->capture_default_str()
      ->check(CLI::Range(0.05, 3600.0));
  command
      ->add_option("--count", flags->count,
                   "So many views, and then the end; without: until Ctrl-C")
      ->check(CLI::Range(1, 1000000000));
  return {command, [flags](const std::stop_token& stop) {
            return RunWatch(*flags, stop);
          }};
}

}  // namespace treeline::client_cli
