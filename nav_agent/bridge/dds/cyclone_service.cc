#include "nav_agent/bridge/dds/cyclone_service.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "dds/dds.h"
#include "nav_agent/bridge/dds/keeping_service.h"
#include "nav_agent/bridge/dds/topic_names.h"

namespace treeline::dds {
namespace {

// rmw_qos_profile_services_default.
constexpr Quality kServices = {
    .is_reliable = true, .is_latched = false, .depth = 10};
constexpr size_t kHeaderBytes = 16;

// One number in the byte order that the encoding says, and back: little first.
uint64_t NumberAt(std::span<const uint8_t> bytes, size_t at, bool is_little) {
  uint64_t number = 0;
  for (size_t i = 0; i < 8; ++i) {
    number = number << 8 | bytes[at + (is_little ? 7 - i : i)];
  }
  return number;
}

void PutNumber(uint64_t number, uint8_t* at) {
  for (size_t i = 0; i < 8; ++i) at[i] = static_cast<uint8_t>(number >> 8 * i);
}

struct EndpointDeleter {
  void operator()(dds_builtintopic_endpoint_t* endpoint) const {
    dds_builtintopic_free_endpoint(endpoint);
  }
};
using Endpoint = std::unique_ptr<dds_builtintopic_endpoint_t, EndpointDeleter>;

// What stands behind "clientid=" in the user data; nullopt: nothing does.
std::optional<std::string> ClientOf(const Endpoint& endpoint) {
  if (endpoint == nullptr) return std::nullopt;
  void* data = nullptr;
  size_t size = 0;
  if (!dds_qget_userdata(endpoint->qos, &data, &size) || data == nullptr) {
    return std::nullopt;
  }
  const std::string text(static_cast<const char*>(data), size);
  dds_free(data);
  for (absl::string_view part : absl::StrSplit(text, ';')) {
    if (absl::ConsumePrefix(&part, "clientid=")) return std::string(part);
  }
  return std::nullopt;
}

class CycloneService final : public KeepingService {
 public:
  CycloneService(std::string name, RawTopic request_topic, RawTopic reply_topic,
                 Entity reader, Entity writer)
      : KeepingService(std::move(name)),
        request_topic_(std::move(request_topic)),
        reply_topic_(std::move(reply_topic)),
        reader_(std::move(reader)),
        writer_(std::move(writer)) {}

 private:
  std::vector<Request> TakeRequests() override;
  Hearing HearingOf(const RequestId& id) const override;
  absl::Status Write(const RequestId& id,
                     std::span<const uint8_t> bytes) override;
  // What RequestId's client holds: the number in the header, and our own for
  // the writer that the request came from, as rmw_cyclonedds keeps them.
  static RequestId IdOf(uint64_t client, uint64_t writer, int64_t sequence) {
    RequestId id{.client = {}, .sequence = sequence};
    PutNumber(client, id.client.data());
    PutNumber(writer, id.client.data() + 8);
    return id;
  }

