#include "nav_agent/bridge/topic_inputs/topic_inputs.h"

#include <algorithm>
#include <chrono>

#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"

namespace treeline::topic_inputs {
namespace {

// Of which delivery times are kept.
constexpr size_t kDeliveries = 10'000;
// A fault that goes on is told for the hundredth, the thousandth time and so
// on.
bool IsToldAgain(int64_t refused) {
  int64_t told = 100;
  while (told < refused) told *= 10;
  return refused == told;
}

}  // namespace

absl::Status TopicInputs::SubscribeRaw(
    const std::string& topic, const std::string& message_name,
    const dds::Quality& quality,
    std::function<absl::Status(std::span<const uint8_t> bytes)> deliver) {
  TL_ASSIGN_OR_RETURN(std::unique_ptr<dds::Subscription> subscription,
                      node_.Subscribe(topic, message_name, quality));
  inputs_.push_back({.topic = topic,
                     .subscription = std::move(subscription),
                     .is_latched = quality.is_latched,
                     .deliver = std::move(deliver)});
  return absl::OkStatus();
}

std::vector<TopicInputs::Fault> TopicInputs::Deliver(
    std::chrono::nanoseconds wait_at_most) {
  std::vector<Fault> faults;
  node_.Wait(wait_at_most);
  for (Input& input : inputs_) {
    for (const dds::Sample& sample : input.subscription->Take()) {
      ++delivered_;
      if (!input.is_latched) NoteDelivery(sample.written_ns);
      const absl::Status status = input.deliver(sample.bytes);
      if (status.ok()) continue;
      ++input.refused;
      const std::string text(status.message());
      if (text == input.last_fault && !IsToldAgain(input.refused)) continue;
      input.last_fault = text;
      faults.push_back({.topic = input.subscription->topic(),
                        .why = status,
                        .refused = input.refused});
    }
  }
  return faults;
}

const TopicInputs::Input* TopicInputs::Find(const std::string& topic) const {
  const auto input = std::ranges::find(inputs_, topic, &Input::topic);
  return input == inputs_.end() ? nullptr : &*input;
}

int TopicInputs::publishers(const std::string& topic) const {
  const Input* input = Find(topic);
  return input == nullptr ? 0 : input->subscription->matched();
}

std::string TopicInputs::WhyNobody(const std::string& topic) const {
  const Input* input = Find(topic);
  return input == nullptr ? "" : input->subscription->WhyNobody();
}

int64_t TopicInputs::refused() const {
  int64_t refused = 0;
  for (const Input& input : inputs_) refused += input.refused;
  return refused;
}

void TopicInputs::NoteDelivery(int64_t written_ns) {
  const auto now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                          std::chrono::system_clock::now().time_since_epoch())
                          .count();
  const double ms = 1e-6 * static_cast<double>(now_ns - written_ns);
  if (delivery_ms_.size() < kDeliveries) {
    delivery_ms_.push_back(ms);
    return;
  }
  delivery_ms_[next_delivery_] = ms;
  next_delivery_ = (next_delivery_ + 1) % kDeliveries;
}

double TopicInputs::Delivery_ms(double share) const {
  return base::Quantile(delivery_ms_, share);
}

}  // namespace treeline::topic_inputs
