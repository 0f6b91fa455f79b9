// The published figures as text; see PublishedFor, which parses it.
#ifndef EVALUATION_ACCURACY_PUBLISHED_DATA_H_
#define EVALUATION_ACCURACY_PUBLISHED_DATA_H_

namespace treeline::accuracy {

// Lines of fields separated by " | "; a comment in the source names them. "-"
// is a figure that was not published.
const char* PublishedData();

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_PUBLISHED_DATA_H_
