// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/force_closure.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "grasping/wrench_space.hpp"
#include "numerics/cone_program.hpp"
#include "palpate/core/error.hpp"

namespace palpate::grasping {
namespace {

constexpr double kLength = 0.05;      // m, over which moments count like forces
constexpr double kAccuracy = 1e-9;    // N
constexpr double kPositive = 1e-7;    // N, above which a margin is not one of rounding
constexpr double kNoSolution = 1e-8;  // residual, relative, of equations without a solution

Eigen::Vector3d center(const GraspContacts& contacts) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const GraspContact& contact : contacts) sum += contact.T_mount_contact.translation();
  return sum / static_cast<double>(contacts.size());
}

/// Cones for u = particular + directions z less s along their axes, for x = [z; s].
numerics::ConeProgram slack_program(const WrenchSpace& space, const AffineSpace& affine) {
  const Eigen::Index m = affine.particular.size(), k = affine.directions.cols();
  numerics::ConeProgram program;
  program.P = Eigen::MatrixXd::Zero(k + 1, k + 1);
  program.q = -Eigen::VectorXd::Unit(k + 1, k);
  program.F.resize(m, k + 1);
  program.F << affine.directions, -space.axis;
  program.g = affine.particular;
  program.sizes = space.sizes;
  return program;
}

/// x = [0; s] with s below what the cones allow.
Eigen::VectorXd below(const numerics::ConeProgram& program) {
  const double slack = numerics::min_slack(program.g, program.sizes);
  return (slack - 1) * Eigen::VectorXd::Unit(program.q.size(), program.q.size() - 1);
}

/// Adds rows to F x + g >= 0.
void add_bounds(numerics::ConeProgram& program, const Eigen::MatrixXd& F,
                const Eigen::VectorXd& g) {
  const Eigen::MatrixXd old_F = program.F;
  const Eigen::VectorXd old_g = program.g;
  program.F.resize(old_F.rows() + F.rows(), old_F.cols());
  program.F << old_F, F;
  program.g.resize(old_g.size() + g.size());
  program.g << old_g, g;
  program.sizes.insert(program.sizes.end(), static_cast<std::size_t>(g.size()), 1);
}

/// Normal force of each contact, as rows over u.
Eigen::MatrixXd normal_rows(const WrenchSpace& space) {
  Eigen::MatrixXd rows =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(space.sizes.size()), space.axis.size());
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < space.sizes.size(); ++i) {
    rows(static_cast<Eigen::Index>(i), at) = space.normal_per_axis[at];
    at += space.sizes[i];
  }
  return rows;
}

/// The cones and the limit of the normal forces, all with slack s (N), itself at most the limit.
numerics::ConeProgram feasibility(const WrenchSpace& space, const AffineSpace& affine,
                                  double limit) {
  numerics::ConeProgram program = slack_program(space, affine);
  const Eigen::Index k = affine.directions.cols();
  const Eigen::MatrixXd normal = normal_rows(space);
  Eigen::MatrixXd F(normal.rows() + 1, k + 1);
  F << -normal * affine.directions, -Eigen::VectorXd::Ones(normal.rows()),
      -Eigen::RowVectorXd::Unit(k + 1, k);
  Eigen::VectorXd g(normal.rows() + 1);
  g << Eigen::VectorXd::Constant(normal.rows(), limit) - normal * affine.particular, limit;
  add_bounds(program, F, g);
  return program;
}

/// Least |u|^2 / 2 in the same set, s being 0.
numerics::ConeProgram min_forces(const numerics::ConeProgram& feasible, const AffineSpace& affine) {
  const Eigen::Index k = affine.directions.cols();
  numerics::ConeProgram program = feasible;
  program.F = feasible.F.leftCols(k);
  program.P = Eigen::MatrixXd::Identity(k, k);  // the particular solution is normal to directions
  program.q = Eigen::VectorXd::Zero(k);
  return program;
}

}  // namespace

ForceClosure force_closure(const GraspContacts& contacts) {
  ForceClosure result;
  result.margin = -std::numeric_limits<double>::infinity();
  if (contacts.empty()) return result;
  const WrenchSpace space = wrench_space(contacts, center(contacts), kLength);
  result.rank = solve_affine(space.wrenches, Vector6d::Zero()).rank;
  Eigen::MatrixXd A(7, space.wrenches.cols());
  A << space.wrenches, space.normal_per_axis.transpose();
  Eigen::VectorXd unit_sum = Eigen::VectorXd::Unit(7, 6);
  const AffineSpace internal = solve_affine(A, unit_sum);
  if (internal.residual > kNoSolution) return result;
  const numerics::ConeProgram program = slack_program(space, internal);
  const numerics::ConeSolution solution = numerics::solve(program, below(program), kAccuracy);
  result.margin = solution.x[solution.x.size() - 1];
  result.closed = result.rank == 6 && result.margin > kPositive;
  return result;
}

Balance balance_wrench(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object,
                       const Vector6d& wrench, const BalanceOptions& options) {
  if (!(std::isfinite(options.max_normal_force) && options.max_normal_force > 0)) {
    throw BadInput(
        fmt::format("max_normal_force must be positive, not {}", options.max_normal_force));
  }
  if (!wrench.allFinite()) {
    throw BadInput(fmt::format("a wrench to balance must be finite, not [{}, {}, {}; {}, {}, {}]",
                               wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5]));
  }
  Balance result;
  result.slack = -wrench.norm();
  if (contacts.empty()) return result;
  const WrenchSpace space = wrench_space(contacts, p_mount_object, kLength);
  Vector6d scaled = wrench;
  scaled.head<3>() /= kLength;
  const AffineSpace affine = solve_affine(space.wrenches, scaled);
  if (affine.residual > kNoSolution * (1 + scaled.norm())) return result;
  const numerics::ConeProgram feasible = feasibility(space, affine, options.max_normal_force);
  const numerics::ConeSolution inside =
      numerics::solve(feasible, below(feasible), 1e-6 * kAccuracy);
  result.steps = inside.steps;
  const Eigen::Index k = affine.directions.cols();
  result.slack = inside.x[k];
  if (!(result.slack > kPositive)) return result;
  const numerics::ConeProgram least = min_forces(feasible, affine);
  const numerics::ConeSolution forces =
      numerics::solve(least, inside.x.head(k), kAccuracy * (1 + scaled.squaredNorm()));
  result.steps += forces.steps;
  result.status = BalanceStatus::balanced;
  const Eigen::VectorXd u = affine.particular + affine.directions * forces.x;
  result.contact_wrenches = transmission(contacts).transpose() * u.cwiseQuotient(space.scale);
  return result;
}

}  // namespace palpate::grasping