  const RawTopic request_topic_;
  const RawTopic reply_topic_;
  const Entity reader_;
  const Entity writer_;
};

std::vector<Request> CycloneService::TakeRequests() {
  std::vector<Request> requests;
  TakeRaw(reader_, [&](std::span<const uint8_t> bytes, int64_t /*written_ns*/,
                       uint64_t writer) {
    // Without an id it is no client of rmw_cyclonedds, and its first bytes are
    // not this header.
    if (bytes.size() < kEncodingBytes + kHeaderBytes ||
        !ClientOf(
            Endpoint(dds_get_matched_publication_data(reader_.id(), writer)))) {
      CountNotUnderstood();
      return;
    }
    const bool is_little = (bytes[1] & 1) != 0;
    Request request{
        .id = IdOf(NumberAt(bytes, kEncodingBytes, is_little), writer,
                   static_cast<int64_t>(
                       NumberAt(bytes, kEncodingBytes + 8, is_little))),
        .bytes = {bytes.begin(), bytes.begin() + kEncodingBytes}};
    // What follows stays aligned: 16 is a multiple of every alignment.
    request.bytes.insert(request.bytes.end(),
                         bytes.begin() + kEncodingBytes + kHeaderBytes,
                         bytes.end());
    requests.push_back(std::move(request));
  });
  return requests;
}

KeepingService::Hearing CycloneService::HearingOf(const RequestId& id) const {
  const uint64_t writer = NumberAt(id.client, 8, /*is_little=*/true);
  const std::optional<std::string> client = ClientOf(
      Endpoint(dds_get_matched_publication_data(reader_.id(), writer)));
  if (!client.has_value()) return Hearing::kGone;
  const dds_return_t count =
      dds_get_matched_subscriptions(writer_.id(), nullptr, 0);
  if (count <= 0) return Hearing::kNotYet;
  std::vector<dds_instance_handle_t> readers(static_cast<size_t>(count));
  const dds_return_t found = dds_get_matched_subscriptions(
      writer_.id(), readers.data(), readers.size());
  readers.resize(std::min(
      readers.size(), static_cast<size_t>(std::max<dds_return_t>(found, 0))));
  const bool hears =
      std::ranges::any_of(readers, [&](dds_instance_handle_t reader) {
        return ClientOf(Endpoint(dds_get_matched_subscription_data(
                   writer_.id(), reader))) == client;
      });
  return hears ? Hearing::kHears : Hearing::kNotYet;
}

absl::Status CycloneService::Write(const RequestId& id,
                                   std::span<const uint8_t> bytes) {
  std::vector<uint8_t> reply(kEncodingBytes + kHeaderBytes);
  std::ranges::copy(bytes.first(kEncodingBytes), reply.begin());
  // Ours are little-endian, and so is the client's number.
  std::copy_n(id.client.begin(), 8, reply.begin() + kEncodingBytes);
  PutNumber(static_cast<uint64_t>(id.sequence),
            reply.data() + kEncodingBytes + 8);
  reply.insert(reply.end(), bytes.begin() + kEncodingBytes, bytes.end());
  const absl::Status written = WriteRaw(writer_, reply_topic_, reply);
  if (written.ok()) return written;
  return base::Annotate(written, "DDS: replying for " + name());
}

// "serviceid=1.2.3;": any text that no other service of the domain has.
std::string UniqueServiceId(const Entity& participant) {
  static std::atomic<uint32_t> services = 0;
  dds_guid_t guid{};
  dds_get_guid(participant.id(), &guid);
  std::string id = "serviceid=";
  for (size_t i = 0; i < 12; ++i) {
    absl::StrAppendFormat(&id, "%x.", guid.v[i]);
  }
  return absl::StrCat(id, absl::Hex(++services), ";");
}

}  // namespace

absl::StatusOr<std::unique_ptr<Service>> MakeCycloneService(
    const Entity& participant, const Entity& waitset, const std::string& name,
    const std::string& service_type) {
  TL_ASSIGN_OR_RETURN(
      RawTopic request_topic,
      MakeRawTopic(participant, DdsRequestTopicName(name),
                   DdsTypeName(absl::StrCat(service_type, "_Request"))));
  TL_ASSIGN_OR_RETURN(
      RawTopic reply_topic,
      MakeRawTopic(participant, DdsReplyTopicName(name),
                   DdsTypeName(absl::StrCat(service_type, "_Response"))));
  const std::string id = UniqueServiceId(participant);
  TL_ASSIGN_OR_RETURN(Entity writer,
                      MakeWriter(participant, reply_topic, kServices, id));
  TL_ASSIGN_OR_RETURN(Entity reader, MakeReader(participant, waitset,
                                                request_topic, kServices, id));
  return std::make_unique<CycloneService>(name, std::move(request_topic),
                                          std::move(reply_topic),
                                          std::move(reader), std::move(writer));
}

}  // namespace treeline::dds
