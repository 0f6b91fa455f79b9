#include "nav_agent/behavior/planner_worker.h"

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <limits>
#include <stop_token>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace treeline::behavior {
namespace {

double ProcessorTime_ms() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) +
         1e-6 * static_cast<double>(time.tv_nsec);
}

class InlinePlanRunner final : public PlannerWorker {
 public:
  explicit InlinePlanRunner(
      std::unique_ptr<const planning::GlobalPlanner> planner)
      : planner_(std::move(planner)) {}

  void Start(const planning::PlanRequest& request,
             const planning::PlanBudget& budget) override {
    const double before_ms = ProcessorTime_ms();
    result_ = planner_->Plan(request, budget, std::stop_token());
    tally_.Add(ProcessorTime_ms() - before_ms);
  }
  std::optional<absl::StatusOr<planning::PlanResult>> Take() override {
    return std::exchange(result_, std::nullopt);
  }
  bool IsBusy() const override { return result_.has_value(); }
  void Cancel() override { result_.reset(); }
  PlanTally Tally() const override { return tally_; }

 private:
  std::unique_ptr<const planning::GlobalPlanner> planner_;
  std::optional<absl::StatusOr<planning::PlanResult>> result_;
  PlanTally tally_;
};

// When results are handed over.
struct HandOver {
  // So many steps after the beginning; 0: as soon as they are there.
  int steps = 0;
  double late_after_ms = std::numeric_limits<double>::infinity();
};

class ThreadPlanRunner final : public PlannerWorker {
 public:
  ThreadPlanRunner(std::unique_ptr<const planning::GlobalPlanner> planner,
                   const HandOver& hand_over)
      : planner_(std::move(planner)),
        hand_over_(hand_over),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}
  ThreadPlanRunner(const ThreadPlanRunner&) = delete;
  ThreadPlanRunner& operator=(const ThreadPlanRunner&) = delete;
  ~ThreadPlanRunner() override {
    {
      const absl::MutexLock lock(&mutex_);
      thread_.request_stop();
      stop_plan_.request_stop();
      changed_.SignalAll();
    }
    thread_.join();
  }

  void Start(const planning::PlanRequest& request,
             const planning::PlanBudget& budget) override {
    const absl::MutexLock lock(&mutex_);
    GiveUp();
    question_ = Question{.request = request, .budget = budget};
    begun_in_step_ = step_;
    changed_.SignalAll();
  }
  std::optional<absl::StatusOr<planning::PlanResult>> Take() override {
    const absl::MutexLock lock(&mutex_);
    if (step_ < begun_in_step_ + hand_over_.steps) return std::nullopt;
    while (hand_over_.steps > 0 && (question_.has_value() || is_planning_)) {
      changed_.Wait(&mutex_);
    }
    return std::exchange(result_, std::nullopt);
  }
  bool IsBusy() const override {
    const absl::MutexLock lock(&mutex_);
    return question_.has_value() || is_planning_ || result_.has_value();
  }
  void Cancel() override {
    const absl::MutexLock lock(&mutex_);
    GiveUp();
  }
  void BeginStep() override {
    const absl::MutexLock lock(&mutex_);
    ++step_;
  }
  PlanTally Tally() const override {
    const absl::MutexLock lock(&mutex_);
    return tally_;
  }

 private:
  struct Question {
    planning::PlanRequest request;
    planning::PlanBudget budget;
  };

  void GiveUp() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    stop_plan_.request_stop();
    stop_plan_ = std::stop_source();
    question_.reset();
    result_.reset();
    is_planning_ = false;
    ++generation_;
  }

  void Run(const std::stop_token& stop) {
    while (true) {
      Question question;
      std::stop_token stop_plan;
      uint64_t generation = 0;
      {
        const absl::MutexLock lock(&mutex_);
        while (!stop.stop_requested() && !question_.has_value()) {
          changed_.Wait(&mutex_);
        }
        if (stop.stop_requested()) return;
        question = *std::exchange(question_, std::nullopt);
        stop_plan = stop_plan_.get_token();
        generation = generation_;
        is_planning_ = true;
      }
      const double before_ms = ProcessorTime_ms();
      absl::StatusOr<planning::PlanResult> result =
          planner_->Plan(question.request, question.budget, stop_plan);
      const double took_ms = ProcessorTime_ms() - before_ms;
      const absl::MutexLock lock(&mutex_);
      if (generation != generation_) continue;
      result_ = std::move(result);
      is_planning_ = false;
      tally_.Add(took_ms);
      if (took_ms > hand_over_.late_after_ms) ++tally_.late;
      changed_.SignalAll();
    }
  }

  const std::unique_ptr<const planning::GlobalPlanner> planner_;
  const HandOver hand_over_;
  mutable absl::Mutex mutex_;
  absl::CondVar changed_;
  std::optional<Question> question_ ABSL_GUARDED_BY(mutex_);
  std::optional<absl::StatusOr<planning::PlanResult>> result_
      ABSL_GUARDED_BY(mutex_);
  std::stop_source stop_plan_ ABSL_GUARDED_BY(mutex_);
  // Counts what was given up.
  uint64_t generation_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_planning_ ABSL_GUARDED_BY(mutex_) = false;
  int64_t step_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t begun_in_step_ ABSL_GUARDED_BY(mutex_) = 0;
  PlanTally tally_ ABSL_GUARDED_BY(mutex_);
  // Last: begins when all else is there.
  std::jthread thread_;
};

}  // namespace

void PlanTally::Add(double plan_ms) {
  ++plans;
  total_ms += plan_ms;
  longest_ms = std::max(longest_ms, plan_ms);
}

void PlanTally::Add(const PlanTally& other) {
  plans += other.plans;
  total_ms += other.total_ms;
  longest_ms = std::max(longest_ms, other.longest_ms);
  late += other.late;
}

std::unique_ptr<PlannerWorker> MakeInlinePlannerWorker(
    std::unique_ptr<const planning::GlobalPlanner> planner) {
  return std::make_unique<InlinePlanRunner>(std::move(planner));
}

std::unique_ptr<PlannerWorker> MakeThreadPlannerWorker(
    std::unique_ptr<const planning::GlobalPlanner> planner) {
  return std::make_unique<ThreadPlanRunner>(std::move(planner), HandOver());
}

std::unique_ptr<PlannerWorker> MakeSteppedPlannerWorker(
    std::unique_ptr<const planning::GlobalPlanner> planner, int steps,
    double step_ms) {
  const HandOver hand_over = {.steps = steps, .late_after_ms = steps * step_ms};
  return std::make_unique<ThreadPlanRunner>(std::move(planner), hand_over);
}

}  // namespace treeline::behavior
