#include "nav_agent/bridge/fast_dds/fast_raw_type.h"

#include <cstring>

namespace treeline::fast_dds {
namespace {

using Bytes = std::vector<uint8_t>;

}  // namespace

FastRawType::FastRawType(const std::string& name) {
  setName(name.c_str());
  // What is set aside beforehand; more is taken where it is needed.
  m_typeSize = 1024;
  m_isGetKeyDefined = false;
  auto_fill_type_object(false);
  auto_fill_type_information(false);
}

bool FastRawType::serialize(void* data, Payload* payload) {
  const Bytes& bytes = *static_cast<Bytes*>(data);
  if (bytes.size() > payload->max_size) return false;
  std::memcpy(payload->data, bytes.data(), bytes.size());
  payload->length = static_cast<uint32_t>(bytes.size());
  payload->encapsulation = CDR_LE;
  return true;
}

bool FastRawType::deserialize(Payload* payload, void* data) {
  static_cast<Bytes*>(data)->assign(payload->data,
                                    payload->data + payload->length);
  return true;
}

std::function<uint32_t()> FastRawType::getSerializedSizeProvider(void* data) {
  return [data] {
    return static_cast<uint32_t>(static_cast<Bytes*>(data)->size());
  };
}

void* FastRawType::createData() { return new Bytes(); }

void FastRawType::deleteData(void* data) { delete static_cast<Bytes*>(data); }

}  // namespace treeline::fast_dds
