// GeoPose Protocol, version 2, of Open AR Cloud: its JSON, read and written.
// https://github.com/OpenArCloud/oscp-geopose-protocol
#ifndef SERVER_GATEWAY_GPP_MESSAGE_H_
#define SERVER_GATEWAY_GPP_MESSAGE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/gateway/geo_pose.h"
#include "treeline/v1/frame.pb.h"

namespace treeline::gateway {

// Where the client assumes to be.
struct GppHint {
  GeodeticPosition position;
  // How far that may be from the truth.
  double radius_m = 0;
};

struct GppRequest {
  // Comes back with the answer.
  std::string id = {};
  // Of the picture, milliseconds since 1970; comes back with the answer, for
  // that is when the pose was right.
  double timestamp_ms = 0;
  v1::Frame frame = {};
  // From geolocationReadings and priorPoses.
  std::vector<GppHint> hints = {};
};

// Reads the newest picture of cameraReadings, the DEPTH reading that belongs to
// it (at most 50 ms apart), and what the client knows of its position.
//
//   imageBytes        base64, with or without a data: prefix. A JPEG or PNG is
//                     recognised by its first bytes whatever imageFormat says;
//                     otherwise RGBA32 and GRAY8 are raw rows from the top, of
//                     `size`
//   DEPTH             16-bit PNG, or raw little-endian 16 bit; millimetres
//                     along the optical axis. With params at either reading it
//                     is registered to the picture, of the same size; without
//                     any, both are from the cameras that the scene was
//                     recorded with
//   params            a camera model by COLMAP's name and parameter order; its
//                     pixel centres lie at (0.5, 0.5), ours at (0, 0): half a
//                     pixel is taken off the principal point. UNKNOWN or
//                     absent: the camera of the scene
//   imageOrientation  rotation: degrees clockwise until the picture is upright.
//                     A guess, for the protocol says no more than that a camera
//                     provides it; 0 says nothing. Size, params and the answer
//                     are those of the picture as it is sent. A DEPTH reading
//                     has the same or none. mirrored is refused: no camera has
//                     the pose of such a picture
//   accuracy          of a geolocation, metres at 1 sigma, 0 if unknown
//
// Fields that are not used need not be there; unknown ones are passed over.
// INVALID_ARGUMENT (INVALID_REQUEST), naming the field, for all others that are
// missing or wrong. Pictures are not decoded here.
absl::StatusOr<GppRequest> ParseGppRequest(absl::string_view json);

// {id, timestamp, type, accuracy, geopose}.
std::string GppAnswerJson(const GppRequest& request, const GeoPose& pose,
                          const GeoAccuracy& accuracy);

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_GPP_MESSAGE_H_
