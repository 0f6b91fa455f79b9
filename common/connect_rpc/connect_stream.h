// The messages of a server's stream, on their way to one client.
#ifndef COMMON_CONNECT_RPC_CONNECT_STREAM_H_
#define COMMON_CONNECT_RPC_CONNECT_STREAM_H_

#include <google/protobuf/message.h>

#include <chrono>

#include "common/base/clock.h"
#include "common/http/http_message.h"

namespace treeline::connect_rpc {

// For the thread of its connection.
class ConnectStream {
 public:
  struct Options {
    bool is_json = false;
    // The client's connection, to be watched; -1: none.
    int socket = -1;
    // When the client gives up.
    base::MonotonicTime deadline = base::MonotonicTime::max();
    // A stream that has said nothing for so long says an empty message: a
    // client that has gone without a word is noticed by nothing else.
    std::chrono::milliseconds heartbeat{5000};
  };

  // Keeps references to `writer`, `empty`, a message without fields, and
  // `clock`.
  ConnectStream(const Options& options, http::HttpBodyWriter& writer,
                const google::protobuf::Message& empty,
                const base::Clock& clock);

  // Waits until the system has taken it. False: nobody hears it.
  bool Write(const google::protobuf::Message& message);

  // Whether nobody hears any more: the client has hung up, does not read, or
  // has given up. To be asked often; sends the heartbeat.
  bool IsGone();

  bool is_past_deadline() const { return clock_.Now() >= options_.deadline; }

 private:
  const Options options_;
  http::HttpBodyWriter& writer_;
  const google::protobuf::Message& empty_;
  const base::Clock& clock_;
  base::MonotonicTime last_write_;
  bool is_gone_ = false;
};

}  // namespace treeline::connect_rpc

#endif  // COMMON_CONNECT_RPC_CONNECT_STREAM_H_
