#include "server/tools/dataset_flags.h"

#include "CLI/CLI.hpp"

namespace treeline::tools {

CLI::Option* AddDatasetFlags(CLI::App& app, dataset::DatasetOptions& options) {
  constexpr const char* kGroup = "Recording";
  CLI::Option* dataset = app.add_option(
      "--dataset", options.uri,
      "7scenes:DIR (DIR holds seq-01, ...), 12scenes:DIR (info.txt "
      "and data), tum:DIR (rgb.txt and depth.txt), "
      "colmap:MODEL_DIR,IMAGES_DIR or nvm:FILE");
  dataset->type_name("URI")->required()->group(kGroup);
  app.add_option("--frames", options.frame_list,
                 "File with one frame a line (seq-01/frame-000123; for TUM "
                 "the colour time stamp); without it, all frames")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--poses", options.pose_file,
                 "File with poses instead of the recording's own: lines 'stem "
                 "qw qx qy qz tx ty tz [f]', world to colour camera")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--color-camera", options.color_camera,
                 "Colour camera, as MODEL,p1,p2,... with COLMAP's names: "
                 "PINHOLE,525,525,320,240")
      ->type_name("CAMERA")
      ->group(kGroup);
  app.add_option("--depth-camera", options.depth_camera,
                 "Depth camera, in the same form (7scenes)")
      ->type_name("CAMERA")
      ->group(kGroup);
  app.add_option("--depth-unit", options.depth_unit_m,
                 "Metres per unit of the depth images (default: 0.001 for "
                 "7scenes, 0.0002 for tum)")
      ->type_name("M")
      ->group(kGroup);
  app.add_option("--max-time-difference", options.max_time_difference_s,
                 "Entries less than this apart in time belong together (tum)")
      ->type_name("S")
      ->capture_default_str()
      ->group(kGroup);
  return dataset;
}

}  // namespace treeline::tools
