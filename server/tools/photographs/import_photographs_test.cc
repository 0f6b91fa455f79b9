#include "server/tools/photographs/import_photographs.h"

#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/dataset/dataset.h"
#include "common/dataset/trajectory_error.h"
#include "common/image/decode.h"
#include "common/image/quarter_turn.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/testing_captures.h"
#include "server/tools/photographs/structure_from_motion.h"
#include "server/tools/photographs/testing_walk.h"

namespace treeline::photographs {
namespace {

using testing::Contains;
using testing::HasSubstr;

class ImportPhotographsTest : public testing::Test {
 protected:
  void PutPicture(const std::string& path) const {
    image::ColorImage picture{64, 48, {}};
    picture.rgb.assign(3 * 64 * 48, 90);
    folder_.Write(path, *image::EncodeJpeg(picture, 90));
  }
  void PutPictures(int count) const {
    for (int i = 0; i < count; ++i) {
      PutPicture(absl::StrFormat("photos/p%02d.jpg", i));
    }
  }
  // A program in COLMAP's place, whose mapper places `placed` pictures in a row
  // along x, a unit apart, level, with y down. What transforms a model copies
  // it.
  std::string FakeColmap(int placed) const {
    std::string images;
    for (int i = 0; i < placed; ++i) {
      absl::StrAppendFormat(&images, "%d 1 0 0 0 %d 0 0 1 p%02d.jpg\n\n", i + 1,
                            -i, i);
    }
    folder_.Write("model/images.txt", images);
    folder_.Write("model/cameras.txt", "1 SIMPLE_RADIAL 64 48 60 32 24 0\n");
    folder_.Write("model/points3D.txt", "");
    const std::string program = folder_.Write(
        "colmap",
        absl::StrCat("#!/bin/sh\nfor a; do [ \"$last\" = --output_path ] && "
                     "out=$a; last=$a; done\n"
                     "case $1 in mapper) mkdir -p $out/0; cp ",
                     folder_.Path("model"),
                     "/*.txt $out/0;;\nmodel_transformer) cp ",
                     folder_.Path("model"), "/*.txt $out;; esac\n"));
    chmod(program.c_str(), 0755);
    return program;
  }
  absl::StatusOr<ImportedPhotographs> Import(
      PhotographOptions options, const std::stop_token& stop = {},
      const std::string& source = "photos") const {
    options.folder = folder_.Path("out");
    options.quiet = true;
    return ImportPhotographs(folder_.Path(source), options, stop);
  }

  // Of stems whose `digits` digits from `first` on are the number in `truth`.
  static void ExpectTruePoses(const dataset::Dataset& frames,
                              const std::vector<geometry::Rigid3>& truth,
                              size_t first, size_t digits) {
    std::vector<dataset::PosePair> pairs;
    for (int i = 0; i < frames.size(); ++i) {
      const int picture = std::stoi(frames.frame(i).stem.substr(first, digits));
      pairs.push_back({.time = i,
                       .estimate = *frames.frame(i).world_from_camera,
                       .reference = truth[static_cast<size_t>(picture)]});
      // z is up.
      const geometry::Vec3 up =
          pairs.back().estimate.rotation * geometry::Vec3{0, -1, 0};
      EXPECT_GT(up.z, 0.95);
    }
    const auto error = dataset::AbsoluteTrajectoryError(
        pairs, dataset::TrajectoryAlignment::kRigid);
    ASSERT_TRUE(error.has_value());
    EXPECT_LT(error->position_m.rmse, 0.03);
  }

  const base::TestingFolder folder_;
};

TEST_F(ImportPhotographsTest, WhatItWritesIsADatasetWithLists) {
  PutPictures(20);
  const auto imported = Import({.colmap = FakeColmap(20)});
  ASSERT_TRUE(imported.ok()) << imported.status();
  EXPECT_EQ(imported->registered, 20);
  EXPECT_EQ(imported->train, 16);
  EXPECT_EQ(imported->test, 4);
  EXPECT_FALSE(imported->is_metric);
  EXPECT_THAT(imported->notes, Contains(HasSubstr("arbitrary unit")));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("out/work")));
  const auto dataset = dataset::Dataset::Open(
      {.uri = imported->uri, .frame_list = folder_.Path("out/test.txt")});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->size(), 4);
  EXPECT_FALSE(dataset->units_are_metres());
  EXPECT_TRUE(dataset->Load(0).ok());
}

TEST_F(ImportPhotographsTest, WithADistanceItIsInMetres) {
  PutPictures(10);
  const auto imported =
      Import({.distance = "p00.jpg,p04.jpg,2", .colmap = FakeColmap(10)});
  ASSERT_TRUE(imported.ok()) << imported.status();
  EXPECT_TRUE(imported->is_metric);
  EXPECT_THAT(imported->notes, Contains(HasSubstr("scaled by 0.5")));
  const auto dataset = dataset::Dataset::Open({.uri = imported->uri});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_TRUE(dataset->units_are_metres());
}

TEST_F(ImportPhotographsTest, ADistanceNamesPicturesAsTheCaptureDoes) {
  for (int i = 0; i < 10; ++i)
    PutPicture(absl::StrFormat("phone/p%02d.JPG", i));
  const auto imported = Import(
      {.distance = "p00.JPG,p04.JPG,2", .colmap = FakeColmap(10)}, {}, "phone");
  ASSERT_TRUE(imported.ok()) << imported.status();
  EXPECT_TRUE(imported->is_metric);
}

