#include "common/dataset/colmap_binary.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/dataset/colmap_builder.h"

namespace treeline::dataset {
namespace {

static_assert(std::endian::native == std::endian::little);

// COLMAP's numbers of its camera models.
constexpr camera::CameraModel kModels[] = {
    camera::CameraModel::kSimplePinhole,
    camera::CameraModel::kPinhole,
    camera::CameraModel::kSimpleRadial,
    camera::CameraModel::kRadial,
    camera::CameraModel::kOpenCv,
    camera::CameraModel::kOpenCvFisheye,
    camera::CameraModel::kFullOpenCv,
    camera::CameraModel::kFov,
    camera::CameraModel::kSimpleRadialFisheye,
    camera::CameraModel::kRadialFisheye,
    camera::CameraModel::kThinPrismFisheye};

// The least bytes that a record takes.
constexpr uint64_t kCameraBytes = 4 + 4 + 8 + 8;
constexpr uint64_t kImageBytes = 4 + 7 * 8 + 4 + 1 + 8;
constexpr uint64_t kObservationBytes = 2 * 8 + 8;
constexpr uint64_t kPointBytes = 8 + 3 * 8 + 3 + 8 + 8;
constexpr uint64_t kTrackElementBytes = 2 * 4;

// Walks through a file; a read beyond its end is an error.
class ByteReader {
 public:
  explicit ByteReader(const ColmapFile& file) : file_(file) {}

  ColmapPlace place() const { return {&file_, at_}; }
  uint64_t left() const { return file_.bytes.size() - at_; }

  template <typename T>
  absl::Status Read(T& value) {
    if (left() < sizeof(T)) {
      return place().Error(absl::StrCat("the file ends within ", sizeof(T),
                                        " bytes that belong here"));
    }
    std::memcpy(&value, file_.bytes.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return absl::OkStatus();
  }

  // A number of records, each of at least `record_bytes`, that fit in the
  // file.
  absl::Status ReadCount(const char* what, uint64_t record_bytes,
                         uint64_t& count) {
    const ColmapPlace start = place();
    TL_RETURN_IF_ERROR(Read(count));
    if (count <= left() / record_bytes) return absl::OkStatus();
    return start.Error(absl::StrCat(
        count, " ", what, " do not fit into the remaining ", left(), " bytes"));
  }

  // Up to a zero byte, which is skipped.
  absl::Status ReadName(absl::string_view& name) {
    const size_t end = file_.bytes.find('\0', at_);
    if (end == std::string::npos) {
      return place().Error("the file ends within the name of an image");
    }
    name = absl::string_view(file_.bytes).substr(at_, end - at_);
    at_ = end + 1;
    return absl::OkStatus();
  }

  absl::Status Skip(uint64_t bytes) {
    if (left() < bytes) return place().Error("the file ends early");
    at_ += bytes;
    return absl::OkStatus();
  }

  absl::Status CheckEnd() const {
    if (left() == 0) return absl::OkStatus();
    return place().Error(absl::StrCat(left(), " bytes follow the last record"));
  }

 private:
  const ColmapFile& file_;
  uint64_t at_ = 0;
};

absl::Status ReadCamera(ByteReader& reader, ColmapBuilder& builder) {
  const ColmapPlace place = reader.place();
  uint32_t id = 0;
  int32_t model = 0;
  uint64_t width = 0;
  uint64_t height = 0;
  TL_RETURN_IF_ERROR(reader.Read(id));
  TL_RETURN_IF_ERROR(reader.Read(model));
  TL_RETURN_IF_ERROR(reader.Read(width));
  TL_RETURN_IF_ERROR(reader.Read(height));
  if (model < 0 || static_cast<size_t>(model) >= std::size(kModels)) {
    return place.Error(absl::StrCat("camera ", id, " has model number ", model,
                                    ", which is not known"));
  }
  const camera::CameraModel known = kModels[model];
  std::vector<double> parameters(
      static_cast<size_t>(camera::CameraParameterCount(known)));
  for (double& parameter : parameters) {
    TL_RETURN_IF_ERROR(reader.Read(parameter));
  }
  return builder.AddCamera(place, id, known, width, height, parameters);
}

absl::Status ReadImage(ByteReader& reader, ColmapBuilder& builder) {
  const ColmapPlace place = reader.place();
  uint32_t id = 0;
  std::array<double, 7> pose{};
  uint32_t camera_id = 0;
  absl::string_view name;
  uint64_t count = 0;
  TL_RETURN_IF_ERROR(reader.Read(id));
  for (double& number : pose) TL_RETURN_IF_ERROR(reader.Read(number));
  TL_RETURN_IF_ERROR(reader.Read(camera_id));
  TL_RETURN_IF_ERROR(reader.ReadName(name));
  TL_RETURN_IF_ERROR(reader.ReadCount("keypoints", kObservationBytes, count));
  std::vector<ColmapBuilder::Observation> observations(count);
  for (ColmapBuilder::Observation& seen : observations) {
    TL_RETURN_IF_ERROR(reader.Read(seen.x));
    TL_RETURN_IF_ERROR(reader.Read(seen.y));
    TL_RETURN_IF_ERROR(reader.Read(seen.point_id));
  }
  return builder.AddImage(place, id, pose, camera_id, name, observations);
}

absl::Status ReadPoint(ByteReader& reader, ColmapBuilder& builder) {
  const ColmapPlace place = reader.place();
  uint64_t id = 0;
  geometry::Vec3 position;
  uint64_t count = 0;
  TL_RETURN_IF_ERROR(reader.Read(id));
  TL_RETURN_IF_ERROR(reader.Read(position.x));
  TL_RETURN_IF_ERROR(reader.Read(position.y));
  TL_RETURN_IF_ERROR(reader.Read(position.z));
  TL_RETURN_IF_ERROR(reader.Skip(3 + 8));  // colour, error
  TL_RETURN_IF_ERROR(
      reader.ReadCount("track elements", kTrackElementBytes, count));
  std::vector<ColmapBuilder::TrackElement> track(count);
  for (ColmapBuilder::TrackElement& element : track) {
    TL_RETURN_IF_ERROR(reader.Read(element.image_id));
    TL_RETURN_IF_ERROR(reader.Read(element.keypoint));
  }
  return builder.AddPoint(place, id, position, track);
}

// A count, and that many records to the end of the file.
absl::Status ReadRecords(const ColmapFile& file, const char* what,
                         uint64_t record_bytes,
                         absl::Status (*read)(ByteReader&, ColmapBuilder&),
                         ColmapBuilder& builder) {
  ByteReader reader(file);
  uint64_t count = 0;
  TL_RETURN_IF_ERROR(reader.ReadCount(what, record_bytes, count));
  for (uint64_t i = 0; i < count; ++i) {
    TL_RETURN_IF_ERROR(read(reader, builder));
  }
  return reader.CheckEnd();
}

}  // namespace

absl::Status ReadCamerasBinary(const ColmapFile& file, ColmapBuilder& builder) {
  return ReadRecords(file, "cameras", kCameraBytes, ReadCamera, builder);
}

absl::Status ReadImagesBinary(const ColmapFile& file, ColmapBuilder& builder) {
  return ReadRecords(file, "images", kImageBytes, ReadImage, builder);
}

absl::Status ReadPointsBinary(const ColmapFile& file, ColmapBuilder& builder) {
  return ReadRecords(file, "points", kPointBytes, ReadPoint, builder);
}

}  // namespace treeline::dataset
