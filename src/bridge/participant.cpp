// SPDX-License-Identifier: Apache-2.0
#include "palpate/bridge/participant.hpp"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <charconv>
#include <cstdlib>
#include <memory>

#include "bridge/raw_sertype.hpp"
#include "bridge/wall_clock.hpp"
#include "palpate/core/error.hpp"

namespace palpate::bridge {
namespace {

constexpr int kMaxDomain = 232;
constexpr double kNanoseconds = 1e9;
constexpr std::int64_t kMaxBlocking = 100'000'000;  // ns that a write waits for a full reader

/// The entity. @throws BadInput with the reason if it is an error
std::int32_t checked(std::int32_t entity, std::string_view what) {
  if (entity >= 0) return entity;
  throw BadInput(fmt::format("DDS: {}: {}", what, dds_strretcode(entity)));
}

using QosPointer = std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)>;

QosPointer make_qos(const Qos& qos) {
  QosPointer made(dds_create_qos(), &dds_delete_qos);
  dds_qset_reliability(made.get(),
                       qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kMaxBlocking);
  dds_qset_durability(made.get(),
                      qos.latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(made.get(), DDS_HISTORY_KEEP_LAST, qos.depth);
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(made.get(), 1, &xcdr1);
  dds_qset_ignorelocal(made.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return made;
}

std::int32_t make_topic(std::int32_t participant, const std::string& topic, std::string_view type) {
  ddsi_sertype* sertype = make_raw_sertype(ros2::dds_type_name(type));
  const std::int32_t entity = dds_create_topic_sertype(
      participant, ros2::dds_topic_name(topic).c_str(), &sertype, nullptr, nullptr, nullptr);
  if (entity < 0) ddsi_sertype_unref(sertype);
  return checked(entity, topic);
}

}  // namespace

int default_domain() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  int domain = -1;
  const char* end = text + std::string_view(text).size();
  const auto parsed = std::from_chars(text, end, domain);
  if (parsed.ec == std::errc() && parsed.ptr == end && domain >= 0 && domain <= kMaxDomain) {
    return domain;
  }
  throw BadInput(fmt::format("ROS_DOMAIN_ID is {:?}, not 0 to {}", text, kMaxDomain));
}

Participant::Participant(int domain)
    : entity_(checked(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr),
                      fmt::format("domain {}", domain))),
      waitset_(checked(dds_create_waitset(entity_), "waitset")) {}

Participant::~Participant() { dds_delete(entity_); }

void Participant::wait(double seconds) {
  dds_attach_t triggered = 0;
  dds_waitset_wait(waitset_, &triggered, 1, static_cast<dds_duration_t>(kNanoseconds * seconds));
}

RawWriter::RawWriter(Participant& participant, const std::string& topic, std::string_view type,
                     const Qos& qos)
    : entity_(checked(
          dds_create_writer(participant.entity_, make_topic(participant.entity_, topic, type),
                            make_qos(qos).get(), nullptr),
          topic)) {}

RawWriter::~RawWriter() { dds_delete(entity_); }

bool RawWriter::write(const std::string& cdr) {
  if (dds_write(entity_, &cdr) != DDS_RETCODE_OK) return false;
  ++written_;
  return true;
}

int RawWriter::readers() const {
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(entity_, &status);
  return static_cast<int>(status.current_count);
}

RawReader::RawReader(Participant& participant, const std::string& topic, std::string_view type,
                     const Qos& qos)
    : entity_(checked(
          dds_create_reader(participant.entity_, make_topic(participant.entity_, topic, type),
                            make_qos(qos).get(), nullptr),
          topic)),
      topic_(topic),
      type_(type) {
  dds_set_status_mask(entity_, DDS_DATA_AVAILABLE_STATUS);
  checked(dds_waitset_attach(participant.waitset_, entity_, entity_), topic);
}

RawReader::~RawReader() { dds_delete(entity_); }

void RawReader::take(const Callback& callback) {
  std::string cdr;
  void* sample = &cdr;
  dds_sample_info_t info{};
  while (dds_take(entity_, &sample, &info, 1, 1) > 0) {
    if (info.valid_data) callback(cdr, wall_clock());
  }
}

int RawReader::senders() const {
  dds_subscription_matched_status_t status{};
  dds_get_subscription_matched_status(entity_, &status);
  return static_cast<int>(status.current_count);
}

std::uint64_t RawReader::lost() const {
  dds_sample_lost_status_t status{};
  dds_get_sample_lost_status(entity_, &status);
  return status.total_count;
}

std::uint64_t RawReader::refused() const {
  dds_requested_incompatible_qos_status_t status{};
  dds_get_requested_incompatible_qos_status(entity_, &status);
  return status.total_count;
}

}  // namespace palpate::bridge
