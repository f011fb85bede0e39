// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/thinning.hpp"

#include <algorithm>
#include <map>

#include "palpate/geometry/cloud/kd_tree.hpp"

namespace palpate::localization {
namespace {

constexpr std::size_t kMaxContacts = 64;

constexpr double kRepeatSigmas = 2;       // of its error, between two samples of one touch
constexpr double kLargestRepeat = 0.003;  // m between them

/// Which contacts share an offset with others.
std::vector<bool> offset_contacts(const Evidence& evidence) {
  std::vector<bool> has_offset(evidence.contacts.size(), false);
  for (const CommonModeBias& offset : evidence.offsets) {
    for (const auto& member : offset.members) has_offset[member.contact] = true;
  }
  return has_offset;
}

bool is_copy(const tactile::Contact& first, const tactile::Contact& second) {
  return first.p == second.p && first.n == second.n;
}

/// Whether two contacts that are near one another may be samples of one resting touch.
bool is_same_touch(const tactile::Contact& first, const tactile::Contact& second) {
  if (first.finger >= 0 && second.finger >= 0 && first.finger != second.finger) return false;
  if (first.has_normal() != second.has_normal()) return false;
  return !first.has_normal() || (first.n - second.n).norm() < kRepeatSigmas * first.normal_sigma;
}

/// For each contact whether it repeats an earlier one, whose errors it has, so that it adds
/// nothing: digit for digit, or as samples of one resting touch do. Candidates of a group may be
/// alike, and contacts with an offset are of touches that are known to differ.
std::vector<bool> repeats_among(const Evidence& evidence) {
  const std::vector<tactile::Contact>& contacts = evidence.contacts;
  const std::vector<bool> has_offset = offset_contacts(evidence);
  std::vector<Eigen::Vector3d> points;
  for (const tactile::Contact& contact : contacts) points.push_back(contact.p);
  const geometry::KdTree places(std::move(points));
  std::vector<bool> repeats(contacts.size(), false);
  std::vector<geometry::Neighbour> near;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const tactile::Contact& first = contacts[i];
    if (repeats[i] || first.group >= 0) continue;
    places.find_within(first.p, std::min(kRepeatSigmas * first.point_sigma, kLargestRepeat), near);
    for (const geometry::Neighbour& neighbour : near) {
      const auto j = static_cast<std::size_t>(neighbour.index);
      const tactile::Contact& second = contacts[j];
      if (j <= i || second.group >= 0) continue;
      const bool may_be_near = !has_offset[i] && !has_offset[j];
      if (is_copy(first, second) || (may_be_near && is_same_touch(first, second)))
        repeats[j] = true;
    }
  }
  return repeats;
}

/// For each contact the index of what counts as one: itself, or its group.
std::vector<std::size_t> units_of(const std::vector<tactile::Contact>& contacts,
                                  std::size_t& count) {
  std::map<int, std::size_t> groups;
  std::vector<std::size_t> units;
  count = 0;
  for (const tactile::Contact& contact : contacts) {
    const bool alone = contact.group < 0;
    const std::size_t unit = alone ? count : groups.try_emplace(contact.group, count).first->second;
    count += unit == count;
    units.push_back(unit);
  }
  return units;
}

void keep(const std::vector<bool>& is_kept, Evidence& evidence) {
  std::vector<tactile::Contact> kept;
  std::vector<std::size_t> place(is_kept.size(), is_kept.size());  // of a contact among those kept
  for (std::size_t k = 0; k < is_kept.size(); ++k) {
    if (!is_kept[k]) continue;
    place[k] = kept.size();
    kept.push_back(evidence.contacts[k]);
  }
  evidence.contacts = std::move(kept);
  for (CommonModeBias& offset : evidence.offsets) {
    for (auto& member : offset.members) member.contact = place[member.contact];
    std::erase_if(offset.members, [&](const auto& m) { return m.contact == is_kept.size(); });
  }
}

}  // namespace

Evidence thinned(Evidence evidence) {
  std::vector<bool> is_kept = repeats_among(evidence);
  is_kept.flip();
  if (std::ranges::count(is_kept, false) > 0) keep(is_kept, evidence);
  std::size_t count = 0;
  const std::vector<std::size_t> units = units_of(evidence.contacts, count);
  if (count <= kMaxContacts) return evidence;
  std::vector<bool> is_unit_kept(count, false);
  for (std::size_t i = 0; i < kMaxContacts; ++i) is_unit_kept[i * count / kMaxContacts] = true;
  is_kept.clear();
  for (const std::size_t unit : units) is_kept.push_back(is_unit_kept[unit]);
  keep(is_kept, evidence);
  return evidence;
}

}  // namespace palpate::localization
