// SPDX-License-Identifier: Apache-2.0
#include "bridge/raw_sertype.hpp"

#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstring>

namespace palpate::bridge {
namespace {

constexpr std::size_t kMaxMessage = std::size_t{64} << 20;  // bytes; larger ones are dropped

struct RawSertype : ddsi_sertype {};

struct RawData : ddsi_serdata {
  std::string bytes;  ///< with the encapsulation header
};

const RawData& raw(const ddsi_serdata* data) { return *static_cast<const RawData*>(data); }

RawData* make_data(const ddsi_sertype* type, ddsi_serdata_kind kind) {
  auto* data = new RawData;
  ddsi_serdata_init(data, type, kind);
  data->hash = type->serdata_basehash;
  return data;
}

std::uint32_t size_of(const ddsi_serdata* data) {
  return static_cast<std::uint32_t>(raw(data).bytes.size());
}

ddsi_serdata* from_network(const ddsi_sertype* type, ddsi_serdata_kind kind,
                           const nn_rdata* fragment, std::size_t size) {
  if (size > kMaxMessage) return nullptr;
  RawData* data = make_data(type, kind);
  data->bytes.reserve(size);
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    const auto have = static_cast<std::uint32_t>(data->bytes.size());
    if (fragment->maxp1 <= have) continue;  // fragments may overlap
    const unsigned char* payload =
        NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    data->bytes.append(reinterpret_cast<const char*>(payload) + (have - fragment->min),
                       fragment->maxp1 - have);
  }
  return data;
}

ddsi_serdata* from_vectors(const ddsi_sertype* type, ddsi_serdata_kind kind,
                           ddsrt_msg_iovlen_t count, const ddsrt_iovec_t* vectors,
                           std::size_t size) {
  if (size > kMaxMessage) return nullptr;
  RawData* data = make_data(type, kind);
  for (ddsrt_msg_iovlen_t i = 0; i < count; ++i) {
    data->bytes.append(static_cast<const char*>(vectors[i].iov_base), vectors[i].iov_len);
  }
  return data;
}

ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash*) {
  return make_data(type, SDK_KEY);
}

ddsi_serdata* from_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample) {
  RawData* data = make_data(type, kind);
  if (kind == SDK_DATA) data->bytes = *static_cast<const std::string*>(sample);
  return data;
}

/// The protocol asks for a multiple of 4 bytes: what lies behind the message is zero.
void to_network(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* buffer) {
  const std::string& bytes = raw(data).bytes;
  std::memset(buffer, 0, size);
  if (offset >= bytes.size()) return;
  std::memcpy(buffer, bytes.data() + offset, std::min(size, bytes.size() - offset));
}

ddsi_serdata* to_network_reference(const ddsi_serdata* data, std::size_t offset, std::size_t size,
                                   ddsrt_iovec_t* reference) {
  auto* copy = new char[size];
  to_network(data, offset, size, copy);
  reference->iov_base = copy;
  reference->iov_len = size;
  return ddsi_serdata_ref(data);
}

void end_reference(ddsi_serdata* data, const ddsrt_iovec_t* reference) {
  delete[] static_cast<char*>(reference->iov_base);
  ddsi_serdata_unref(data);
}

bool to_sample(const ddsi_serdata* data, void* sample, void**, void*) {
  *static_cast<std::string*>(sample) = raw(data).bytes;
  return true;
}

ddsi_serdata* to_untyped(const ddsi_serdata* data) {
  RawData* key = make_data(data->type, SDK_KEY);
  key->type = nullptr;
  return key;
}

bool untyped_to_sample(const ddsi_sertype*, const ddsi_serdata*, void* sample, void**, void*) {
  static_cast<std::string*>(sample)->clear();
  return true;
}

void free_data(ddsi_serdata* data) { delete static_cast<RawData*>(data); }

std::size_t print(const ddsi_sertype*, const ddsi_serdata*, char* buffer, std::size_t size) {
  if (size > 0) buffer[0] = '\0';
  return 0;
}

void keyhash(const ddsi_serdata*, ddsi_keyhash* hash, bool) {
  std::memset(hash->value, 0, sizeof hash->value);
}

bool same_key(const ddsi_serdata*, const ddsi_serdata*) { return true; }

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete static_cast<RawSertype*>(type);
}

void zero_samples(const ddsi_sertype*, void* samples, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) static_cast<std::string*>(samples)[i].clear();
}

/// Only loans need these, and none are made.
void realloc_samples(void**, const ddsi_sertype*, void*, std::size_t, std::size_t) {}
void free_samples(const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {}

bool same_type(const ddsi_sertype*, const ddsi_sertype*) { return true; }  // the names are compared
std::uint32_t hash_of_type(const ddsi_sertype*) { return 0; }

ddsi_serdata_ops data_operations() {
  ddsi_serdata_ops ops{};
  ops.eqkey = &same_key;
  ops.get_size = &size_of;
  ops.from_ser = &from_network;
  ops.from_ser_iov = &from_vectors;
  ops.from_keyhash = &from_keyhash;
  ops.from_sample = &from_sample;
  ops.to_ser = &to_network;
  ops.to_ser_ref = &to_network_reference;
  ops.to_ser_unref = &end_reference;
  ops.to_sample = &to_sample;
  ops.to_untyped = &to_untyped;
  ops.untyped_to_sample = &untyped_to_sample;
  ops.free = &free_data;
  ops.print = &print;
  ops.get_keyhash = &keyhash;
  return ops;
}

ddsi_sertype_ops type_operations() {
  ddsi_sertype_ops ops{};
  ops.version = ddsi_sertype_v0;
  ops.free = &free_type;
  ops.zero_samples = &zero_samples;
  ops.realloc_samples = &realloc_samples;
  ops.free_samples = &free_samples;
  ops.equal = &same_type;
  ops.hash = &hash_of_type;
  return ops;
}

}  // namespace

ddsi_sertype* make_raw_sertype(const std::string& type_name) {
  static const ddsi_sertype_ops kTypeOperations = type_operations();
  static const ddsi_serdata_ops kDataOperations = data_operations();
  auto* type = new RawSertype{};
  ddsi_sertype_init(type, type_name.c_str(), &kTypeOperations, &kDataOperations, true);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

}  // namespace palpate::bridge