TEST_F(ImportPhotographsTest, ADistanceOfNoPictureIsToldBeforeTheStructure) {
  PutPictures(10);
  const auto imported =
      Import({.distance = "p00.jpg,q04.jpg,2", .colmap = FakeColmap(0)});
  EXPECT_EQ(imported.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(imported.status().message(), HasSubstr("no picture q04.jpg"));
}

TEST_F(ImportPhotographsTest, FewPlacedPicturesAreToldOrRefused) {
  PutPictures(40);
  const auto few = Import({.colmap = FakeColmap(9)});
  EXPECT_EQ(few.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(few.status().message(), HasSubstr("only 9 of the 40 pictures"));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("out")));
  const auto some = Import({.colmap = FakeColmap(30)});
  ASSERT_TRUE(some.ok()) << some.status();
  EXPECT_THAT(some->notes, Contains(HasSubstr("10 of the 40 pictures")));
}

// A folder as an iPhone leaves it.
TEST_F(ImportPhotographsTest, HeicAloneIsRefusedWithWhatToInstall) {
  for (const char* name : {"a.HEIC", "b.HEIC", "c.HEIC"}) {
    folder_.Write(absl::StrCat("photos/", name), "HEIC");
  }
  const absl::Status status =
      Import({.pictures = {.heif_convert = "no-such-program"},
              .colmap = FakeColmap(3)})
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(status.message(), HasSubstr("3 pictures are HEIC"));
  EXPECT_THAT(status.message(), HasSubstr("libheif-examples"));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("out")));
}

TEST_F(ImportPhotographsTest, WrongScalesAreRefusedBeforeTheWork) {
  PutPictures(3);
  EXPECT_THAT(Import({.scale = -1}).status().message(), HasSubstr("--scale"));
  EXPECT_THAT(Import({.distance = "a.jpg,b.jpg"}).status().message(),
              HasSubstr("--distance takes"));
  EXPECT_THAT(Import({.distance = "a.jpg,b.jpg,far"}).status().message(),
              HasSubstr("--distance takes"));
  EXPECT_THAT(
      Import({.scale = 1, .distance = "a.jpg,b.jpg,2"}).status().message(),
      HasSubstr("not both"));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("out")));
}

TEST_F(ImportPhotographsTest, StoppingLeavesNothing) {
  PutPictures(3);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(
      Import({.colmap = FakeColmap(3)}, stop.get_token()).status()));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("out")));
}

// The real program on rendered photographs of a room, whose poses are known.
TEST_F(ImportPhotographsTest, ColmapFindsTheTruePosesOfARoom) {
  if (!FindColmap("colmap").ok()) GTEST_SKIP() << "COLMAP is not installed";
  constexpr int kPictures = 14;
  std::vector<geometry::Rigid3> truth;
  for (int i = 0; i < kPictures; ++i) {
    // Sideways along a wall and back, at two heights.
    truth.push_back(AlongTheWall(-1.2 + 2.4 * (i % 7) / 6.0, 0.15 * std::sin(i),
                                 i < 7 ? -0.3 : 0.4));
    folder_.Write(
        absl::StrFormat("photos/p%02d.jpg", i),
        *image::EncodeJpeg(PictureOfRoom(truth.back(), 480, 360), 95));
  }
  const double apart_m =
      geometry::Norm(truth[0].translation - truth[6].translation);
  const auto imported =
      Import({.distance = absl::StrFormat("p00.jpg,p06.jpg,%.9f", apart_m)});
  ASSERT_TRUE(imported.ok()) << imported.status();
  EXPECT_GE(imported->registered, 12);
  const auto dataset = dataset::Dataset::Open({.uri = imported->uri});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ExpectTruePoses(*dataset, truth, 1, 2);
}

// A walk, filmed with a phone that was held upright: what is stored lies on its
// side.
TEST_F(ImportPhotographsTest, ColmapFindsTheTruePosesOfAVideo) {
  if (!FindColmap("colmap").ok()) GTEST_SKIP() << "COLMAP is not installed";
  constexpr int kFrames = 24;
  std::vector<geometry::Rigid3> truth;
  std::vector<image::ColorImage> stored;
  for (int i = 0; i < kFrames; ++i) {
    truth.push_back(AlongTheWall(-1.2 + 2.4 * i / (kFrames - 1),
                                 0.15 * std::sin(0.5 * i),
                                 0.3 * std::sin(0.3 * i)));
    stored.push_back(image::Turned(PictureOfRoom(truth.back(), 360, 480),
                                   image::QuarterTurn::kCounterclockwise));
  }
  capture::WriteVideo(stored, image::QuarterTurn::kClockwise,
                      folder_.Path("walk.mp4"));
  const double apart_m =
      geometry::Norm(truth[0].translation - truth[20].translation);
  PhotographOptions options;
  options.distance =
      absl::StrFormat("frame-000000.jpg,frame-000020.jpg,%.9f", apart_m);
  const auto imported = Import(options, {}, "walk.mp4");
  ASSERT_TRUE(imported.ok()) << imported.status();
  EXPECT_GE(imported->registered, 20);
  const auto dataset = dataset::Dataset::Open({.uri = imported->uri});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->Load(0)->color.height, 480);
  ExpectTruePoses(*dataset, truth, 6, 6);
}

}  // namespace
}  // namespace treeline::photographs
