#include "common/base/processor_name.h"

#include "gtest/gtest.h"

namespace treeline::base {
namespace {

// Lines as kernels write them.
constexpr char kX86[] =
    "processor\t: 0\n"
    "vendor_id\t: AuthenticAMD\n"
    "model\t\t: 17\n"
    "model name\t: AMD EPYC 9354 32-Core Processor\n";
constexpr char kRaspberryPi[] =
    "processor\t: 0\n"
    "BogoMIPS\t: 108.00\n"
    "CPU implementer\t: 0x41\n"
    "CPU architecture: 8\n"
    "CPU part\t: 0xd0b\n"
    "\n"
    "Revision\t: c04170\n"
    "Model\t\t: Raspberry Pi 5 Model B Rev 1.0\n";
constexpr char kOtherArm[] =
    "processor\t: 0\n"
    "CPU implementer\t: 0x41\n"
    "CPU part\t: 0xd42\n";

TEST(ProcessorNameTest, IsTheModelTheBoardOrTheNumbers) {
  EXPECT_EQ(ProcessorNameIn(kX86), "AMD EPYC 9354 32-Core Processor");
  EXPECT_EQ(ProcessorNameIn(kRaspberryPi), "Raspberry Pi 5 Model B Rev 1.0");
  EXPECT_EQ(ProcessorNameIn(kOtherArm), "Arm 0x41-0xd42");
}

TEST(ProcessorNameTest, IsEmptyWhereNothingIsSaid) {
  EXPECT_EQ(ProcessorNameIn(""), "");
  EXPECT_EQ(ProcessorNameIn("processor : 0\nmodel name\nModelling: x"), "");
}

}  // namespace
}  // namespace treeline::base
