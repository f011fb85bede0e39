// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "palpate/ros2/schema.hpp"

namespace palpate::bridge {

/// Quality of service of a topic, as ROS 2 calls it. docs/ros2.md has a table of what is used.
struct Qos {
  bool reliable = true;     ///< lost messages are sent again; else "best effort"
  bool latched = false;     ///< "transient local": who comes later gets the last one, too
  std::int32_t depth = 10;  ///< messages that are kept for a reader
};

/// A participant of DDS that ROS 2's nodes see on the wire, without an installation of ROS. Which
/// network it uses is for CYCLONEDDS_URI to say.
class Participant {
 public:
  /// @param domain  ROS_DOMAIN_ID of the others, 0 to 232
  /// @throws BadInput, with the reason, if there is no network for it
  explicit Participant(int domain);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// Waits until a reader has something, at most so many seconds.
  void wait(double seconds);

 private:
  friend class RawWriter;
  friend class RawReader;
  std::int32_t entity_ = 0, waitset_ = 0;
};

/// ROS_DOMAIN_ID, or 0. @throws BadInput for one that is no domain
int default_domain();

/// Sends messages in CDR.
class RawWriter {
 public:
  RawWriter(Participant& participant, const std::string& topic, std::string_view type,
            const Qos& qos);
  ~RawWriter();
  RawWriter(const RawWriter&) = delete;
  RawWriter& operator=(const RawWriter&) = delete;

  /// @return false if it could not be sent, as when a reliable reader no longer confirms anything
  bool write(const std::string& cdr);
  std::uint64_t written() const { return written_; }
  int readers() const;  ///< that are connected

 private:
  std::int32_t entity_ = 0;
  std::uint64_t written_ = 0;
};

/// Receives messages in CDR, whatever they hold.
class RawReader {
 public:
  /// A message in CDR, and when it came, ns since 1970.
  using Callback = std::function<void(std::string_view cdr, std::uint64_t received)>;

  RawReader(Participant& participant, const std::string& topic, std::string_view type,
            const Qos& qos);
  ~RawReader();
  RawReader(const RawReader&) = delete;
  RawReader& operator=(const RawReader&) = delete;

  /// Gives what has come since, oldest first.
  void take(const Callback& callback);
  int senders() const;            ///< that are connected
  std::uint64_t lost() const;     ///< messages that came too fast, or never
  std::uint64_t refused() const;  ///< senders whose QoS offers less than this reader asks for
  const std::string& topic() const { return topic_; }
  std::string_view type() const { return type_; }

 private:
  std::int32_t entity_ = 0;
  std::string topic_, type_;
};

template <ros2::Message M>
class TopicWriter : public RawWriter {
 public:
  TopicWriter(Participant& participant, const std::string& topic, const Qos& qos = {})
      : RawWriter(participant, topic, M::kType, qos) {}
  bool write(const M& message) { return RawWriter::write(ros2::serialize(message)); }
};

}  // namespace palpate::bridge
