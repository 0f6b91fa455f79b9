// A query that is a picture and a few words: the body of POST /localize.
#ifndef SERVER_GATEWAY_PICTURE_QUERY_H_
#define SERVER_GATEWAY_PICTURE_QUERY_H_

#include "absl/status/statusor.h"
#include "common/http/http_message.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::gateway {

// Whether the content-type may be that of such a body: a form
// (multipart/form-data), or a picture, whose type counts for nothing: curl says
// application/x-www-form-urlencoded of any bytes.
bool MayBePicture(absl::string_view content_type);

// The body is the colour picture, or a form with it. Words come in the address
// (?scene=kitchen) or in the form, by the names of treeline-client's flags:
//
//   image, color      JPEG or PNG
//   depth             16-bit PNG, from the depth camera that the scene was
//                     recorded with
//   registered        true, false: depth pixel (x, y) sees what colour pixel
//                     (x, y) sees
//   depth_unit        metres per unit; 0.001
//   camera            MODEL,PARAMS of the picture, by COLMAP's names, pixel
//                     centres at integer coordinates
//   orientation       top, right, bottom, left: the side that is up
//   scene, candidate_scene (any number), model_version
//   min_confidence, seed
//
// INVALID_ARGUMENT (INVALID_REQUEST), naming the word: unknown ones, those that
// come twice, and values that are none. Pictures are not decoded here.
absl::StatusOr<v1::LocalizeRequest> ParsePictureQuery(
    const http::HttpRequest& http);

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_PICTURE_QUERY_H_
