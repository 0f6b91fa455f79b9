#include "nav_agent/bridge/dds/node.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "dds/dds.h"
#include "nav_agent/bridge/dds/cyclone_neighbours.h"
#include "nav_agent/bridge/dds/cyclone_parts.h"
#include "nav_agent/bridge/dds/cyclone_service.h"

namespace treeline::dds {
namespace {

class CyclonePublisher final : public Publisher {
 public:
  CyclonePublisher(Endpoint ours, const CycloneNeighbours& neighbours,
                   RawTopic topic, Entity writer)
      : ours_(std::move(ours)),
        neighbours_(neighbours),
        topic_(std::move(topic)),
        writer_(std::move(writer)) {}

  absl::Status Publish(std::span<const uint8_t> bytes) override {
    const absl::Status written = WriteRaw(writer_, topic_, bytes);
    return written.ok()
               ? written
               : base::Annotate(written, "DDS: writing to " + ours_.topic);
  }
  int matched() const override {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_.id(), &status);
    return static_cast<int>(status.current_count);
  }
  std::string WhyNobody() const override {
    return matched() > 0 ? "" : neighbours_.WhyNobody(ours_);
  }
  const std::string& topic() const override { return ours_.topic; }

 private:
  const Endpoint ours_;
  const CycloneNeighbours& neighbours_;
  const RawTopic topic_;
  const Entity writer_;
};

class CycloneSubscription final : public Subscription {
 public:
  CycloneSubscription(Endpoint ours, const CycloneNeighbours& neighbours,
                      RawTopic topic, Entity reader)
      : ours_(std::move(ours)),
        neighbours_(neighbours),
        topic_(std::move(topic)),
        reader_(std::move(reader)) {}

  std::vector<Sample> Take() override {
    std::vector<Sample> samples;
    TakeRaw(reader_, [&samples](std::span<const uint8_t> bytes,
                                int64_t written_ns, uint64_t /*writer*/) {
      samples.push_back(
          {.bytes = {bytes.begin(), bytes.end()}, .written_ns = written_ns});
    });
    return samples;
  }
  int matched() const override {
    dds_subscription_matched_status_t status{};
    dds_get_subscription_matched_status(reader_.id(), &status);
    return static_cast<int>(status.current_count);
  }
  int64_t lost() const override {
    dds_sample_lost_status_t status{};
    dds_get_sample_lost_status(reader_.id(), &status);
    return status.total_count;
  }
  std::string WhyNobody() const override {
    return matched() > 0 ? "" : neighbours_.WhyNobody(ours_);
  }
  const std::string& topic() const override { return ours_.topic; }

 private:
  const Endpoint ours_;
  const CycloneNeighbours& neighbours_;
  const RawTopic topic_;
  const Entity reader_;
};

class CycloneNode final : public Node {
 public:
  CycloneNode(NodeName name, Entity participant, Entity waitset,
              CycloneNeighbours neighbours)
      : name_(std::move(name)),
        participant_(std::move(participant)),
        waitset_(std::move(waitset)),
        neighbours_(std::move(neighbours)) {}

  absl::StatusOr<std::unique_ptr<Publisher>> Advertise(
      const std::string& topic, const std::string& message_name,
      const Quality& quality) override {
    TL_ASSIGN_OR_RETURN(const std::string full, FullTopicName(topic, name_));
    TL_ASSIGN_OR_RETURN(RawTopic made, MakeTopic(full, message_name));
    absl::StatusOr<Entity> writer = MakeWriter(participant_, made, quality);
    if (!writer.ok()) return base::Annotate(writer.status(), full);
    return std::make_unique<CyclonePublisher>(
        Endpoint{.topic = full,
                 .message_name = message_name,
                 .quality = quality,
                 .is_writer = true},
        neighbours_, std::move(made), *std::move(writer));
  }

  absl::StatusOr<std::unique_ptr<Subscription>> Subscribe(
      const std::string& topic, const std::string& message_name,
      const Quality& quality) override {
    TL_ASSIGN_OR_RETURN(const std::string full, FullTopicName(topic, name_));
    TL_ASSIGN_OR_RETURN(RawTopic made, MakeTopic(full, message_name));
    absl::StatusOr<Entity> reader =
        MakeReader(participant_, waitset_, made, quality);
    if (!reader.ok()) return base::Annotate(reader.status(), full);
    return std::make_unique<CycloneSubscription>(
        Endpoint{
            .topic = full, .message_name = message_name, .quality = quality},
        neighbours_, std::move(made), *std::move(reader));
  }

  absl::StatusOr<std::unique_ptr<Service>> Serve(
      const std::string& service, const std::string& service_type) override {
    TL_ASSIGN_OR_RETURN(const std::string full, FullTopicName(service, name_));
    return MakeCycloneService(participant_, waitset_, full, service_type);
  }

  bool Wait(std::chrono::nanoseconds at_most) override {
    return dds_waitset_wait(waitset_.id(), nullptr, 0, at_most.count()) > 0;
  }

 private:
  absl::StatusOr<RawTopic> MakeTopic(const std::string& full,
                                     const std::string& message_name) {
    return MakeRawTopic(participant_, DdsTopicName(full),
                        DdsTypeName(message_name));
  }

  const NodeName name_;
  const Entity participant_;
  const Entity waitset_;
  const CycloneNeighbours neighbours_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Node>> Node::Create(const Domain& domain,
                                                   const NodeName& name) {
  // That the names are good.
  TL_RETURN_IF_ERROR(FullTopicName("~/x", name).status());
  // What ROS 2 looks for in a participant: its enclave of security.
  constexpr char kUserData[] = "enclave=/;";
  const std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)> qos(dds_create_qos(),
                                                             dds_delete_qos);
  dds_qset_userdata(qos.get(), kUserData, sizeof(kUserData) - 1);
  TL_ASSIGN_OR_RETURN(
      Entity participant,
      Made(dds_create_participant(static_cast<dds_domainid_t>(domain.id()),
                                  qos.get(), nullptr),
           absl::StrCat("domain ", domain.id())));
  TL_ASSIGN_OR_RETURN(Entity waitset,
                      Made(dds_create_waitset(participant.id()), "a waitset"));
  TL_ASSIGN_OR_RETURN(CycloneNeighbours neighbours,
                      CycloneNeighbours::Watch(participant, domain.id()));
  return std::make_unique<CycloneNode>(
      name, std::move(participant), std::move(waitset), std::move(neighbours));
}

}  // namespace treeline::dds
