#include "nav_agent/bridge/dds/raw_type.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "dds/dds.h"
#include "dds/ddsi/ddsi_serdata.h"
#include "dds/ddsi/ddsi_sertype.h"
#include "dds/ddsi/q_radmin.h"

namespace treeline::dds {
namespace {

// Derived, so that pointers to the first part are pointers to the whole.
struct RawSample : ddsi_serdata {
  // Filled up with zeros to a multiple of four, which Cyclone may read.
  std::vector<uint8_t> bytes;
  uint32_t size = 0;

  RawSample(const ddsi_sertype* of, ddsi_serdata_kind kind_of, size_t size_of)
      : ddsi_serdata(),
        bytes((size_of + 3) / 4 * 4),
        size(static_cast<uint32_t>(size_of)) {
    ddsi_serdata_init(this, of, kind_of);
  }
};

struct RawType : ddsi_sertype {};

const RawSample& Raw(const ddsi_serdata* sample) {
  return *static_cast<const RawSample*>(sample);
}

bool AreKeysEqual(const ddsi_serdata* /*a*/, const ddsi_serdata* /*b*/) {
  return true;
}

uint32_t SizeOf(const ddsi_serdata* sample) { return Raw(sample).size; }

ddsi_serdata* FromFragments(const ddsi_sertype* type, ddsi_serdata_kind kind,
                            const nn_rdata* fragment, size_t size) {
  auto sample = std::make_unique<RawSample>(type, kind, size);
  size_t at = 0;
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    // They may overlap, and never leave a gap.
    if (fragment->maxp1 <= at) continue;
    const size_t end = std::min<size_t>(fragment->maxp1, size);
    const unsigned char* payload =
        NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    std::memcpy(sample->bytes.data() + at, payload + (at - fragment->min),
                end - at);
    at = end;
  }
  return sample.release();
}

ddsi_serdata* FromParts(const ddsi_sertype* type, ddsi_serdata_kind kind,
                        ddsrt_msg_iovlen_t count, const ddsrt_iovec_t* parts,
                        size_t size) {
  auto sample = std::make_unique<RawSample>(type, kind, size);
  size_t at = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < count && at < size; ++i) {
    const size_t length = std::min<size_t>(parts[i].iov_len, size - at);
    std::memcpy(sample->bytes.data() + at, parts[i].iov_base, length);
    at += length;
  }
  return sample.release();
}

ddsi_serdata* FromKeyHash(const ddsi_sertype* type,
                          const ddsi_keyhash* /*hash*/) {
  return new RawSample(type, SDK_KEY, 0);
}

// Samples are given as bytes alone (NewRawSample); what Cyclone makes of none,
// for disposing, is the key of a type without keys.
ddsi_serdata* FromValue(const ddsi_sertype* type, ddsi_serdata_kind kind,
                        const void* /*value*/) {
  return kind == SDK_KEY ? new RawSample(type, SDK_KEY, 0) : nullptr;
}

void ToBytes(const ddsi_serdata* sample, size_t offset, size_t size,
             void* buffer) {
  std::memcpy(buffer, Raw(sample).bytes.data() + offset, size);
}

ddsi_serdata* ToBytesInPlace(const ddsi_serdata* sample, size_t offset,
                             size_t size, ddsrt_iovec_t* part) {
  part->iov_base = const_cast<uint8_t*>(Raw(sample).bytes.data()) + offset;
  part->iov_len = static_cast<ddsrt_iov_len_t>(size);
  return ddsi_serdata_ref(sample);
}

void DoneInPlace(ddsi_serdata* sample, const ddsrt_iovec_t* /*part*/) {
  ddsi_serdata_unref(sample);
}

bool ToValue(const ddsi_serdata* /*sample*/, void* /*value*/, void** /*buffer*/,
             void* /*end*/) {
  return false;
}

ddsi_serdata* ToUntyped(const ddsi_serdata* sample) {
  auto* key = new RawSample(sample->type, SDK_KEY, 0);
  key->type = nullptr;
  return key;
}

