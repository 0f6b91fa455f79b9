// Photographs or a video, made into a recording that method sift learns from.
#ifndef SERVER_TOOLS_PHOTOGRAPHS_IMPORT_PHOTOGRAPHS_H_
#define SERVER_TOOLS_PHOTOGRAPHS_IMPORT_PHOTOGRAPHS_H_

#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/tools/photographs/photographs.h"

namespace treeline::photographs {

struct PhotographOptions {
  std::string folder{};  // to write
  PictureOptions pictures{};
  // Metres per unit of the structure; 0: not known.
  double scale = 0;
  // "A.jpg,B.jpg,METRES": how far apart two pictures were taken. Empty: not
  // known.
  std::string distance{};
  std::string colmap = "colmap";  // the program
  bool quiet = false;

  absl::Status Validate() const;
};

struct ImportedPhotographs {
  std::string uri;  // colmap:FOLDER/model,FOLDER/images
  int pictures = 0;
  int registered = 0;
  int points = 0;
  int train = 0;
  int test = 0;
  bool is_metric = false;
  // What was taken for granted and what was left out.
  std::vector<std::string> notes;
};

// Writes
//   FOLDER/images/NAME.jpg      upright, without EXIF
//   FOLDER/model/               COLMAP's model: z up, in metres where the scale
//                               is known, which units.txt says then
//   FOLDER/train.txt, test.txt  of photographs every fifth is held out, of a
//                               video blocks
//   FOLDER/recording.txt        where it is from, what was left out
//
// FOLDER is there when all of it is, or not at all. ALREADY_EXISTS: it is there
// and not empty. FAILED_PRECONDITION, with what to do: COLMAP is not installed,
// finds no structure, or one of so few of the pictures that it is of little
// use. CANCELLED.
absl::StatusOr<ImportedPhotographs> ImportPhotographs(
    const std::string& source, const PhotographOptions& options,
    const std::stop_token& stop);

}  // namespace treeline::photographs

#endif  // SERVER_TOOLS_PHOTOGRAPHS_IMPORT_PHOTOGRAPHS_H_
