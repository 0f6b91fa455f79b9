#include "client/bench/load_generator.h"

#include <grpcpp/generic/generic_stub.h>
#include <sys/resource.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/bench/arrivals.h"
#include "client/bench/grpc_transport.h"
#include "client/bench/stream_client.h"
#include "client/bench/timer.h"
#include "common/base/clock.h"
#include "common/base/random.h"

namespace treeline::bench {
namespace {

constexpr uint64_t kCancelStream = 3;
constexpr std::chrono::milliseconds kPauseAfterFailure(10);
constexpr std::chrono::milliseconds kWatchEvery(500);
// After which an interruption is looked for.
constexpr std::chrono::milliseconds kLongestSleep(200);

base::MonotonicTime Now() { return base::SteadyClock().Now(); }

base::MonotonicTime::duration Seconds(double seconds) {
  return std::chrono::duration_cast<base::MonotonicTime::duration>(
      std::chrono::duration<double>(seconds));
}

double ProcessorSeconds() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) +
           1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// A call that is out. Whoever is told of its end and whoever cancels share it.
struct Call {
  size_t item = 0;
  base::MonotonicTime scheduled = {};
  base::MonotonicTime sent = {};
  // Null until the transport has it; by the generator's mutex.
  std::shared_ptr<Transport::PendingCall> pending;
};

}  // namespace

absl::Status LoadOptions::Validate() const {
  const auto refuse = [](absl::string_view what) {
    return absl::InvalidArgumentError(what);
  };
  if (concurrency < 1) return refuse("concurrency must be positive");
  if (stream_window < 0) return refuse("the window must not be negative");
  if (stream_window > 0 && (rate_per_s > 0 || cancel_share > 0)) {
    return refuse(
        "streams are a closed loop, and nothing of them is cancelled");
  }
  if (!(rate_per_s >= 0)) return refuse("the rate must not be negative");
  if (!(duration_s > 0)) return refuse("the duration must be positive");
  if (!(warm_up_s >= 0)) return refuse("the warm-up must not be negative");
  if (!(deadline_ms > 0)) return refuse("the deadline must be positive");
  if (!(interval_s >= 0.01)) return refuse("intervals are too short");
  if (!(cancel_share >= 0 && cancel_share <= 1)) {
    return refuse("the share to cancel must be in [0, 1]");
  }
  return absl::OkStatus();
}

bool LoadRun::saturated() const {
  return not_sent > 0 || send_lag.Percentile_ms(99) > kSaturatedLag_ms;
}

class LoadGenerator::Impl {
 public:
  Impl(std::unique_ptr<Transport> transport,
       std::vector<relocalizer::Connection> connections,
       const std::vector<WorkItem>& items, AnswerChecker& checker)
      : transport_(std::move(transport)),
        connections_(std::move(connections)),
        items_(items),
        checker_(checker) {
    for (const relocalizer::Connection& connection : connections_) {
      stubs_.push_back(
          std::make_unique<grpc::GenericStub>(connection.channel()));
    }
  }

  ~Impl() { WaitForAll(); }

  absl::Status AskOnce(int concurrency, double deadline_ms,
                       const std::stop_token& stop);
  LoadRun Run(const LoadOptions& options, const std::stop_token& stop,
              const Watch& watch);
  std::map<OutcomeKey, int64_t> AllCalls() const { return tally_.AllCalls(); }

 private:
  void RunClosedLoop(const std::stop_token& stop);
  void RunOpenLoop(const std::stop_token& stop, LoadRun& run);
  bool SleepUntil(base::MonotonicTime due, const std::stop_token& stop);

  // Sends the next query. on_done: with the result, on the transport's thread.
  void Send(base::MonotonicTime scheduled,
            std::function<void(const absl::Status&)> on_done);
  void Finish(const std::shared_ptr<Call>& call, const Reply& reply,
              const std::function<void(const absl::Status&)>& on_done);
  void Cancel(const std::shared_ptr<Call>& call);
  void SendAgain(base::MonotonicTime when);
  void Stream();
  void CountFrame(const StreamClient::Frame& frame, const absl::Status& status,
                  const v1::LocalizeResponse* response);
  void Add(const CallResult& result);
  // Calls `action` later, and waits for that in WaitForAll.
  void After(base::MonotonicTime::duration pause, std::function<void()> action);
  bool Goes(base::MonotonicTime now);
  void Abandon();
  void WaitForAll();

