// Accuracy that others published, to stand beside ours: always with the
// protocol it was measured with.
#ifndef EVALUATION_ACCURACY_PUBLISHED_RESULTS_H_
#define EVALUATION_ACCURACY_PUBLISHED_RESULTS_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace treeline::accuracy {

// One method's published figures on one scene.
struct PublishedResult {
  std::string method;
  std::string training;  // "RGB-D", "RGB", "SfM": what it learns from
  std::string query;     // "RGB-D" or "RGB": what it is asked with
  std::string source;    // "thesis, Table 4.3"
  std::string note;      // hardware and the like; may be empty
  std::string scene;     // "Red Kitchen", or "average" over the dataset
  // In [0, 100], of frames within 5 cm and 5 degrees.
  std::optional<double> correct_percent;
  std::optional<double> median_cm;
  std::optional<double> median_deg;
};

struct PublishedTable {
  std::string kind;      // "7scenes", "12scenes", "tum" or "cambridge"
  std::string dataset;   // "Microsoft 7-Scenes"
  std::string protocol;  // a sentence or two
  std::vector<PublishedResult> results;
};

// All that is known, in the order of the text.
std::vector<PublishedTable> PublishedTables();

// The table for a recording, by the scheme of its URI: "7scenes:", "12scenes:",
// "tum:"; "colmap:" and "nvm:" have Cambridge Landmarks. nullopt: none.
std::optional<PublishedTable> PublishedFor(absl::string_view dataset_uri);

// The scene of `table` that the recording's name tells ("7scenes-redkitchen" is
// "Red Kitchen"); empty if it tells none.
std::string SceneOf(const PublishedTable& table, absl::string_view dataset_uri);

// The rows of one scene ("average" for those over all).
std::vector<PublishedResult> ResultsFor(const PublishedTable& table,
                                        absl::string_view scene);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_PUBLISHED_RESULTS_H_
