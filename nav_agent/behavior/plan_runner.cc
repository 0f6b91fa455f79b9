#include "nav_agent/behavior/plan_runner.h"

#include <cstdint>
#include <stop_token>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace treeline {
namespace {

class InlinePlanRunner final : public PlanRunner {
 public:
  explicit InlinePlanRunner(std::unique_ptr<const GlobalPlanner> planner)
      : planner_(std::move(planner)) {}

  void Start(const PlanRequest& request, const PlanBudget& budget) override {
    result_ = planner_->Plan(request, budget, std::stop_token());
  }
  std::optional<absl::StatusOr<PlanResult>> Take() override {
    return std::exchange(result_, std::nullopt);
  }
  bool IsBusy() const override { return result_.has_value(); }
  void Cancel() override { result_.reset(); }

 private:
  std::unique_ptr<const GlobalPlanner> planner_;
  std::optional<absl::StatusOr<PlanResult>> result_;
};

class ThreadPlanRunner final : public PlanRunner {
 public:
  explicit ThreadPlanRunner(std::unique_ptr<const GlobalPlanner> planner)
      : planner_(std::move(planner)),
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

  void Start(const PlanRequest& request, const PlanBudget& budget) override {
    const absl::MutexLock lock(&mutex_);
    GiveUp();
    question_ = Question{.request = request, .budget = budget};
    changed_.SignalAll();
  }
  std::optional<absl::StatusOr<PlanResult>> Take() override {
    const absl::MutexLock lock(&mutex_);
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

 private:
  struct Question {
    PlanRequest request;
    PlanBudget budget;
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
      absl::StatusOr<PlanResult> result =
          planner_->Plan(question.request, question.budget, stop_plan);
      const absl::MutexLock lock(&mutex_);
      if (generation != generation_) continue;
      result_ = std::move(result);
      is_planning_ = false;
    }
  }

  const std::unique_ptr<const GlobalPlanner> planner_;
  mutable absl::Mutex mutex_;
  absl::CondVar changed_;
  std::optional<Question> question_ ABSL_GUARDED_BY(mutex_);
  std::optional<absl::StatusOr<PlanResult>> result_ ABSL_GUARDED_BY(mutex_);
  std::stop_source stop_plan_ ABSL_GUARDED_BY(mutex_);
  // Counts what was given up.
  uint64_t generation_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_planning_ ABSL_GUARDED_BY(mutex_) = false;
  // Last: begins when all else is there.
  std::jthread thread_;
};

}  // namespace

std::unique_ptr<PlanRunner> MakeInlinePlanRunner(
    std::unique_ptr<const GlobalPlanner> planner) {
  return std::make_unique<InlinePlanRunner>(std::move(planner));
}

std::unique_ptr<PlanRunner> MakeThreadPlanRunner(
    std::unique_ptr<const GlobalPlanner> planner) {
  return std::make_unique<ThreadPlanRunner>(std::move(planner));
}

}  // namespace treeline
