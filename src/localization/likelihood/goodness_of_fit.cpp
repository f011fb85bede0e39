// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/goodness_of_fit.hpp"

#include "localization/likelihood/contact_term.hpp"

namespace palpate::localization {
namespace {

constexpr double kCertain = 0.95;
/// Share of the energy that all contacts would have if they were false. At the pose of the right
/// object it is about 0.15 and with twice the noise stated 0.2 to 0.4; of wrong ones 0.5 and more.
/// The false contacts that are expected take theirs besides.
constexpr float kMaxUnexplained = 0.45F;

}  // namespace

bool fit_is_rejected(const geometry::ObjectModel& model, const Evidence& evidence,
                     const SearchPose& best, double contact_offset) {
  const ContactTerm contacts(model, evidence, contact_offset, 1.0);
  const auto expected = static_cast<float>(evidence.false_contact_share);
  return 2 * contacts.unexplained(best) > static_cast<int>(contacts.size()) ||
         contacts.misfit(best) > kMaxUnexplained + expected;
}

PoseStatus status_of(const std::vector<Mode>& modes) {
  if (modes.empty()) return PoseStatus::no_pose;
  return pose_probability(modes.front()) > kCertain ? PoseStatus::certain : PoseStatus::ambiguous;
}

}  // namespace palpate::localization
