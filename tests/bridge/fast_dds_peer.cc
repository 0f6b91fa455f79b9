// A second, independent implementation of what nav_agent/bridge speaks: Fast
// DDS and Fast CDR, with the definitions of the messages written down a second
// time. What comes in on rt/in/X is read value by value, written again, and
// sent on rt/out/X. Ends when standard input does.
//
//   fast_dds_peer DOMAIN
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

using Bytes = std::vector<char>;

// The public definitions, field by field. b: uint8 and byte, c: int8, o: bool,
// h: int16, H: uint16, i: int32, I: uint32, f: float32, d: float64, s: string;
// [...]: a sequence; N{...}: N times.
const std::string kHeader = "iIs";
const std::string kPose = "7{d}";
const std::string kUuid = "16{b}";
const std::string kNavigateToPose = "nav2_msgs::action::dds_::NavigateToPose_";
const std::map<std::string, std::string> kDefinitions = {
    {"std_msgs::msg::dds_::Header_", kHeader},
    {"rosgraph_msgs::msg::dds_::Clock_", "iI"},
    {"diagnostic_msgs::msg::dds_::DiagnosticArray_", kHeader + "[bsss[ss]]"},
    {"geometry_msgs::msg::dds_::Twist_", "6{d}"},
    {"geometry_msgs::msg::dds_::TwistStamped_", kHeader + "6{d}"},
    {"geometry_msgs::msg::dds_::PoseStamped_", kHeader + kPose},
    {"geometry_msgs::msg::dds_::PoseWithCovarianceStamped_",
     kHeader + kPose + "36{d}"},
    {"tf2_msgs::msg::dds_::TFMessage_", "[" + kHeader + "s7{d}]"},
    {"sensor_msgs::msg::dds_::LaserScan_", kHeader + "7{f}[f][f]"},
    {"sensor_msgs::msg::dds_::PointCloud2_", kHeader + "II[sIbI]oII[b]o"},
    {"sensor_msgs::msg::dds_::Image_", kHeader + "IIsbI[b]"},
    {"sensor_msgs::msg::dds_::CompressedImage_", kHeader + "s[b]"},
    {"sensor_msgs::msg::dds_::CameraInfo_",
     kHeader + "IIs[d]9{d}9{d}12{d}II4{I}o"},
    {"nav_msgs::msg::dds_::Odometry_",
     kHeader + "s" + kPose + "36{d}6{d}36{d}"},
    {"nav_msgs::msg::dds_::OccupancyGrid_", kHeader + "iIfII" + kPose + "[c]"},
    {"nav_msgs::msg::dds_::Path_", kHeader + "[" + kHeader + kPose + "]"},
    {"action_msgs::msg::dds_::GoalStatusArray_", "[" + kUuid + "iIc]"},
    {"action_msgs::srv::dds_::CancelGoal_Request_", kUuid + "iI"},
    {"action_msgs::srv::dds_::CancelGoal_Response_", "c[" + kUuid + "iI]"},
    {kNavigateToPose + "SendGoal_Request_", kUuid + kHeader + kPose + "s"},
    {kNavigateToPose + "SendGoal_Response_", "oiI"},
    {kNavigateToPose + "GetResult_Request_", kUuid},
    {kNavigateToPose + "GetResult_Response_", "cHs"},
    {kNavigateToPose + "FeedbackMessage_", kUuid + kHeader + kPose + "iIiIhf"},
};

template <typename T>
void CopyValue(Cdr& in, Cdr& out) {
  T value{};
  in >> value;
  out << value;
}

template <typename T>
void CopySequence(Cdr& in, Cdr& out) {
  std::vector<T> values;
  in >> values;
  out << values;
}

void CopyOne(char kind, Cdr& in, Cdr& out) {
  switch (kind) {
    case 'b':
      return CopyValue<uint8_t>(in, out);
    case 'c':
      return CopyValue<int8_t>(in, out);
    case 'o':
      return CopyValue<bool>(in, out);
    case 'h':
      return CopyValue<int16_t>(in, out);
    case 'H':
      return CopyValue<uint16_t>(in, out);
    case 'i':
      return CopyValue<int32_t>(in, out);
    case 'I':
      return CopyValue<uint32_t>(in, out);
    case 'f':
      return CopyValue<float>(in, out);
    case 'd':
      return CopyValue<double>(in, out);
    case 's':
      return CopyValue<std::string>(in, out);
    default:
      std::abort();
  }
}

// The end of what begins with an open bracket at `at`.
size_t CloseOf(const std::string& text, size_t at) {
  int depth = 0;
  for (; at < text.size(); ++at) {
    depth += text[at] == '[' || text[at] == '{' ? 1 : 0;
    depth -= text[at] == ']' || text[at] == '}' ? 1 : 0;
    if (depth == 0) return at;
  }
  std::abort();
}