  const std::unique_ptr<Transport> transport_;
  // Of streams.
  const std::vector<relocalizer::Connection> connections_;
  const std::vector<WorkItem>& items_;
  AnswerChecker& checker_;
  std::vector<std::unique_ptr<grpc::GenericStub>> stubs_;
  Tally tally_;

  // Set while no call is out.
  LoadOptions options_;
  base::MonotonicTime measured_from_ = {};
  base::MonotonicTime end_ = {};

  std::mutex mutex_;
  std::condition_variable_any changed_;
  // By mutex_.
  size_t next_ = 0;
  size_t next_stream_ = 0;
  // Calls, streams, and what is still to be done later.
  int64_t outstanding_ = 0;
  bool abandoned_ = false;
  int64_t abandoned_calls_ = 0;
  std::unordered_set<std::shared_ptr<Call>> calls_;
  std::unordered_set<StreamClient*> streams_;

  Timer timer_;  // the first to go: its actions use the others
};

void LoadGenerator::Impl::Send(
    base::MonotonicTime scheduled,
    std::function<void(const absl::Status&)> on_done) {
  auto call = std::make_shared<Call>();
  size_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    number = next_++;
    ++outstanding_;
    calls_.insert(call);
  }
  call->item = number % items_.size();
  call->scheduled = scheduled;
  call->sent = Now();
  std::shared_ptr<Transport::PendingCall> pending = transport_->Ask(
      number, call->item,
      scheduled + Seconds(1e-3 * options_.deadline_ms) - call->sent,
      [this, call, on_done = std::move(on_done)](const Reply& reply) {
        Finish(call, reply, on_done);
      });
  bool too_late = false;
  {
    const std::lock_guard lock(mutex_);
    call->pending = std::move(pending);
    too_late = abandoned_;
  }
  if (too_late) Cancel(call);
  base::Random random(options_.seed + number, kCancelStream);
  if (random.NextUnit() < options_.cancel_share) {
    timer_.At(call->sent +
                  Seconds(1e-3 * options_.cancel_after_ms * random.NextUnit()),
              [this, weak = std::weak_ptr<Call>(call)] {
                if (const auto still = weak.lock()) Cancel(still);
              });
  }
}

void LoadGenerator::Impl::Cancel(const std::shared_ptr<Call>& call) {
  std::shared_ptr<Transport::PendingCall> pending;
  {
    const std::lock_guard lock(mutex_);
    pending = call->pending;
  }
  if (pending != nullptr) pending->Cancel();
}

void LoadGenerator::Impl::Finish(
    const std::shared_ptr<Call>& call, const Reply& reply,
    const std::function<void(const absl::Status&)>& on_done) {
  const base::MonotonicTime now = Now();
  CallResult result{
      .status = reply.status,
      .pushback = reply.pushback,
      .latency_ms = base::MillisecondsBetween(call->scheduled, now),
      .from_send_ms = base::MillisecondsBetween(call->sent, now),
      .scheduled_s = base::SecondsBetween(measured_from_, call->scheduled),
      .response = reply.response};
  if (reply.response != nullptr) {
    result.verdict = checker_.Check(call->item, *reply.response);
  }
  {
    const std::lock_guard lock(mutex_);
    calls_.erase(call);
  }
  Add(result);
  if (on_done) on_done(result.status);
  // The last: whoever waits for it may destroy all this.
  const std::lock_guard lock(mutex_);
  --outstanding_;
  changed_.notify_all();
}

bool LoadGenerator::Impl::Goes(base::MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  return now < end_ && !abandoned_;
}

void LoadGenerator::Impl::After(base::MonotonicTime::duration pause,
                                std::function<void()> action) {
  {
    const std::lock_guard lock(mutex_);
    ++outstanding_;
  }
  timer_.At(Now() + pause, [this, action = std::move(action)] {
    action();
    const std::lock_guard lock(mutex_);
    --outstanding_;
    changed_.notify_all();
  });
}

