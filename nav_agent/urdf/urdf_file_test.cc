#include "nav_agent/urdf/urdf_file.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::urdf {
namespace {

using ::testing::HasSubstr;

std::string Robot(const std::string& inside) {
  return absl::StrCat("<robot name=\"r\">\n", inside, "\n</robot>\n");
}

std::string Joint(const std::string& parent, const std::string& child,
                  const std::string& origin = "") {
  return absl::StrCat("<joint name=\"", parent, child,
                      "\" type=\"fixed\"><parent link=\"", parent,
                      "\"/><child link=\"", child, "\"/>", origin, "</joint>");
}

std::string Box(const std::string& size) {
  return absl::StrCat("<link name=\"a\"><collision><geometry><box size=\"",
                      size, "\"/></geometry></collision></link>");
}

void ExpectRefused(const std::string& text, const std::string& reason) {
  const auto urdf = ParseUrdf(text, "r.urdf");
  EXPECT_EQ(urdf.status().code(), absl::StatusCode::kInvalidArgument)
      << text.substr(0, 200);
  EXPECT_THAT(urdf.status().message(), HasSubstr(reason));
  EXPECT_THAT(urdf.status().message(), HasSubstr("r.urdf"));
}

TEST(UrdfFile, ChainsJoints) {
  // A quarter turn to the left, then a metre ahead: to the left of a.
  const auto urdf = ParseUrdf(
      Robot("<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>" +
            Joint("a", "b",
                  "<origin xyz=\"1 0 0\" rpy=\"0 0 1.5707963267948966\"/>") +
            Joint("b", "c", "<origin xyz=\"1 0 0.5\"/>")),
      "r");
  ASSERT_TRUE(urdf.ok()) << urdf.status();
  const geometry::Rigid3 pose =
      urdf->BaseFromLink(*urdf->Find("a"), *urdf->Find("c"));
  EXPECT_NEAR(pose.translation.x, 1, 1e-9);
  EXPECT_NEAR(pose.translation.y, 1, 1e-9);
  EXPECT_NEAR(pose.translation.z, 0.5, 1e-9);
  const geometry::Rigid3 inverse =
      urdf->BaseFromLink(*urdf->Find("c"), *urdf->Find("a"));
  EXPECT_NEAR((pose * inverse).translation.x, 0, 1e-9);
  EXPECT_FALSE(urdf->Find("d").has_value());
}

TEST(UrdfFile, ReadsShapes) {
  const auto urdf = ParseUrdf(
      Robot("<link name=\"a\">"
            "<collision><geometry><box size=\"1 2 3\"/></geometry></collision>"
            "<collision><geometry><cylinder radius=\"0.1\" length=\"0.2\"/>"
            "</geometry></collision>"
            "<collision><geometry><sphere radius=\"0.3\"/></geometry>"
            "</collision>"
            "<collision><geometry><mesh filename=\"package://x.stl\"/>"
            "</geometry></collision></link>"),
      "r");
  ASSERT_TRUE(urdf.ok()) << urdf.status();
  const Link& link = urdf->links[0];
  ASSERT_EQ(link.collisions.size(), 3);
  EXPECT_EQ(link.collisions[0].size_m.z, 3);
  EXPECT_EQ(link.collisions[1].length_m, 0.2);
  EXPECT_EQ(link.collisions[2].radius_m, 0.3);
  EXPECT_EQ(link.meshes, 1);
}

TEST(UrdfFile, SaysThatXacroIsNotExpanded) {
  ExpectRefused(
      Robot("<link name=\"a\"/>\n<xacro:include filename=\"b.xacro\"/>"),
      "r.urdf:3: this is xacro, which is not expanded here");
  ExpectRefused(Robot(Box("${w} 1 1")), "xacro");
  ExpectRefused(Robot("<link name=\"$(arg prefix)\"/>"), "xacro");
}

TEST(UrdfFile, RefusesBombs) {
  std::string laughs = "<!DOCTYPE robot [<!ENTITY a \"ha\">";
  for (char c = 'b'; c < 'k'; ++c) {
    const std::string before = absl::StrCat("&", std::string(1, c - 1), ";");
    std::string ten;
    for (int i = 0; i < 10; ++i) ten += before;
    absl::StrAppend(&laughs, "<!ENTITY ", std::string(1, c), " \"", ten, "\">");
  }
  ExpectRefused(laughs + "]><robot name=\"&j;\"><link name=\"a\"/></robot>",
                "entities are not read");
  std::string deep = "<robot name=\"r\">";
  for (int i = 0; i < 300000; ++i) deep += "<a>";
  ExpectRefused(deep, "deeper than any URDF");
  ExpectRefused(std::string(kMaxUrdfBytes + 1, ' '), "longer than");
  std::string many;
  for (size_t i = 0; i <= kMaxLinks; ++i) {
    absl::StrAppend(&many, "<link name=\"l", i, "\"/>");
  }
  ExpectRefused(Robot(many), "more than 2000 links");
}

TEST(UrdfFile, RefusesNumbersThatAreNone) {
  for (const char* size : {"nan 1 1", "inf 1 1", "1e300 1 1", "-1 1 1", "1 1",
                           "1 1 1 1", "a b c", "", "1e999 0 0", "0x 1 1"}) {
    ExpectRefused(Robot(Box(size)), "r.urdf:2:");
  }
  ExpectRefused(
      Robot("<link name=\"a\"/><link name=\"b\"/>" +
            Joint("a", "b", "<origin xyz=\"0 0 0\" rpy=\"0 nan 0\"/>")),
      "rpy=\"0 nan 0\" is not three numbers");
}

TEST(UrdfFile, RefusesWhatIsNoTree) {
  const std::string ab = "<link name=\"a\"/><link name=\"b\"/>";
  ExpectRefused(Robot(ab + Joint("a", "b") + Joint("b", "a")), "circle");
  ExpectRefused(
      Robot(ab + "<link name=\"c\"/>" + Joint("a", "b") + Joint("b", "a")),
      "circle");
  ExpectRefused(Robot(ab + Joint("a", "a")), "circle");
  ExpectRefused(Robot(ab), "two links hang on no joint: 'a' and 'b'");
  ExpectRefused(Robot(ab + Joint("a", "b") + Joint("a", "b")),
                "hangs on two joints");
  ExpectRefused(Robot(ab + Joint("a", "c")), "there is no link 'c'");
  ExpectRefused(Robot("<link name=\"a\"/><link name=\"a\"/>"), "two links 'a'");
  ExpectRefused(Robot(ab + "<joint name=\"j\" type=\"fixed\"/>"),
                "has no <parent>");
  ExpectRefused(Robot(""), "without links");
  ExpectRefused(Robot("<link/>"), "has no name");
  ExpectRefused(Robot("<link name=\"a&#10;like: b\"/>"), "control characters");
}

TEST(UrdfFile, RefusesOtherFiles) {
  ExpectRefused("", "no XML");
  ExpectRefused("like: jackal\n", "no XML");
  ExpectRefused("<robot name=\"r\"><link name=\"a\"/>", "no XML");
  ExpectRefused("<sdf version=\"1.6\"/>", "no URDF");
  ExpectRefused(std::string("\0\0\0", 3), "no XML");
}

}  // namespace
}  // namespace treeline::urdf
