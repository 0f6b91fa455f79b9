// The training objectives, on feature values and labels alone.
#ifndef SERVER_CORE_TRAINING_SPLIT_OBJECTIVE_H_
#define SERVER_CORE_TRAINING_SPLIT_OBJECTIVE_H_

#include <cstdint>
#include <span>
#include <vector>

namespace treeline::training {

// A label: scene coordinates relative to anything near (m).
struct Label {
  float x = 0;
  float y = 0;
  float z = 0;
};

// Q_b of thesis Eq. 4.4: | |left| - |right| | / (|left| + |right|), in [0, 1],
// where left are the values <= threshold. 1 if a side is empty.
double BalanceObjective(std::span<const int16_t> values, int threshold);

// A threshold and what it achieves.
struct ThresholdChoice {
  int threshold = 0;
  // Eq. 3.8's information gain times the number of samples: the reduction of
  // the sum of squared distances (m^2) to the means. Negative: no threshold
  // leaves min_side samples on both sides.
  // For EntropySplitter: Eq. 5.4's gain times the number of samples (nats).
  double gain = -1;
};

// Finds the threshold on one feature that reduces spatial variance most (Eq.
// 3.8), over all thresholds that leave at least min_side samples on both
// sides. Values lie in [-255, 255]. Keeps its working memory between calls: one
// object a thread.
class VarianceSplitter {
 public:
  VarianceSplitter();
  // Of the samples, at most 2^24, of which features are tried next.
  void SetLabels(std::span<const Label> labels);
  // labels[i] belongs to values[i].
  ThresholdChoice Best(std::span<const int16_t> values, int min_side);

 private:
  static constexpr int kBins = 511;

  struct Sum {
    using Lanes [[gnu::vector_size(16)]] = float;
    // x, y, z and the number of some samples, which a float holds, too.
    Lanes lanes = {};
  };
  // Goes through the values in ascending order.
  class Sweep;

  std::vector<Sum> labels_;  // (x, y, z, 1)
  Sum total_;
  std::vector<Sum> bins_;
};

// Finds a threshold on one feature that reduces the entropy of a Gaussian with
// full covariance most (thesis Eq. 5.3 - 5.5):
//   n E(S) - sum over sides of n_j E(S_j),
//   E(S) = log((2 pi e)^3 |covariance(S) + kLabelSigma_m^2 I|) / 2.
// The label noise keeps |.| above zero for few samples, or samples on a plane
// or line, and says how small a spread is still worth splitting. Tries all
// thresholds up to kMaxThresholds of them, else as many quantiles; otherwise
// like VarianceSplitter.
class EntropySplitter {
 public:
  static constexpr double kLabelSigma_m = 0.02;
  static constexpr int kMaxThresholds = 24;

  EntropySplitter();
  // The labels must outlive the calls of Best.
  void SetLabels(std::span<const Label> labels) { labels_ = labels; }
  ThresholdChoice Best(std::span<const int16_t> values, int min_side);

 private:
  static constexpr int kBins = 511;
  // Of some samples: count, sum of labels, sum of their products.
  struct Moments {
    float x = 0, y = 0, z = 0;
    float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    int32_t count = 0;
  };
  struct Sum;
  struct Range {
    int low = 0;
    int high = 0;
  };

  // Adds the samples to bins_; returns the first and last bin in use.
  Range Fill(std::span<const int16_t> values);

  std::span<const Label> labels_;
  std::vector<Moments> bins_;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SPLIT_OBJECTIVE_H_
