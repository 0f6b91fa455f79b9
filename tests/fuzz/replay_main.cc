// Runs a fuzz target where libFuzzer is not: on its seeds, on prefixes of them
// of 200 lengths, and on a fixed number of mutations of them: the same inputs
// on every machine, in a few seconds.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/base/random.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace treeline {
namespace {

constexpr int kMutationsPerSeed = 2000;
constexpr int kTruncationsPerSeed = 200;
constexpr size_t kLongestSeedBytes = 1 << 20;

void RunOn(const std::string& input) {
  // An exact copy on the heap, so that AddressSanitizer sees its ends.
  const std::vector<uint8_t> copy(input.begin(), input.end());
  LLVMFuzzerTestOneInput(copy.data(), copy.size());
}

uint32_t Below(base::Random& random, size_t bound) {
  return random.NextBelow(static_cast<uint32_t>(bound));
}

// One to eight small changes, mostly of bytes and of 32-bit fields, since
// those are what lengths and offsets are made of.
std::string Mutated(const std::string& seed, uint64_t index) {
  static constexpr uint32_t kFieldValues[] = {
      0,      1,       0x7f,       0x80,       0xff,
      0xffff, 0x10000, 0x7fffffff, 0x80000000, 0xffffffff};
  base::Random random(/*seed=*/20261121, index);
  std::string input = seed;
  const uint32_t changes = 1 + random.NextBelow(8);
  for (uint32_t i = 0; i < changes && !input.empty(); ++i) {
    const uint32_t at = Below(random, input.size());
    switch (random.NextBelow(5)) {
      case 0:
        input[at] = static_cast<char>(random.NextBits());
        break;
      case 1:
        input[at] ^= static_cast<char>(1u << random.NextBelow(8));
        break;
      case 2: {
        const uint32_t value =
            kFieldValues[Below(random, std::size(kFieldValues))];
        for (uint32_t b = 0; b < 4 && at + b < input.size(); ++b) {
          input[at + b] = static_cast<char>(value >> (8 * b));
        }
        break;
      }
      case 3:
        input.erase(at, 1 + random.NextBelow(16));
        break;
      default:
        input.insert(at, 1 + random.NextBelow(16),
                     static_cast<char>(random.NextBits()));
        break;
    }
  }
  return input;
}

void RunOnVariantsOf(const std::string& seed, uint64_t stream) {
  RunOn(seed);
  const size_t step = std::max<size_t>(1, seed.size() / kTruncationsPerSeed);
  for (size_t length = 0; length < seed.size(); length += step) {
    RunOn(seed.substr(0, length));
  }
  for (int i = 0; i < kMutationsPerSeed; ++i) {
    RunOn(Mutated(seed, stream * kMutationsPerSeed + static_cast<uint64_t>(i)));
  }
}

// Files below the folders and files named on the command line, in order.
std::vector<std::string> SeedPaths(int argc, char** argv) {
  std::vector<std::string> paths;
  for (int i = 1; i < argc; ++i) {
    if (!std::filesystem::is_directory(argv[i])) {
      paths.emplace_back(argv[i]);
      continue;
    }
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(argv[i])) {
      if (entry.is_regular_file()) paths.push_back(entry.path().string());
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

int Replay(int argc, char** argv) {
  const std::vector<std::string> paths = SeedPaths(argc, argv);
  RunOnVariantsOf(std::string(256, '\0'), 0);
  for (size_t i = 0; i < paths.size(); ++i) {
    const auto seed = base::ReadFile(paths[i], kLongestSeedBytes);
    if (!seed.ok()) {
      std::fprintf(stderr, "%s\n", seed.status().ToString().c_str());
      return 1;
    }
    RunOnVariantsOf(*seed, i + 1);
  }
  std::printf("%zu seeds and their variants: no crash\n", paths.size());
  return 0;
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) { return treeline::Replay(argc, argv); }
