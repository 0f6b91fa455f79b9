// For tests: captures of one room in every format, with known truth.
#ifndef SERVER_TOOLS_CAPTURE_TESTING_CAPTURES_H_
#define SERVER_TOOLS_CAPTURE_TESTING_CAPTURES_H_

#include <string>
#include <utility>
#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"
#include "common/image/image.h"
#include "common/image/orientation.h"

namespace treeline::capture {

// The box room of server/core/training, in a world with z up, seen by a phone
// whose depth map is smaller than its picture.
struct TrueScene {
  camera::RgbdCalibration calibration;  // ours: pixel centres at integers
  std::vector<geometry::Rigid3> world_from_camera;
  std::vector<image::Frame> frames;
};

// With the phone upside up, its long side along the floor.
TrueScene MakeTrueScene(int frames);

// Each writes the scene as an app would, by the app's own conventions, written
// here once more and not with the readers' code.
void WriteNerfstudio(const TrueScene& scene, const std::string& folder);
// With a folder of pictures in place of a video, or with a video.
void WriteStray(const TrueScene& scene, const std::string& folder);
void WriteStrayVideo(const TrueScene& scene, const std::string& folder);
// The pictures as an MP4 file that players show turned.
void WriteVideo(const std::vector<image::ColorImage>& pictures,
                image::QuarterTurn shown_turn, const std::string& path);
void WritePolycam(const TrueScene& scene, const std::string& folder);
void WriteScannerApp(const TrueScene& scene, const std::string& folder);
// As an unpacked folder, with depth in raw blocks of LZFSE.
void WriteRecord3d(const TrueScene& scene, const std::string& folder);
void WriteScanNet(const TrueScene& scene, const std::string& folder);

// A zip file of these names and contents, deflated.
std::string ZipOf(
    const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_TESTING_CAPTURES_H_
