// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace palpate::grasping {

/// What a contact can transmit (thesis figure 4.1), in the contact's frame {n, t, o}, n into the
/// object.
enum class ContactModel {
  frictionless,  ///< point without friction: f_n
  hard_finger,   ///< f_n, f_t, f_o
  soft_finger    ///< f_n, f_t, f_o, m_n
};

struct Friction {
  double sliding = 0.8;        ///< mu, tangential force over normal force (thesis eq 4.1)
  double eccentricity = 0.01;  ///< e_n, m: moment about the normal over tangential force (eq 4.3)
};

/// Number of components that the model transmits: 1, 3 or 4.
int components(ContactModel model);

/// Which of the six components [m_n m_t m_o f_n f_t f_o] of a contact wrench the model transmits:
/// (components x 6), one 1 a row, in the order f_n, f_t, f_o, m_n.
Eigen::MatrixXd transmission(ContactModel model);

/// Diagonal that takes transmitted components to a vector u of a Lorentz cone u_0 >= |u_1..|, which
/// is the friction cone (eq 4.2) or ellipsoid (eq 4.3): mu f_n, f_t, f_o, m_n / e_n.
/// @throws BadInput for friction that is not finite and positive
Eigen::VectorXd cone_scale(ContactModel model, const Friction& friction);

/// How far a contact force is within its cone, N: mu f_n less the load that friction bears,
/// sqrt(f_t^2 + f_o^2 + m_n^2 / e_n^2); f_n without friction. Negative outside.
/// @param force  the transmitted components, N and N m
/// @throws BadInput for a force of the wrong size or a value that is not finite
double cone_slack(ContactModel model, const Friction& friction, const Eigen::VectorXd& force);

/// Whether a contact force is one that the contact can transmit.
bool is_within_cone(ContactModel model, const Friction& friction, const Eigen::VectorXd& force,
                    double tolerance = 0);

}  // namespace palpate::grasping
