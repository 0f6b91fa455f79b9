#include "server/tools/app/split_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "evaluation/accuracy/far_split.h"
#include "evaluation/accuracy/thresholds.h"
#include "server/tools/dataset_flags.h"
#include "server/tools/run_info.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
Writes two frame lists, for `treeline train --frames` and `treeline evaluate
--frames`, such that no frame of the second was taken within --far of a frame of
the first. The same command gives the same lists.

Without --first, holes are made in the recording: about frames drawn with
--seed, until --test-share of the frames are in them; what is too near to a hole
is in neither list. With --first, the first N frames are learnt, and of the rest
(or of --test-frames) those that are far enough are asked about.

Examples:
  treeline split --dataset tum:data/desk --training-list train.txt \
      --test-list far.txt
  treeline split --dataset 7scenes:data/kitchen --frames data/kitchen/train.txt \
      --poses data/kitchen/poses-sfm.txt --first 200 \
      --test-frames data/kitchen/test.txt \
      --training-list first200.txt --test-list far.txt)";

struct SplitFlags {
  dataset::DatasetOptions dataset;
  std::string far = "30,15";
  int first = 0;
  std::string test_frames;
  accuracy::HoleOptions holes;
  std::string training_list;
  std::string test_list;
};

accuracy::FramePoses PosesOf(const dataset::Dataset& dataset) {
  accuracy::FramePoses poses;
  for (int i = 0; i < dataset.size(); ++i) {
    poses.push_back(dataset.frame(i).world_from_camera);
  }
  return poses;
}

absl::Status WriteList(const std::string& path, const dataset::Dataset& dataset,
                       const std::vector<int>& frames) {
  if (frames.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path,
                     ": no frame is left for this list; give a smaller "
                     "--far, or another --test-share or --first"));
  }
  std::string text = absl::StrCat("# ", tools::CommandLine(), "\n");
  for (const int frame : frames) {
    absl::StrAppend(&text, dataset.frame(frame).stem, "\n");
  }
  return base::WriteFileAtomically(path, text);
}

absl::Status Split(const SplitFlags& flags) {
  TL_ASSIGN_OR_RETURN(const accuracy::ThresholdRequest far,
                      accuracy::ParseThreshold(flags.far));
  if (far.relative) {
    return absl::InvalidArgumentError("--far must be CM,DEG");
  }
  TL_ASSIGN_OR_RETURN(const dataset::Dataset dataset,
                      dataset::Dataset::Open(flags.dataset));
  accuracy::HoleOptions holes = flags.holes;
  holes.near = {far.translation / 100, far.rotation_deg};
  const accuracy::FramePoses poses = PosesOf(dataset);
  accuracy::FarSplit split =
      flags.first > 0
          ? accuracy::SplitAfterFirst(poses, flags.first, holes.near)
          : accuracy::SplitByHoles(poses, holes);
  dataset::Dataset tested = dataset;
  if (!flags.test_frames.empty()) {
    dataset::DatasetOptions options = flags.dataset;
    options.frame_list = flags.test_frames;
    TL_ASSIGN_OR_RETURN(tested, dataset::Dataset::Open(options));
    std::vector<geometry::Rigid3> training_poses;
    for (const int frame : split.training) {
      training_poses.push_back(*poses[static_cast<size_t>(frame)]);
    }
    split.test =
        accuracy::FramesBeyond(PosesOf(tested), training_poses, holes.near);
  }
  TL_RETURN_IF_ERROR(WriteList(flags.training_list, dataset, split.training));
  TL_RETURN_IF_ERROR(WriteList(flags.test_list, tested, split.test));
  std::printf("%s: %d frames to learn\n%s: %d frames beyond %g cm or %g deg\n",
              flags.training_list.c_str(),
              static_cast<int>(split.training.size()), flags.test_list.c_str(),
              static_cast<int>(split.test.size()), far.translation,
              far.rotation_deg);
  return absl::OkStatus();
}

}  // namespace

cli::Command AddSplitCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "split", "Choose frames to learn, and test frames far from all of them");
  command->footer(kFooter);
  auto flags = std::make_shared<SplitFlags>();
  tools::AddDatasetFlags(*command, flags->dataset);
  command
      ->add_option("--far", flags->far,
                   "A test frame is beyond one of these from each training "
                   "frame")
      ->type_name("CM,DEG")
      ->capture_default_str();
  CLI::Option* first =
      command
          ->add_option("--first", flags->first,
                       "Learn the first N frames; 0: all but holes")
          ->check(CLI::NonNegativeNumber)
          ->type_name("N")
          ->capture_default_str();
  command
      ->add_option("--test-frames", flags->test_frames,
                   "With --first: the frame list that test frames are of, in "
                   "place of the rest of the recording")
      ->type_name("FILE")
      ->needs(first);
  command
      ->add_option("--test-share", flags->holes.test_share,
                   "Share of the frames in holes")
      ->check(CLI::Range(0.01, 0.6))
      ->type_name("S")
      ->capture_default_str();
  command->add_option("--seed", flags->holes.seed, "Where the holes are")
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--training-list", flags->training_list,
                   "Frame list to write, to learn")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--test-list", flags->test_list,
                   "Frame list to write, to ask about")
      ->required()
      ->type_name("FILE");
  return {command,
          [flags](const std::stop_token& /*stop*/) { return Split(*flags); }};
}

}  // namespace treeline::tools_app