// One client of a closed loop.
void LoadGenerator::Impl::SendAgain(base::MonotonicTime when) {
  if (!Goes(when)) return;
  Send(when, [this](const absl::Status& status) {
    if (status.ok()) {
      SendAgain(Now());
      return;
    }
    // A server that is gone would be asked a million times.
    After(kPauseAfterFailure, [this] { SendAgain(Now()); });
  });
}

// One client of a closed loop of streams.
void LoadGenerator::Impl::Stream() {
  if (!Goes(Now())) return;
  size_t number = 0;
  {
    const std::lock_guard lock(mutex_);
    number = next_stream_++;
    ++outstanding_;
  }
  const size_t connection = number % connections_.size();
  StreamClient::Host host;
  host.next = [this]() -> std::optional<size_t> {
    if (!Goes(Now())) return std::nullopt;
    const std::lock_guard lock(mutex_);
    return next_++ % items_.size();
  };
  host.answer = [this](const StreamClient::Frame& frame,
                       const absl::Status& status,
                       const v1::LocalizeResponse* response) {
    CountFrame(frame, status, response);
  };
  host.end = [this](StreamClient* client, const absl::Status&) {
    // Where there is time left, the server has ended it.
    if (Goes(Now())) After(kPauseAfterFailure, [this] { Stream(); });
    const std::lock_guard lock(mutex_);
    streams_.erase(client);
    --outstanding_;
    changed_.notify_all();
  };
  // Deletes itself.
  auto* client =
      new StreamClient(connections_[connection], *stubs_[connection], items_,
                       options_.stream_window, std::move(host));
  {
    const std::lock_guard lock(mutex_);
    streams_.insert(client);
  }
  client->Start();
}

void LoadGenerator::Impl::CountFrame(const StreamClient::Frame& frame,
                                     const absl::Status& status,
                                     const v1::LocalizeResponse* response) {
  const double took_ms = base::MillisecondsBetween(frame.sent, Now());
  CallResult result{
      .status = status,
      .latency_ms = took_ms,
      .from_send_ms = took_ms,
      .scheduled_s = base::SecondsBetween(measured_from_, frame.sent),
      .response = response};
  if (response != nullptr) {
    result.verdict = checker_.Check(frame.item, *response);
  }
  Add(result);
}

void LoadGenerator::Impl::Add(const CallResult& result) {
  {
    const std::lock_guard lock(mutex_);
    if (abandoned_) {
      ++abandoned_calls_;
      return;
    }
  }
  tally_.Add(result);
}

bool LoadGenerator::Impl::SleepUntil(base::MonotonicTime due,
                                     const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, due, [due] { return Now() >= due; });
  return !stop.stop_requested();
}

void LoadGenerator::Impl::RunClosedLoop(const std::stop_token& stop) {
  for (int i = 0; i < options_.concurrency; ++i) {
    if (options_.stream_window > 0) {
      Stream();
    } else {
      SendAgain(Now());
    }
  }
  SleepUntil(end_, stop);
}

void LoadGenerator::Impl::RunOpenLoop(const std::stop_token& stop,
                                      LoadRun& run) {
  PoissonArrivals arrivals(options_.seed, options_.rate_per_s);
  const base::MonotonicTime start =
      measured_from_ - Seconds(options_.warm_up_s);
  while (true) {
    const base::MonotonicTime due = start + Seconds(arrivals.Next_s());
    if (due >= end_) break;
    // Not on the condition variable: every answer would wake this thread.
    while (Now() < due && !stop.stop_requested()) {
      std::this_thread::sleep_until(std::min(due, Now() + kLongestSleep));
    }
    if (stop.stop_requested()) return;
    bool room = false;
    {
      const std::lock_guard lock(mutex_);
      room = outstanding_ < options_.max_outstanding;
    }
    const bool measured = due >= measured_from_;
    if (measured) run.send_lag.Add(base::MillisecondsBetween(due, Now()));
    if (room) {
      Send(due, nullptr);
    } else {
      run.not_sent += measured;
    }
  }
  SleepUntil(end_, stop);
}

