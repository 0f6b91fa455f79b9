#include "nav_agent/bridge/dds/testing_client.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "dds/dds.h"
#include "nav_agent/bridge/dds/topic_names.h"

namespace treeline::dds {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr Quality kServices = {
    .is_reliable = true, .is_latched = false, .depth = 10};
constexpr size_t kEncodingBytes = 4;
constexpr size_t kHeaderBytes = 16;

}  // namespace

TestingClient::TestingClient(const Domain& domain, const std::string& service,
                             const std::string& service_type,
                             const std::string& user_data)
    : participant_(
          Made(dds_create_participant(static_cast<dds_domainid_t>(domain.id()),
                                      nullptr, nullptr),
               "a client")
              .value()),
      waitset_(Made(dds_create_waitset(participant_.id()), "waiting").value()),
      request_topic_(MakeRawTopic(participant_, DdsRequestTopicName(service),
                                  DdsTypeName(service_type + "_Request"))
                         .value()),
      reply_topic_(MakeRawTopic(participant_, DdsReplyTopicName(service),
                                DdsTypeName(service_type + "_Response"))
                       .value()),
      writer_(MakeWriter(participant_, request_topic_, kServices, user_data)
                  .value()),
      reader_(
          MakeReader(participant_, waitset_, reply_topic_, kServices, user_data)
              .value()) {
  dds_get_instance_handle(writer_.id(), &number_);
}

bool TestingClient::IsMatched() const {
  dds_publication_matched_status_t out{};
  dds_subscription_matched_status_t in{};
  dds_get_publication_matched_status(writer_.id(), &out);
  dds_get_subscription_matched_status(reader_.id(), &in);
  return out.current_count > 0 && in.current_count > 0;
}

void TestingClient::SendRaw(std::span<const uint8_t> bytes) {
  WriteRaw(writer_, request_topic_, bytes).IgnoreError();
}

int64_t TestingClient::Ask(std::span<const uint8_t> bytes) {
  ++asked_;
  std::vector<uint8_t> request(kEncodingBytes + kHeaderBytes);
  std::ranges::copy(bytes.first(kEncodingBytes), request.begin());
  std::memcpy(request.data() + kEncodingBytes, &number_, sizeof(number_));
  std::memcpy(request.data() + kEncodingBytes + 8, &asked_, sizeof(asked_));
  request.insert(request.end(), bytes.begin() + kEncodingBytes, bytes.end());
  SendRaw(request);
  return asked_;
}

std::vector<std::vector<uint8_t>> TestingClient::TakeRawReplies() {
  std::vector<std::vector<uint8_t>> replies;
  TakeRaw(reader_, [&replies](std::span<const uint8_t> bytes, int64_t /*ns*/,
                              uint64_t /*writer*/) {
    replies.emplace_back(bytes.begin(), bytes.end());
  });
  return replies;
}

std::optional<std::vector<uint8_t>> TestingClient::ReplyTo(int64_t sequence) {
  for (const std::vector<uint8_t>& raw : TakeRawReplies()) {
    if (raw.size() < kEncodingBytes + kHeaderBytes) continue;
    uint64_t number = 0;
    int64_t asked = 0;
    std::memcpy(&number, raw.data() + kEncodingBytes, sizeof(number));
    std::memcpy(&asked, raw.data() + kEncodingBytes + 8, sizeof(asked));
    // That of another client.
    if (number != number_) continue;
    std::vector<uint8_t> bytes(raw.begin(), raw.begin() + kEncodingBytes);
    bytes.insert(bytes.end(), raw.begin() + kEncodingBytes + kHeaderBytes,
                 raw.end());
    replies_[asked] = std::move(bytes);
  }
  const auto found = replies_.find(sequence);
  if (found == replies_.end()) return std::nullopt;
  return found->second;
}

}  // namespace treeline::dds
