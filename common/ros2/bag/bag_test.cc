// One recording in every kind of file, and what is no recording.
#include "common/ros2/bag/bag.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/ros2/bag/open_bag.h"
#include "common/ros2/bag/testing_bags.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::bag {
namespace {

using ::testing::HasSubstr;

constexpr int kPictures = 30;
constexpr int64_t kStart_ns = 1'700'000'000'000'000'000;

messages::Image Picture(int i) {
  messages::Image image;
  image.header.stamp = messages::TimeOf(kStart_ns + i);
  image.header.frame_id = "camera";
  image.encoding = "mono8";
  image.width = 50;
  image.height = 40;
  image.step = 50;
  for (int p = 0; p < 2000; ++p) {
    image.data.push_back(static_cast<uint8_t>(p * (i + 1)));
  }
  return image;
}

messages::TFMessage Transform(int i) {
  messages::TransformStamped transform;
  transform.header.frame_id = "odom";
  transform.child_frame_id = "base";
  transform.transform.translation.x = i;
  return {.transforms = {transform}};
}

std::vector<TestingMessage> Recording() {
  std::vector<TestingMessage> recording;
  for (int i = 0; i < kPictures; ++i) {
    const int64_t time_ns = kStart_ns + 1000 * i;
    recording.push_back(Recorded("/image_raw", time_ns, Picture(i)));
    recording.push_back(Recorded("/tf", time_ns + 1, Transform(i)));
  }
  return recording;
}

struct Case {
  const char* name;
  const char* file;
  std::function<void(const std::string& path)> write;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class BagTest : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override { GetParam().write(path_); }

  const base::TestingFolder folder_;
  const std::string path_ = folder_.Path(GetParam().file);
};

TEST_P(BagTest, GivesItsMessagesInOrderAndAgain) {
  ASSERT_TRUE(IsBag(path_));
  auto bag = OpenBag(path_);
  ASSERT_TRUE(bag.ok()) << bag.status();
  ASSERT_EQ((*bag)->topics().size(), 2U);
  std::vector<BagPlace> places;
  int transforms = 0;
  const absl::Status status =
      (*bag)->Read([&](const BagMessage& message) -> absl::Status {
        const BagTopic& topic = (*bag)->topics()[message.topic];
        const int i = static_cast<int>(places.size());
        if (topic.name == "/image_raw") {
          EXPECT_EQ(message.time_ns, kStart_ns + 1000 * i);
          const auto header = DecodeHeader(topic, message.bytes);
          EXPECT_TRUE(header.ok()) << header.status();
          EXPECT_EQ(*header, Picture(i).header);
          places.push_back(message.place);
          return absl::OkStatus();
        }
        EXPECT_EQ(topic.name, "/tf");
        EXPECT_EQ(message.time_ns, kStart_ns + 1000 * transforms + 1);
        const auto tf = Decode<messages::TFMessage>(topic, message.bytes);
        EXPECT_TRUE(tf.ok()) << tf.status();
        EXPECT_EQ(*tf, Transform(transforms++));
        return absl::OkStatus();
      });
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(transforms, kPictures);
  ASSERT_EQ(places.size(), static_cast<size_t>(kPictures));
  for (const int i : {0, 29, 1, 2, 28, 15}) {
    const auto bytes = (*bag)->Fetch(places[static_cast<size_t>(i)]);
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    const BagTopic& topic = (*bag)->topics()[0].name == "/image_raw"
                                ? (*bag)->topics()[0]
                                : (*bag)->topics()[1];
    const auto image = Decode<messages::Image>(topic, *bytes);
    ASSERT_TRUE(image.ok()) << image.status();
    EXPECT_EQ(*image, Picture(i));
    EXPECT_THAT(
        std::string(
            Decode<messages::TFMessage>(topic, *bytes).status().message()),
        HasSubstr("/image_raw: is of type sensor_msgs/msg/Image"));
  }
  EXPECT_FALSE((*bag)->Fetch({.file = 9, .chunk = 9, .offset = 9999}).ok());
}

TEST_P(BagTest, AnErrorOfTheReaderEndsIt) {
  auto bag = OpenBag(path_);
  ASSERT_TRUE(bag.ok());
  EXPECT_EQ((*bag)->Read([](const BagMessage&) {
    return absl::CancelledError("enough");
  }),
            absl::CancelledError("enough"));
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, BagTest,
    ::testing::Values(
        Case{"mcap", "a.mcap",
             [](const std::string& p) { WriteMcapBag(Recording(), "lz4", p); }},
        Case{"sqlite", "a b?%.db3",
             [](const std::string& p) { WriteSqliteBag(Recording(), p); }},
        Case{"ros1", "a.bag",
             [](const std::string& p) {
               WriteRos1Bag(Recording(), "none", true, p);
             }},
        Case{"ros1_bz2", "a.bag",
             [](const std::string& p) {
               WriteRos1Bag(Recording(), "bz2", true, p);
             }},
        Case{"ros1_lz4_no_index", "a.bag",
             [](const std::string& p) {
               WriteRos1Bag(Recording(), "lz4", false, p);
             }},
        Case{"folder_mcap", "walk",
             [](const std::string& p) {
               WriteBagFolder(Recording(), "mcap", p);
             }},
        Case{"folder_sqlite", "walk",
             [](const std::string& p) {
               WriteBagFolder(Recording(), "sqlite3", p);
             }},
        Case{"folder_of_a_killed_recorder", "walk", [](const std::string& p) {
               WriteBagFolder(Recording(), "mcap", p);
               std::filesystem::remove(p + "/metadata.yaml");
             }}));

class NoBagTest : public ::testing::Test {
 protected:
  std::string ErrorOf(const std::string& path) {
    const auto bag = OpenBag(path);
    EXPECT_FALSE(bag.ok());
    return std::string(bag.status().message());
  }

