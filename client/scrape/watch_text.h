// The live view of a server, for a terminal.
#ifndef CLIENT_SCRAPE_WATCH_TEXT_H_
#define CLIENT_SCRAPE_WATCH_TEXT_H_

#include <deque>
#include <string>

#include "client/scrape/server_figures.h"

namespace treeline::scrape {

// One screen of `columns` (at least 40), lines ended by '\n', without control
// characters: the figures, bars for queue and workers, and the course of
// answers and latency over `history`, the latest last and among it.
std::string WatchScreen(const std::string& server,
                        const std::deque<ServerFigures>& history, int columns);

// The same in a line, for logs and pipes.
std::string WatchLine(const ServerFigures& figures);

// One character a value, from ' ' for 0 to a full block for the largest; NaN
// is ' ' too. The last `width` values.
std::string Sparkline(const std::deque<double>& values, int width);

}  // namespace treeline::scrape

#endif  // CLIENT_SCRAPE_WATCH_TEXT_H_
