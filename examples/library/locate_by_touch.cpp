// SPDX-License-Identifier: Apache-2.0
// Where is the bracket? Twelve touches of its surface, sensed with 1 mm and 10 deg of noise, show
// it.
#include <cstdio>
#include <numbers>

#include "palpate/geometry/mesh/sampling.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/localization/localizer.hpp"

int main() {
  using namespace palpate;
  const geometry::ObjectModel object(geometry::load_known_object("bracket"));

  // A real hand would bring these; here they are drawn from the surface at a pose we then forget.
  const Eigen::Isometry3d truth =
      Eigen::Translation3d(0.4, 0.1, 0.05) * Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ());
  RandomStream random(7, "touches");
  localization::Evidence evidence;
  for (const auto& sample :
       geometry::sample_surface(object.object().mesh, 12, random.fork("points"))) {
    tactile::Contact contact;
    contact.p = truth * sample.point + 0.001 * random.normal3();
    contact.n = (truth.linear() * sample.normal + 0.17 * random.normal3()).normalized();
    evidence.contacts.push_back(contact);
  }

  const auto posterior = localization::localize(object, evidence, RandomStream(7, "search"));
  std::printf("%s\n", std::string(localization::to_string(posterior.status)).c_str());
  for (const auto& mode : posterior.modes) {
    const auto error =
        localization::pose_error(mode.T_frame_object, truth, object.object().symmetries);
    std::printf("weight %.2f: %.1f deg, %.1f mm from the truth\n", mode.weight,
                error.rotation * 180 / std::numbers::pi, 1e3 * error.translation);
  }
  return posterior.modes.empty() ? 1 : 0;
}
