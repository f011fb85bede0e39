// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/thinning.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace palpate::localization {
namespace {

constexpr std::size_t kMaxContacts = 64;

/// For each contact whether it says again, digit for digit, what one before it says: a copy, as of
/// a reading that was written twice, which knows no more. Candidates may well be alike.
std::vector<bool> copies_among(const std::vector<tactile::Contact>& contacts) {
  using Values = std::array<double, 6>;
  std::set<Values> known;
  std::vector<bool> copies;
  for (const tactile::Contact& contact : contacts) {
    const Values values{contact.p.x(), contact.p.y(), contact.p.z(),
                        contact.n.x(), contact.n.y(), contact.n.z()};
    copies.push_back(contact.group < 0 && !known.insert(values).second);
  }
  return copies;
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
  std::vector<bool> is_kept = copies_among(evidence.contacts);
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
