// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <string>

#include "palpate/bridge/participant.hpp"
#include "palpate/ros2/robot_interface.hpp"

namespace palpate::bridge {

/// Adds readers of all that a ros2::ReadingStream takes; that of the joint states is the last, so
/// that what belongs to a joint state is taken before it.
void add_stream_readers(Participant& participant, const hand::Description& hand,
                        const ros2::RobotInterface& interface, std::deque<RawReader>& readers);

/// QoS of sensor streams that must not lose anything at 1 kHz, unless their senders may.
Qos sensor_qos(bool best_effort = false);

/// Topics of which a sender offers less than is asked for, so that none of its messages come; empty
/// if there is none.
std::string refused_topics(const std::deque<RawReader>& readers);

}  // namespace palpate::bridge
