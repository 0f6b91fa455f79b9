#include "evaluation/fields/best_way.h"

#include <cmath>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::fields {
namespace {

using ::testing::HasSubstr;

template <typename Number>
std::string Bytes(std::initializer_list<Number> numbers) {
  std::string bytes;
  for (const Number number : numbers) {
    char raw[sizeof(Number)];
    std::memcpy(raw, &number, sizeof(Number));
    bytes.append(raw, sizeof(Number));
  }
  return bytes;
}

// As numpy.save writes it, version 1.
std::string Array(const std::string& type, const std::string& shape,
                  const std::string& numbers) {
  std::string header =
      absl::StrCat("{'descr': '", type,
                   "', 'fortran_order': False, 'shape': ", shape, ", }");
  while ((header.size() + 11) % 64 != 0) header += ' ';
  header += '\n';
  return absl::StrCat("\x93NUMPY", std::string("\1\0", 2),
                      Bytes<uint16_t>({static_cast<uint16_t>(header.size())}),
                      header, numbers);
}

TEST(BestWay, ReadsPathsAsTheChallengeDoes) {
  // Cell (29, 0): x = 29 * 0.15 - 4.575, y = 5.075.
  for (const std::string& bytes :
       {Array("<i8", "(2, 2)", Bytes<int64_t>({29, 0, 14, 29})),
        Array("<i4", "(2, 2)", Bytes<int32_t>({29, 0, 14, 29})),
        Array("<f8", "(2, 2)", Bytes<double>({29, 0, 14, 29})),
        Array("<f4", "(2, 2)", Bytes<float>({29, 0, 14, 29}))}) {
    const auto points = ParseBarnPath(bytes, "path_0.npy");
    ASSERT_TRUE(points.ok()) << points.status();
    ASSERT_EQ(points->size(), 2);
    EXPECT_NEAR((*points)[0].x, -0.225, 1e-12);
    EXPECT_NEAR((*points)[0].y, 5.075, 1e-12);
    EXPECT_NEAR((*points)[1].x, -2.475, 1e-12);
    EXPECT_NEAR((*points)[1].y, 9.425, 1e-12);
  }
}

TEST(BestWay, RefusesWhatIsNoPath) {
  const std::string good = Array("<i8", "(2, 2)", Bytes<int64_t>({1, 2, 3, 4}));
  for (const std::string& bytes :
       {std::string(), good.substr(0, 8), good.substr(0, 40),
        good.substr(0, good.size() - 1), absl::StrCat(good, "x"),
        Array(">i8", "(2, 2)", Bytes<int64_t>({1, 2, 3, 4})),
        Array("<i8", "(4,)", Bytes<int64_t>({1, 2, 3, 4})),
        Array("<i8", "(0, 2)", ""), Array("<i8", "(-1, 2)", ""),
        Array("<i8", "(99999999999, 2)", ""),
        Array("<f8", "(1, 2)", Bytes<double>({std::nan(""), 0}))}) {
    const auto points = ParseBarnPath(bytes, "path_0.npy");
    ASSERT_FALSE(points.ok()) << bytes;
    EXPECT_THAT(std::string(points.status().message()),
                HasSubstr("path_0.npy: "));
  }
}

TEST(BestWay, LiesBesideTheWorldsFile) {
  EXPECT_EQ(PathFileBeside("a/BARN/world_17.world"),
            "a/BARN/path_files/path_17.npy");
  EXPECT_EQ(PathFileBeside("world_3.world"), "path_files/path_3.npy");
  EXPECT_EQ(PathFileBeside("a/mine.world"), "");
  EXPECT_EQ(PathFileBeside("a/world_x.world"), "");
}

TEST(BestWay, GoesAlongThePathFromStartToGoal) {
  const base::TestingFolder folder;
  const std::string path = "path_files/path_5.npy";
  folder.Write(path, Array("<i8", "(2, 2)", Bytes<int64_t>({15, 0, 15, 29})));
  const std::string world = folder.Path("world_5.world");
  // The column's middle is at x = -2.325: beside start and goal by 0.075 m.
  const auto way = FindBestWay(world, {-2.25, 3}, {-2.25, 13});
  ASSERT_TRUE(way.ok()) << way.status();
  EXPECT_EQ(way->source, BestWaySource::kPathFile);
  EXPECT_NEAR(way->length_m,
              std::hypot(0.075, 2.075) + 29 * 0.15 + std::hypot(0.075, 3.575),
              1e-9);
  const auto straight =
      FindBestWay(folder.Path("world_6.world"), {-2.25, 3}, {-2.25, 13});
  ASSERT_TRUE(straight.ok()) << straight.status();
  EXPECT_EQ(straight->source, BestWaySource::kStraightLine);
  EXPECT_DOUBLE_EQ(straight->length_m, 10);
  folder.Write(path, "no array");
  EXPECT_FALSE(FindBestWay(world, {-2.25, 3}, {-2.25, 13}).ok());
}

}  // namespace
}  // namespace treeline::fields
