// How good a scene will be, in words, from how its held-out pictures were
// answered.
#ifndef SERVER_TOOLS_LEARNING_VERDICT_H_
#define SERVER_TOOLS_LEARNING_VERDICT_H_

#include <optional>
#include <string>
#include <vector>

namespace treeline::learning {

// What became of pictures that were not learnt, for one kind of query.
struct HeldOutTrial {
  std::string queries;  // "colour and depth", "colour alone"
  int frames = 0;
  int answered = 0;
  int right = 0;  // of the answers, within the bounds
  int wrong = 0;  // answers that are relied on, and are not right
  // Of all answers, in the world's unit (m) and degrees; nullopt: none.
  std::optional<double> median_translation_m{};
  std::optional<double> median_rotation_deg{};
  // Nine of ten answers are nearer.
  std::optional<double> p90_translation_m{};
  // Of the processor, a query.
  std::optional<double> cpu_ms{};
};

enum class Grade { kGood, kFair, kPoor };

struct Verdict {
  Grade grade = Grade::kPoor;
  std::string headline;
  // What follows from the figures, a sentence or two each.
  std::vector<std::string> sentences;
};

Grade GradeOf(const HeldOutTrial& trial);

// The grade is that of the weakest kind of query. units_are_metres: else no
// lengths are told.
Verdict Judge(const std::vector<HeldOutTrial>& trials, bool units_are_metres);

// "1.3 cm", "0.42 units".
std::string LengthText(double length_m, bool units_are_metres);

}  // namespace treeline::learning

#endif  // SERVER_TOOLS_LEARNING_VERDICT_H_