bool UntypedToValue(const ddsi_sertype* /*type*/,
                    const ddsi_serdata* /*sample*/, void* /*value*/,
                    void** /*buffer*/, void* /*end*/) {
  return true;
}

void FreeSample(ddsi_serdata* sample) {
  delete static_cast<RawSample*>(sample);
}

size_t Print(const ddsi_sertype* /*type*/, const ddsi_serdata* /*sample*/,
             char* text, size_t size) {
  if (size > 0) text[0] = 0;
  return 0;
}

void KeyHash(const ddsi_serdata* /*sample*/, ddsi_keyhash* hash,
             bool /*force_md5*/) {
  std::memset(hash, 0, sizeof(*hash));
}

constexpr ddsi_serdata_ops kSampleOperations = {
    .eqkey = AreKeysEqual,
    .get_size = SizeOf,
    .from_ser = FromFragments,
    .from_ser_iov = FromParts,
    .from_keyhash = FromKeyHash,
    .from_sample = FromValue,
    .to_ser = ToBytes,
    .to_ser_ref = ToBytesInPlace,
    .to_ser_unref = DoneInPlace,
    .to_sample = ToValue,
    .to_untyped = ToUntyped,
    .untyped_to_sample = UntypedToValue,
    .free = FreeSample,
    .print = Print,
    .get_keyhash = KeyHash,
#ifdef DDS_HAS_SHM
    // Nothing goes through shared memory.
    .get_sample_size = nullptr,
    .from_iox_buffer = nullptr,
#endif
};

void FreeType(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete static_cast<RawType*>(type);
}

// There are no values in memory but bytes.
void ZeroValues(const ddsi_sertype* /*type*/, void* /*values*/,
                size_t /*count*/) {}
void ResizeValues(void** /*values*/, const ddsi_sertype* /*type*/,
                  void* /*old*/, size_t /*old_count*/, size_t /*count*/) {}
void FreeValues(const ddsi_sertype* /*type*/, void** /*values*/,
                size_t /*count*/, dds_free_op_t /*operation*/) {}

// Types that differ only by name differ: Cyclone has compared that.
bool AreTypesEqual(const ddsi_sertype* /*a*/, const ddsi_sertype* /*b*/) {
  return true;
}
uint32_t HashType(const ddsi_sertype* /*type*/) { return 0; }

constexpr ddsi_sertype_ops kTypeOperations = {
    .version = ddsi_sertype_v0,
    .arg = nullptr,
    .free = FreeType,
    .zero_samples = ZeroValues,
    .realloc_samples = ResizeValues,
    .free_samples = FreeValues,
    .equal = AreTypesEqual,
    .hash = HashType,
    // No type information: without it, names decide.
    .type_id = nullptr,
    .type_map = nullptr,
    .type_info = nullptr,
    .derive_sertype = nullptr,
    .get_serialized_size = nullptr,
    .serialize_into = nullptr,
};

}  // namespace

ddsi_sertype* NewRawType(const std::string& type_name) {
  auto* type = new RawType();
  ddsi_sertype_init_flags(type, type_name.c_str(), &kTypeOperations,
                          &kSampleOperations,
                          DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

ddsi_serdata* NewRawSample(const ddsi_sertype* type,
                           std::span<const uint8_t> bytes) {
  auto sample = std::make_unique<RawSample>(type, SDK_DATA, bytes.size());
  std::ranges::copy(bytes, sample->bytes.begin());
  // The two lowest bits of the options say how much of the end is padding.
  if (bytes.size() >= 4) {
    sample->bytes[3] = static_cast<uint8_t>(
        (sample->bytes[3] & ~3) | (sample->bytes.size() - bytes.size()));
  }
  return sample.release();
}

std::span<const uint8_t> BytesOf(const ddsi_serdata* sample) {
  const RawSample& raw = Raw(sample);
  return {raw.bytes.data(), raw.size};
}

}  // namespace treeline::dds
