#include "raw_samples.hpp"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

// The functions by which Cyclone handles samples, as dds/ddsi/ddsi_serdata.h and ddsi_sertype.h
// describe them. They are called by its threads; none may throw.

namespace loopstone::app {

namespace {

/// What goes over the wire is a multiple of so many bytes.
constexpr std::size_t kAlignment = 4;

struct RawType : ddsi_sertype {};

struct RawSample : ddsi_serdata {
  std::string bytes{};  ///< padded
  std::size_t size = 0;
};

const RawSample& raw(const ddsi_serdata* data) { return *static_cast<const RawSample*>(data); }

RawSample* make_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t size) {
  auto* const made = new RawSample;
  ddsi_serdata_init(made, type, kind);
  made->size = size;
  made->bytes.resize((size + kAlignment - 1) / kAlignment * kAlignment);
  return made;
}

// Of samples.

bool have_equal_keys(const ddsi_serdata* /*a*/, const ddsi_serdata* /*b*/) { return true; }

std::uint32_t size_of(const ddsi_serdata* data) {
  return static_cast<std::uint32_t>(raw(data).bytes.size());
}

/// Of a sample as it comes over the network: in pieces, which may overlap.
ddsi_serdata* from_network(const ddsi_sertype* type, ddsi_serdata_kind kind,
                           const nn_rdata* fragments, std::size_t size) {
  RawSample* const made = make_sample(type, kind, size);
  std::size_t at = 0;
  for (const nn_rdata* piece = fragments; piece != nullptr; piece = piece->nextfrag) {
    const std::size_t end = std::min<std::size_t>(piece->maxp1, size);
    if (end <= at) continue;
    const unsigned char* const payload =
        NN_RMSG_PAYLOADOFF(piece->rmsg, NN_RDATA_PAYLOAD_OFF(piece));
    std::memcpy(made->bytes.data() + at, payload + (at - piece->min), end - at);
    at = end;
  }
  return made;
}

ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind,
                          ddsrt_msg_iovlen_t count, const ddsrt_iovec_t* pieces, std::size_t size) {
  RawSample* const made = make_sample(type, kind, size);
  std::size_t at = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t length = std::min<std::size_t>(pieces[i].iov_len, size - at);
    std::memcpy(made->bytes.data() + at, pieces[i].iov_base, length);
    at += length;
  }
  return made;
}

ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash* /*hash*/) {
  return make_sample(type, SDK_KEY, 0);
}

ddsi_serdata* from_string(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample) {
  if (kind != SDK_DATA) return make_sample(type, kind, 0);
  const auto& bytes = *static_cast<const std::string*>(sample);
  RawSample* const made = make_sample(type, kind, bytes.size());
  std::memcpy(made->bytes.data(), bytes.data(), bytes.size());
  return made;
}

void to_network(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* buffer) {
  std::memcpy(buffer, raw(data).bytes.data() + offset, size);
}

ddsi_serdata* lend_to_network(const ddsi_serdata* data, std::size_t offset, std::size_t size,
                              ddsrt_iovec_t* piece) {
  piece->iov_base = const_cast<char*>(raw(data).bytes.data() + offset);  // NOLINT: it is only read
  piece->iov_len = size;
  return ddsi_serdata_ref(data);
}
void give_back(ddsi_serdata* data, const ddsrt_iovec_t* /*piece*/) { ddsi_serdata_unref(data); }

bool to_string(const ddsi_serdata* data, void* sample, void** /*buffer*/, void* /*end*/) {
  static_cast<std::string*>(sample)->assign(raw(data).bytes, 0, raw(data).size);
  return true;
}

ddsi_serdata* to_untyped(const ddsi_serdata* data) {
  RawSample* const made = make_sample(data->type, SDK_KEY, 0);
  made->type = nullptr;
  return made;
}
bool of_untyped(const ddsi_sertype* /*type*/, const ddsi_serdata* /*data*/, void* sample,
                void** /*buffer*/, void* /*end*/) {
  static_cast<std::string*>(sample)->clear();
  return true;
}

void free_sample(ddsi_serdata* data) { delete static_cast<RawSample*>(data); }

std::size_t print(const ddsi_sertype* /*type*/, const ddsi_serdata* /*data*/, char* buffer,
                  std::size_t size) {
  const std::size_t length = std::min<std::size_t>(size - 1, 3);
  std::memcpy(buffer, "raw", length);
  buffer[length] = '\0';
  return length;
}

void keyhash_of(const ddsi_serdata* /*data*/, ddsi_keyhash* hash, bool /*force_md5*/) {
  std::memset(hash->value, 0, sizeof(hash->value));
}

// Of the type.

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete static_cast<RawType*>(type);
}
void clear_samples(const ddsi_sertype* /*type*/, void* samples, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) static_cast<std::string*>(samples)[i].clear();
}
/// Nobody asks for loans.
void grow_samples(void** /*samples*/, const ddsi_sertype* /*type*/, void* /*old*/,
                  std::size_t /*old_count*/, std::size_t /*count*/) {}
void free_samples(const ddsi_sertype* /*type*/, void** /*samples*/, std::size_t /*count*/,
                  dds_free_op_t /*how*/) {}
bool are_equal(const ddsi_sertype* /*a*/, const ddsi_sertype* /*b*/) { return true; }
std::uint32_t hash_of(const ddsi_sertype* /*type*/) { return 0; }

ddsi_serdata_ops sample_operations() {
  ddsi_serdata_ops operations{};
  operations.eqkey = have_equal_keys;
  operations.get_size = size_of;
  operations.from_ser = from_network;
  operations.from_ser_iov = from_pieces;
  operations.from_keyhash = from_keyhash;
  operations.from_sample = from_string;
  operations.to_ser = to_network;
  operations.to_ser_ref = lend_to_network;
  operations.to_ser_unref = give_back;
  operations.to_sample = to_string;
  operations.to_untyped = to_untyped;
  operations.untyped_to_sample = of_untyped;
  operations.free = free_sample;
  operations.print = print;
  operations.get_keyhash = keyhash_of;
  return operations;
}

ddsi_sertype_ops type_operations() {
  ddsi_sertype_ops operations{};
  operations.version = ddsi_sertype_v0;
  operations.free = free_type;
  operations.zero_samples = clear_samples;
  operations.realloc_samples = grow_samples;
  operations.free_samples = free_samples;
  operations.equal = are_equal;
  operations.hash = hash_of;
  return operations;
}

}  // namespace

ddsi_sertype* make_raw_type(const char* type_name) {
  static const ddsi_serdata_ops kSamples = sample_operations();
  static const ddsi_sertype_ops kTypes = type_operations();
  constexpr bool kHasNoKey = true;
  auto* const type = new RawType;
  ddsi_sertype_init(type, type_name, &kTypes, &kSamples, kHasNoKey);
  return type;
}

}  // namespace loopstone::app
