// The published figures as text; see PublishedFor, which parses it.
#ifndef SERVER_TOOLS_PUBLISHED_DATA_H_
#define SERVER_TOOLS_PUBLISHED_DATA_H_

namespace treeline {

// Lines of fields separated by " | "; a comment in the source names them. "-"
// is a figure that was not published.
const char* PublishedData();

}  // namespace treeline

#endif  // SERVER_TOOLS_PUBLISHED_DATA_H_
