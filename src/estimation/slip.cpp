// SPDX-License-Identifier: Apache-2.0
#include "estimation/slip.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "palpate/core/statistics.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::estimation {
namespace {

constexpr std::size_t kDriftReadings = 20;

/// Mean place of each finger's lasting contacts in its distal link.
hand::PerFinger<std::optional<Eigen::Vector3d>> places_on_tips(const EventLog& log,
                                                               const hand::Description& hand,
                                                               std::size_t last) {
  hand::PerFinger<std::optional<Eigen::Vector3d>> places;
  hand::PerFinger<int> counts{};
  const std::size_t count = std::min(last + 1, kDriftReadings);
  const auto window = std::span(log.readings).subspan(last + 1 - count, count);
  const auto T_mount_link = hand::forward_kinematics(hand, log.readings[last].joints);
  for (const auto& contact : tactile::lasting_contacts(window, hand, {})) {
    const auto finger = static_cast<std::size_t>(contact.finger);
    const auto link = static_cast<std::size_t>(hand.fingers[finger].link);
    const Eigen::Vector3d p = T_mount_link[link].inverse() * contact.p;
    const int n = counts[finger]++;
    places[finger] = n == 0 ? p : Eigen::Vector3d((*places[finger] * n + p) / (n + 1));
  }
  return places;
}

}  // namespace

double contact_slip(const EventLog& log, const hand::Description& hand, std::size_t before,
                    std::size_t after) {
  const auto from = places_on_tips(log, hand, before), to = places_on_tips(log, hand, after);
  std::vector<double> drifts;
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    if (from[finger] && to[finger]) drifts.push_back((*to[finger] - *from[finger]).norm());
  }
  return drifts.empty() ? 0 : median(drifts);
}

}  // namespace palpate::estimation
