// Where the messages of a stream go, whatever carries them.
#ifndef NAV_AGENT_SERVICE_MESSAGE_SINK_H_
#define NAV_AGENT_SERVICE_MESSAGE_SINK_H_

namespace treeline::agent_service {

// For one thread.
template <typename Message>
class MessageSink {
 public:
  virtual ~MessageSink() = default;
  // False: nobody hears it any more.
  virtual bool Write(const Message& message) = 0;
  // Whether nobody hears any more. To be asked several times a second.
  virtual bool IsGone() = 0;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_MESSAGE_SINK_H_
