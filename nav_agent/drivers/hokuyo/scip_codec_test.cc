#include "nav_agent/drivers/hokuyo/scip_codec.h"

#include <string>

#include "gtest/gtest.h"

namespace treeline::hokuyo {
namespace {

// The examples of the specification (SCIP 2.0, section 6).
TEST(ScipNumberTest, DecodesTheExamplesOfTheSpecification) {
  EXPECT_EQ(DecodeScipNumber("CB"), 1234u);
  EXPECT_EQ(DecodeScipNumber("1Dh"), 5432u);
  EXPECT_EQ(EncodeScipNumber(1234, 2), "CB");
  EXPECT_EQ(EncodeScipNumber(5432, 3), "1Dh");
}

TEST(ScipNumberTest, EveryNumberComesBack) {
  for (uint32_t value = 0; value < 1 << 12; ++value) {
    EXPECT_EQ(DecodeScipNumber(EncodeScipNumber(value, 2)), value);
  }
  for (uint32_t value = 0; value < 1 << 24; value += 4093) {
    EXPECT_EQ(DecodeScipNumber(EncodeScipNumber(value, 4)), value);
  }
  EXPECT_EQ(EncodeScipNumber((1 << 18) - 1, 3), "ooo");
}

TEST(ScipNumberTest, RefusesCharactersOutsideItsAlphabet) {
  for (const char* text : {"", "00000", "0/", "0p", "\n0", "0\x80"}) {
    EXPECT_EQ(DecodeScipNumber(text), std::nullopt) << text;
  }
}

TEST(ScipChecksumTest, AgreesWithTheSpecification) {
  EXPECT_EQ(ScipChecksum("00"), 'P');
  EXPECT_EQ(ScipChecksum("99"), 'b');
  EXPECT_EQ(ScipLine("00"), "00P\n");
  EXPECT_EQ(CheckedScipLine("99b"), "99");
  EXPECT_EQ(CheckedScipLine("99c"), std::nullopt);
  EXPECT_EQ(CheckedScipLine("P"), std::nullopt);
  EXPECT_EQ(CheckedScipLine(""), std::nullopt);
}

// As real sensors answered (Hokuyo's wiki, "Obtain status information"): the
// semicolon is not part of the sum.
TEST(ScipChecksumTest, AgreesWithRealAnswersToPpVvAndIi) {
  for (const char* line :
       {"MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N", "DMIN:20;4",
        "DMAX:5600;_", "ARES:1024;\\", "AMIN:44;7", "AMAX:725;o", "AFRT:384;6",
        "SCAN:600;e", "VEND:Hokuyo Automatic Co.,Ltd.;[",
        "PROD:SOKUIKI Sensor URG-04LX;[", "FIRM:3.1.00(18/Jan./2007);`",
        "PROT:SCIP 2.0;N", "SERI:H0614967;V", "LASR:OFF;7",
        "SCSP:Initial(600[rpm])<-Default setting by user;A", "TIME:081615;N",
        "STAT:Sensor works well.;8"}) {
    const std::string text = line;
    EXPECT_EQ(CheckedScipInfoLine(text), text.substr(0, text.size() - 2));
    EXPECT_EQ(CheckedScipLine(text), std::nullopt) << "with the semicolon";
    EXPECT_EQ(ScipInfoLine(text.substr(0, text.size() - 2)), text + "\n");
  }
}

TEST(ScipChecksumTest, AcceptsARemarkThatIsNotPartOfTheSum) {
  EXPECT_TRUE(
      CheckedScipInfoLine("SCSP:Initial(600[rpm])<-Default setting by user;["));
  EXPECT_FALSE(
      CheckedScipInfoLine("SCSP:Initial(600[rpm])<-Default setting by user;]"));
}

TEST(ScipChecksumTest, RefusesInfoLinesWithoutTheirForm) {
  for (const char* line : {"", ";", ";0", "DMIN:204", "DMIN:20;5"}) {
    EXPECT_EQ(CheckedScipInfoLine(line), std::nullopt) << line;
  }
}

TEST(ScanCommandTest, IsWrittenAsTheSpecificationSays) {
  EXPECT_EQ((ScanCommand{.first_step = 0, .last_step = 1080}.Text()),
            "MD0000108001000");
  EXPECT_EQ((ScanCommand{.content = ScanContent::kDistanceAndIntensity,
                         .first_step = 10,
                         .last_step = 750,
                         .cluster = 3,
                         .skipped_scans = 2,
                         .count = 7}
                 .Text()),
            "ME0010075003207");
  EXPECT_EQ((ScanCommand{.continuous = false,
                         .content = ScanContent::kShortDistance,
                         .first_step = 540,
                         .last_step = 544}
                 .Text()),
            "GS0540054401");
}

TEST(ScanCommandTest, ComesBackFromItsText) {
  for (const char* text :
       {"MD0000108001000", "ME0010075003207", "GS0540054401", "GD0000108099"}) {
    const auto command = ParseScanCommand(text);
    ASSERT_TRUE(command) << text;
    EXPECT_EQ(command->Text(), text);
  }
  for (const char* text :
       {"", "M", "MD", "MD000010800100", "XD0000108001000", "MX0000108001000",
        "MD00001o8001000", "MD0000108001a00", "GD00001080010"}) {
    EXPECT_FALSE(ParseScanCommand(text)) << text;
  }
}

TEST(ScanCommandTest, CountsItsSteps) {
  EXPECT_EQ((ScanCommand{.first_step = 0, .last_step = 1080}.Steps()), 1081);
  EXPECT_EQ(
      (ScanCommand{.first_step = 0, .last_step = 9, .cluster = 3}.Steps()), 4);
  EXPECT_EQ(
      (ScanCommand{.first_step = 0, .last_step = 8, .cluster = 3}.Steps()), 3);
}

}  // namespace
}  // namespace treeline::hokuyo
