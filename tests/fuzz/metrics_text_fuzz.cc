// What a server says of itself: parsed, and shown.
#include <cstddef>
#include <cstdint>
#include <string>

#include "client/scrape/metrics_text.h"
#include "client/scrape/server_figures.h"
#include "client/scrape/watch_text.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace treeline::scrape;
  const auto snapshot =
      MetricsSnapshot::Parse({reinterpret_cast<const char*>(data), size});
  if (!snapshot.ok()) return 0;
  const MetricsSnapshot none;
  const ServerFigures figures = FiguresBetween(none, *snapshot, 1, 1000);
  const std::string screen = WatchScreen("host", {figures, figures}, 80);
  for (const char c : screen) {
    if (c != '\n' && static_cast<unsigned char>(c) < ' ') __builtin_trap();
  }
  return WatchLine(figures).empty();
}
