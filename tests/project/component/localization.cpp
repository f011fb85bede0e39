// SPDX-License-Identifier: Apache-2.0
#include <palpate/geometry/objects/object_model.hpp>
#include <palpate/localization/localizer.hpp>

int main() {
  using namespace palpate;
  const geometry::ObjectModel object(geometry::load_known_object("duck"));
  localization::Evidence evidence;
  for (const Eigen::Vector3d& n : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0)}) {
    tactile::Contact contact;
    contact.p = 0.03 * n;
    contact.n = n;
    evidence.contacts.push_back(contact);
  }
  const auto posterior = localization::localize(object, evidence, RandomStream(1, "search"));
  return posterior.modes.empty() ? 1 : 0;
}