  const base::TestingFolder folder_;
};

TEST_F(NoBagTest, SaysWhatItIsNot) {
  EXPECT_THAT(ErrorOf(folder_.Path("no.mcap")), HasSubstr("there is no "));
  ASSERT_TRUE(base::WriteNewFile(folder_.Path("a.mcap"), "text").ok());
  EXPECT_THAT(ErrorOf(folder_.Path("a.mcap")), HasSubstr(".db3 (rosbag2)"));
  EXPECT_FALSE(IsBag(folder_.Path("a.mcap")));
  std::filesystem::create_directory(folder_.Path("empty"));
  EXPECT_FALSE(IsBag(folder_.Path("empty")));
  EXPECT_THAT(ErrorOf(folder_.Path("empty")), HasSubstr("no metadata.yaml"));
}

TEST_F(NoBagTest, AFolderWhoseFileIsMissingNamesIt) {
  WriteBagFolder(Recording(), "mcap", folder_.Path("walk"));
  std::filesystem::remove(folder_.Path("walk/walk_1.mcap"));
  EXPECT_THAT(ErrorOf(folder_.Path("walk")), HasSubstr("walk/walk_1.mcap"));
}

TEST_F(NoBagTest, ABagThatRos2CompressedSaysWhatToDo) {
  WriteBagFolder(Recording(), "mcap", folder_.Path("walk"));
  const std::string metadata = folder_.Path("walk/metadata.yaml");
  std::string text = base::ReadFile(metadata).value();
  text.replace(text.find("compression_mode: \"\""), 20,
               "compression_mode: FILE");
  ASSERT_TRUE(base::WriteFileAtomically(metadata, text).ok());
  EXPECT_THAT(ErrorOf(folder_.Path("walk")), HasSubstr("ros2 bag convert"));
}

TEST_F(NoBagTest, ADatabaseOfSomethingElse) {
  WriteSqliteBag({}, folder_.Path("a.db3"));
  std::string bytes = base::ReadFile(folder_.Path("a.db3")).value();
  for (size_t at = bytes.find("messages"); at != std::string::npos;
       at = bytes.find("messages")) {
    bytes.replace(at, 8, "massages");
  }
  ASSERT_TRUE(base::WriteFileAtomically(folder_.Path("a.db3"), bytes).ok());
  EXPECT_THAT(ErrorOf(folder_.Path("a.db3")), HasSubstr("no bag of ROS 2"));
}

TEST_F(NoBagTest, ARos1BagThatBreaksOffIsReadAsFarAsItGoes) {
  WriteRos1Bag(Recording(), "bz2", false, folder_.Path("a.bag"));
  const std::string bytes = base::ReadFile(folder_.Path("a.bag")).value();
  ASSERT_TRUE(base::WriteNewFile(folder_.Path("b.bag"),
                                 bytes.substr(0, bytes.size() - 200))
                  .ok());
  auto bag = OpenBag(folder_.Path("b.bag"));
  ASSERT_TRUE(bag.ok()) << bag.status();
  int count = 0;
  EXPECT_TRUE((*bag)
                  ->Read([&](const BagMessage&) {
                    ++count;
                    return absl::OkStatus();
                  })
                  .ok());
  EXPECT_GT(count, 10);
  EXPECT_LT(count, 2 * kPictures);
}

TEST(TypeNameTest, Ros1NamesBecomeRos2Names) {
  EXPECT_EQ(Ros2TypeName("sensor_msgs/Image"), "sensor_msgs/msg/Image");
  EXPECT_EQ(Ros2TypeName("sensor_msgs/msg/Image"), "sensor_msgs/msg/Image");
  EXPECT_EQ(Ros2TypeName("tf/tfMessage"), "tf2_msgs/msg/TFMessage");
  EXPECT_EQ(Ros2TypeName(""), "");
}

}  // namespace
}  // namespace treeline::bag