void LoadGenerator::Impl::Abandon() {
  std::unordered_set<std::shared_ptr<Call>> calls;
  {
    const std::lock_guard lock(mutex_);
    abandoned_ = true;
    calls = calls_;
    // They go only when they have left this set; cancelling calls nobody back
    // on this thread.
    for (StreamClient* stream : streams_) stream->Cancel();
  }
  for (const auto& call : calls) Cancel(call);
}

void LoadGenerator::Impl::WaitForAll() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return outstanding_ == 0; });
}

absl::Status LoadGenerator::Impl::AskOnce(int concurrency, double deadline_ms,
                                          const std::stop_token& stop) {
  options_ = {.deadline_ms = deadline_ms};
  // Nothing of it is measured.
  measured_from_ = base::MonotonicTime::max();
  absl::Status first_error;
  next_ = 0;
  for (size_t i = 0; i < items_.size() && !stop.stop_requested(); ++i) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return outstanding_ < concurrency; });
      if (!first_error.ok()) break;
    }
    Send(Now(), [this, i, &first_error](const absl::Status& status) {
      const std::lock_guard lock(mutex_);
      if (!status.ok() && first_error.ok()) {
        first_error = absl::Status(
            status.code(), absl::StrCat(items_[i].scene, ", ", items_[i].stem,
                                        ": ", status.message()));
      }
    });
  }
  WaitForAll();
  if (stop.stop_requested()) return absl::CancelledError("interrupted");
  return first_error;
}

LoadRun LoadGenerator::Impl::Run(const LoadOptions& options,
                                 const std::stop_token& stop,
                                 const Watch& watch) {
  LoadRun run;
  run.options = options;
  options_ = options;
  tally_.Reset(options.interval_s);
  const double cpu_s = ProcessorSeconds();
  const base::MonotonicTime start = Now();
  measured_from_ = start + Seconds(options.warm_up_s);
  end_ = measured_from_ + Seconds(options.duration_s);
  run.measured_from = std::chrono::system_clock::now() +
                      std::chrono::duration_cast<std::chrono::microseconds>(
                          measured_from_ - start);
  {
    const std::jthread watcher([&](const std::stop_token& over) {
      std::mutex mutex;
      std::condition_variable_any never;
      std::unique_lock lock(mutex);
      while (!never.wait_for(lock, over, kWatchEvery,
                             [&] { return over.stop_requested(); })) {
        watch(tally_.Look(), base::SecondsBetween(measured_from_, Now()));
      }
    });
    if (options.rate_per_s > 0) {
      RunOpenLoop(stop, run);
    } else {
      RunClosedLoop(stop);
    }
    run.measured_s = std::max(
        0.0, base::SecondsBetween(measured_from_, std::min(Now(), end_)));
    run.interrupted = stop.stop_requested();
    if (run.interrupted) Abandon();
    WaitForAll();
  }
  run.wall_s = base::SecondsBetween(start, Now());
  run.generator_cpus = (ProcessorSeconds() - cpu_s) / run.wall_s;
  run.tally = tally_.State();
  const std::lock_guard lock(mutex_);
  run.abandoned = std::exchange(abandoned_calls_, 0);
  abandoned_ = false;
  return run;
}

LoadGenerator::LoadGenerator(
    const std::vector<relocalizer::Connection>& connections,
    const std::vector<WorkItem>& items, AnswerChecker& checker)
    : impl_(std::make_unique<Impl>(MakeGrpcTransport(connections, items),
                                   connections, items, checker)) {}

LoadGenerator::LoadGenerator(std::unique_ptr<Transport> transport,
                             const std::vector<WorkItem>& items,
                             AnswerChecker& checker)
    : impl_(std::make_unique<Impl>(std::move(transport),
                                   std::vector<relocalizer::Connection>(),
                                   items, checker)) {}

LoadGenerator::~LoadGenerator() = default;

absl::Status LoadGenerator::AskOnce(int concurrency, double deadline_ms,
                                    const std::stop_token& stop) {
  return impl_->AskOnce(concurrency, deadline_ms, stop);
}

LoadRun LoadGenerator::Run(const LoadOptions& options,
                           const std::stop_token& stop, const Watch& watch) {
  return impl_->Run(options, stop, watch);
}

std::map<OutcomeKey, int64_t> LoadGenerator::AllCalls() const {
  return impl_->AllCalls();
}

}  // namespace treeline::bench