void Copy(const std::string& definition, Cdr& in, Cdr& out) {
  for (size_t at = 0; at < definition.size(); ++at) {
    const char kind = definition[at];
    if (std::isdigit(static_cast<unsigned char>(kind)) != 0) {
      size_t digits = 0;
      const int count = std::stoi(definition.substr(at), &digits);
      const size_t open = at + digits;
      const size_t close = CloseOf(definition, open);
      for (int i = 0; i < count; ++i) {
        Copy(definition.substr(open + 1, close - open - 1), in, out);
      }
      at = close;
    } else if (kind == '[') {
      const size_t close = CloseOf(definition, at);
      const std::string inner = definition.substr(at + 1, close - at - 1);
      if (inner == "f") {
        CopySequence<float>(in, out);
      } else if (inner == "d") {
        CopySequence<double>(in, out);
      } else if (inner == "b") {
        CopySequence<uint8_t>(in, out);
      } else {
        uint32_t count = 0;
        in >> count;
        out << count;
        for (uint32_t i = 0; i < count; ++i) Copy(inner, in, out);
      }
      at = close;
    } else {
      CopyOne(kind, in, out);
    }
  }
}

Bytes CopyMessage(const std::string& definition, Bytes& bytes) {
  FastBuffer in_buffer(bytes.data(), bytes.size());
  Cdr in(in_buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
  in.read_encapsulation();
  // Fast CDR leaves padding as it is; zeros, so that bytes can be compared.
  Bytes out_bytes(bytes.size() + 16, 0);
  FastBuffer out_buffer(out_bytes.data(), out_bytes.size());
  Cdr out(out_buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  out.serialize_encapsulation();
  Copy(definition, in, out);
  out_bytes.resize(out.getSerializedDataLength());
  return out_bytes;
}

// Samples are bytes, which Copy above makes sense of.
class RawType : public dds::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 8 << 20;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(
        reinterpret_cast<char*>(payload->data),
        reinterpret_cast<char*>(payload->data) + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] {
      return static_cast<uint32_t>(static_cast<Bytes*>(data)->size());
    };
  }
  void* createData() override { return new Bytes(); }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

class Echo : public dds::DataReaderListener {
 public:
  Echo(std::string definition, dds::DataWriter* writer)
      : definition_(std::move(definition)), writer_(writer) {}

  void on_data_available(dds::DataReader* reader) override {
    Bytes bytes;
    dds::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) ==
           ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      try {
        Bytes again = CopyMessage(definition_, bytes);
        writer_->write(&again);
      } catch (const eprosima::fastcdr::exception::Exception& error) {
        std::fprintf(stderr, "%s: %s\n", definition_.c_str(), error.what());
      }
    }
  }

 private:
  const std::string definition_;
  dds::DataWriter* const writer_;
};

// UDP over loopback alone; nothing by multicast.
dds::DomainParticipantQos LoopbackAlone() {
  dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
  qos.transport().use_builtin_transports = false;
  auto udp =
      std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
  rtps::Locator_t local;
  rtps::IPLocator::setIPv4(local, "127.0.0.1");
  qos.wire_protocol().builtin.initialPeersList.push_back(local);
  return qos;
}

[[noreturn]] void Run(int domain) {
  dds::DomainParticipant* participant =
      dds::DomainParticipantFactory::get_instance()->create_participant(
          static_cast<uint32_t>(domain), LoopbackAlone());
  if (participant == nullptr) std::exit(1);
  dds::Publisher* publisher =
      participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  dds::Subscriber* subscriber =
      participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  std::vector<std::unique_ptr<Echo>> echoes;
  for (const auto& [type, definition] : kDefinitions) {
    dds::TypeSupport(new RawType(type)).register_type(participant);
    const std::string name = type.substr(type.rfind(':') + 1);
    dds::Topic* in = participant->create_topic("rt/in/" + name, type,
                                               dds::TOPIC_QOS_DEFAULT);
    dds::Topic* out = participant->create_topic("rt/out/" + name, type,
                                                dds::TOPIC_QOS_DEFAULT);
    dds::DataWriterQos writer_qos = dds::DATAWRITER_QOS_DEFAULT;
    writer_qos.endpoint().history_memory_policy =
        rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    writer_qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    writer_qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
    dds::DataReaderQos reader_qos = dds::DATAREADER_QOS_DEFAULT;
    reader_qos.endpoint().history_memory_policy =
        rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    reader_qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    reader_qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
    echoes.push_back(std::make_unique<Echo>(
        definition, publisher->create_datawriter(out, writer_qos)));
    subscriber->create_datareader(in, reader_qos, echoes.back().get());
  }
  std::printf("ready\n");
  std::fflush(stdout);
  // Whoever started it ends it.
  while (true) pause();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s DOMAIN\n", argv[0]);
    return 2;
  }
  Run(std::atoi(argv[1]));
}
