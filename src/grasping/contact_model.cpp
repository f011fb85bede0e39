// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/contact_model.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::grasping {

int components(ContactModel model) {
  switch (model) {
    case ContactModel::frictionless:
      return 1;
    case ContactModel::hard_finger:
      return 3;
    case ContactModel::soft_finger:
      return 4;
  }
  throw BadInput(fmt::format("no contact model has the number {}", static_cast<int>(model)));
}

Eigen::MatrixXd transmission(ContactModel model) {
  constexpr int kNormalMoment = 0, kFirstForce = 3;
  const int count = components(model);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(count, 6);
  for (int i = 0; i < std::min(count, 3); ++i) H(i, kFirstForce + i) = 1;
  if (count == 4) H(3, kNormalMoment) = 1;
  return H;
}

Eigen::VectorXd cone_scale(ContactModel model, const Friction& friction) {
  const auto check = [](const char* name, double value) {
    if (!(std::isfinite(value) && value > 0)) {
      throw BadInput(fmt::format("a contact's {} must be positive, not {}", name, value));
    }
  };
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(components(model));
  if (model == ContactModel::frictionless) return scale;
  check("sliding friction", friction.sliding);
  scale[0] = friction.sliding;
  if (model == ContactModel::soft_finger) {
    check("eccentricity", friction.eccentricity);
    scale[3] = 1 / friction.eccentricity;
  }
  return scale;
}

double cone_slack(ContactModel model, const Friction& friction, const Eigen::VectorXd& force) {
  if (force.size() != components(model) || !force.allFinite()) {
    throw BadInput(fmt::format("a contact force needs {} finite components, not {} of sum {}",
                               components(model), force.size(), force.sum()));
  }
  const Eigen::VectorXd u = cone_scale(model, friction).cwiseProduct(force);
  return u[0] - u.tail(u.size() - 1).norm();
}

bool is_within_cone(ContactModel model, const Friction& friction, const Eigen::VectorXd& force,
                    double tolerance) {
  return cone_slack(model, friction, force) >= -tolerance;
}

}  // namespace palpate::grasping
