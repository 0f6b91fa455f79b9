#include "server/service/worker_pool.h"

#include <algorithm>
#include <utility>

namespace treeline::service {
namespace {

// Weight of the latest task in the averages of durations.
constexpr double kNewWeight = 0.1;
// Kinds whose averages are kept; scenes are hundreds, not millions.
constexpr size_t kMaxKinds = 4096;
// Bounds of what a client that is turned away is told to wait (ms).
constexpr double kMinRetry_ms = 10;
constexpr double kMaxRetry_ms = 2000;

// A task is taken for at most this many times as long as those before it: one
// that was held up (a stopped process, a cold page cache) says little of the
// next.
constexpr double kLargestSurprise = 8;

// What is expected is a mean; a promise must hold for nearly all, and the
// answer has a way to go. Measured at twice the capacity
// (docs/research/service.md): without these, one in ten accepted queries ended
// after its deadline.
constexpr double kWaitMargin = 1.25;
constexpr double kTaskMargin = 2;

void Average(double value, double& average) {
  if (average == 0) {
    average = value;
    return;
  }
  const double bounded = std::min(value, kLargestSurprise * average);
  average = (1 - kNewWeight) * average + kNewWeight * bounded;
}

base::MonotonicTime::duration Duration(double milliseconds) {
  return std::chrono::duration_cast<base::MonotonicTime::duration>(
      std::chrono::duration<double, std::milli>(milliseconds));
}

}  // namespace

WorkerPool::WorkerPool(int workers, int queue, const base::Clock& clock)
    : capacity_(static_cast<size_t>(std::max(queue, 1))), clock_(clock) {
  for (int i = 0; i < std::max(workers, 1); ++i) {
    threads_.emplace_back([this] { Work(); });
  }
}

WorkerPool::~WorkerPool() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
    work_or_stop_.SignalAll();
  }
  for (std::thread& thread : threads_) thread.join();
}

WorkerPool::Admission WorkerPool::Submit(Task task) {
  // Of the one that makes room; it is told when the lock is released.
  std::function<void()> give_way;
  Admission admission;
  {
    absl::MutexLock lock(&mutex_);
    const double task_ms = Expected_ms(task.kind);
    if (WouldBeLate(task, task_ms)) {
      return {.verdict = Verdict::kTooLate, .retry_after = RetryAfter()};
    }
    auto own = line_of_.find(task.client);
    if (place_of_.size() >= capacity_) {
      const auto longest = std::max_element(
          lines_.begin(), lines_.end(), [](const Line& a, const Line& b) {
            return a.entries.size() < b.entries.size();
          });
      const size_t owned =
          own == line_of_.end() ? 0 : own->second->entries.size();
      if (longest->entries.size() <= owned + 1) {
        return {.verdict = Verdict::kQueueFull, .retry_after = RetryAfter()};
      }
      give_way = Remove(longest, std::prev(longest->entries.end())).give_way;
      own = line_of_.find(task.client);
    }
    if (own == line_of_.end()) {
      lines_.push_back({task.client, {}});
      own = line_of_.emplace(task.client, std::prev(lines_.end())).first;
    }
    admission.ticket = ++last_ticket_;
    std::list<Entry>& entries = own->second->entries;
    entries.push_back({admission.ticket, task_ms, std::move(task)});
    place_of_[admission.ticket] = {own->second, std::prev(entries.end())};
    work_or_stop_.Signal();
  }
  if (give_way) give_way();
  return admission;
}

bool WorkerPool::Withdraw(uint64_t ticket) {
  // Destroyed when the lock is released: it may own the one who asks.
  Task task;
  absl::MutexLock lock(&mutex_);
  const auto place = place_of_.find(ticket);
  if (place == place_of_.end()) return false;
  task = Remove(place->second.line, place->second.entry);
  return true;
}

int WorkerPool::queued() const {
  absl::MutexLock lock(&mutex_);
  return static_cast<int>(place_of_.size());
}

int WorkerPool::running() const {
  absl::MutexLock lock(&mutex_);
  return running_;
}

WorkerPool::Task WorkerPool::Remove(Lines::iterator line,
                                    std::list<Entry>::iterator entry) {
  Task task = std::move(entry->task);
  place_of_.erase(entry->ticket);
  line->entries.erase(entry);
  if (line->entries.empty()) {
    line_of_.erase(line->client);
    lines_.erase(line);
  }
  return task;
}

WorkerPool::Task WorkerPool::TakeNext() {
  const auto line = lines_.begin();
  // To the end of the round, if it will still be there.
  if (line->entries.size() > 1) lines_.splice(lines_.end(), lines_, line);
  return Remove(line, line->entries.begin());
}

bool WorkerPool::WouldBeLate(const Task& task, double task_ms) const {
  if (task.deadline == base::MonotonicTime::max()) return false;
  const base::MonotonicTime now = clock_.Now();
  // A free worker tries, whatever is expected: else nothing would ever correct
  // an expectation that is too long.
  if (place_of_.empty() && running_ < workers()) return now >= task.deadline;
  return now + Duration(kWaitMargin * ExpectedWait_ms(task.client) +
                        kTaskMargin * task_ms) >
         task.deadline;
}

double WorkerPool::ExpectedWait_ms(const std::string& client) const {
  const auto own = line_of_.find(client);
  const size_t owned = own == line_of_.end() ? 0 : own->second->entries.size();
  // Before it: all of the client's own, and as many of each other client.
  double ahead_ms = running_ms_ / 2;
  for (const Line& line : lines_) {
    size_t left = line.client == client ? owned : owned + 1;
    for (const Entry& entry : line.entries) {
      if (left-- == 0) break;
      ahead_ms += entry.expected_ms;
    }
  }
  return ahead_ms / static_cast<double>(threads_.size());
}

double WorkerPool::Expected_ms(const std::string& kind) const {
  const auto known = kind_ms_.find(kind);
  return known == kind_ms_.end() ? any_ms_ : known->second;
}

void WorkerPool::Learn(const std::string& kind, double task_ms) {
  Average(task_ms, any_ms_);
  if (kind_ms_.size() < kMaxKinds || kind_ms_.count(kind) > 0) {
    Average(task_ms, kind_ms_[kind]);
  }
}

std::chrono::milliseconds WorkerPool::RetryAfter() const {
  const double backlog_ms = any_ms_ * static_cast<double>(place_of_.size()) /
                            static_cast<double>(threads_.size());
  return std::chrono::milliseconds(
      static_cast<int64_t>(std::clamp(backlog_ms, kMinRetry_ms, kMaxRetry_ms)));
}

void WorkerPool::Work() {
  absl::MutexLock lock(&mutex_);
  while (true) {
    while (lines_.empty() && !stopping_) work_or_stop_.Wait(&mutex_);
    if (lines_.empty()) return;
    Task task = TakeNext();
    const double expected_ms = Expected_ms(task.kind);
    ++running_;
    running_ms_ += expected_ms;
    mutex_.Unlock();
    const base::MonotonicTime start = clock_.Now();
    task.run();
    const double task_ms = base::MillisecondsBetween(start, clock_.Now());
    const std::string kind = std::move(task.kind);
    // What it holds may be the last reference to a call.
    task = Task();
    mutex_.Lock();
    --running_;
    running_ms_ -= expected_ms;
    Learn(kind, task_ms);
  }
}

}  // namespace treeline::service
