// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/quadratic_form.hpp"

#include <Eigen/Eigenvalues>

namespace palpate::registration {
namespace {

double weight_of(const std::vector<double>& weights, std::size_t i) {
  return weights.empty() ? 1 : weights[i];
}

/// Sums that the point form is made of: C_i = I_3 makes it (X kron I_3) with X = sum w x~ x~'.
struct PointMoments {
  Eigen::Matrix4d xx = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 3, 4> yx = Eigen::Matrix<double, 3, 4>::Zero();
  double yy = 0;

  void add(double w, const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
    const Eigen::Vector4d h(x[0], x[1], x[2], 1), wh = w * h;
    xx.noalias() += wh * h.transpose();
    yx.noalias() += y * wh.transpose();
    yy += w * y.squaredNorm();
  }

  Matrix13d form() const {
    Matrix13d M = Matrix13d::Zero();
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) M.block<3, 3>(3 * a, 3 * b).diagonal().setConstant(xx(a, b));
      M.block<3, 1>(3 * a, 12) = -yx.col(a);
    }
    M.row(12).head<12>() = M.col(12).head<12>().transpose();
    M(12, 12) = yy;
    return M;
  }
};

/// Sums that the plane form is made of: its rows are (x~ kron n, -n'y), x~ = (x, 1), so that it
/// takes the products of x~ with those of n.
struct PlaneMoments {
  Eigen::Matrix<double, 6, 10> products = Eigen::Matrix<double, 6, 10>::Zero();  // upper triangles
  Eigen::Matrix<double, 3, 4> mixed = Eigen::Matrix<double, 3, 4>::Zero();
  double squares = 0;

  void add(double w, const Eigen::Vector3d& x, const Eigen::Vector3d& y, const Eigen::Vector3d& n) {
    const double distance = w * n.dot(y);
    Eigen::Matrix<double, 6, 1> nn;
    nn << n[0] * n[0], n[0] * n[1], n[0] * n[2], n[1] * n[1], n[1] * n[2], n[2] * n[2];
    Eigen::Matrix<double, 1, 10> xx;
    xx << x[0] * x[0], x[0] * x[1], x[0] * x[2], x[0], x[1] * x[1], x[1] * x[2], x[1], x[2] * x[2],
        x[2], 1;
    products.noalias() += nn * (w * xx).eval();
    mixed.noalias() += n * (distance * Eigen::RowVector4d(x[0], x[1], x[2], 1)).eval();
    squares += distance * n.dot(y);
  }

  Matrix13d form() const {
    Matrix13d M;
    for (int a = 0, ab = 0; a < 4; ++a) {
      for (int b = a; b < 4; ++b, ++ab) {
        Eigen::Matrix3d block;
        for (int i = 0, ij = 0; i < 3; ++i) {
          for (int j = i; j < 3; ++j, ++ij) block(i, j) = block(j, i) = products(ij, ab);
        }
        M.block<3, 3>(3 * a, 3 * b) = M.block<3, 3>(3 * b, 3 * a) = block;
      }
      M.block<3, 1>(3 * a, 12) = -mixed.col(a);
    }
    M.row(12).head<12>() = M.col(12).head<12>().transpose();
    M(12, 12) = squares;
    return M;
  }
};

}  // namespace

Origins weighted_means(const Correspondences& correspondences, const std::vector<double>& weights) {
  Origins means;
  double sum = 0;
  // Relative to a first point: sums of far coordinates would round.
  const std::size_t count = correspondences.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double w = weight_of(weights, i);
    sum += w;
    means.source += w * (correspondences.source[i] - correspondences.source[0]);
    means.target += w * (correspondences.target[i] - correspondences.target[0]);
  }
  if (sum <= 0) return {};
  means.source = means.source / sum + correspondences.source[0];
  means.target = means.target / sum + correspondences.target[0];
  return means;
}

Vector10d homogeneous(const Eigen::Matrix3d& R) {
  Vector10d r;
  r << R.col(0), R.col(1), R.col(2), 1;
  return r;
}

Vector13d homogeneous(const Eigen::Isometry3d& T) {
  Vector13d tau;
  tau << T.linear().col(0), T.linear().col(1), T.linear().col(2), T.translation(), 1;
  return tau;
}

Matrix13d quadratic_form(const Correspondences& correspondences, const std::vector<double>& weights,
                         Primitive primitive, const Origins& origins) {
  PointMoments points;
  PlaneMoments planes;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    const double w = weight_of(weights, i);
    if (w == 0) continue;
    const Eigen::Vector3d x = correspondences.source[i] - origins.source;
    const Eigen::Vector3d y = correspondences.target[i] - origins.target;
    if (primitive == Primitive::kPoint) {
      points.add(w, x, y);
    } else {
      planes.add(w, x, y, correspondences.target_normals[i]);
    }
  }
  return primitive == Primitive::kPoint ? points.form() : planes.form();
}

MarginalForm marginalize(const Matrix13d& form) {
  constexpr double kRank = 1e-12;  // relative to the largest eigenvalue of M_tt
  Matrix10d rotation;              // M without the translation's rows and columns
  rotation << form.topLeftCorner<9, 9>(), form.block<9, 1>(0, 12), form.block<1, 9>(12, 0),
      form(12, 12);
  Eigen::Matrix<double, 3, 10> cross;
  cross << form.block<3, 9>(9, 0), form.block<3, 1>(9, 12);
  const Eigen::Matrix3d tt = form.block<3, 3>(9, 9);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(tt);
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value > kRank * eigen.eigenvalues()[2]) inverse[i] = 1 / value;
  }
  MarginalForm result;
  result.translation =
      -(eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose() * cross);
  result.objective = rotation + cross.transpose() * result.translation;
  result.objective = (0.5 * (result.objective + result.objective.transpose())).eval();
  return result;
}

Matrix6d information_matrix(const Correspondences& correspondences,
                            const std::vector<double>& weights, Primitive primitive,
                            const Eigen::Isometry3d& T_target_source,
                            const Eigen::Vector3d& center) {
  Matrix6d information = Matrix6d::Zero();
  Eigen::Matrix3d arms = Eigen::Matrix3d::Zero();  // sum of w arm arm'
  Eigen::Vector3d arm_sum = Eigen::Vector3d::Zero();
  double sum = 0;
  const Eigen::Matrix3d R = T_target_source.linear();
  const Eigen::Vector3d t = T_target_source.translation() - center;
  for (std::size_t i = 0; i < correspondences.size(); ++i) {
    const double w = weight_of(weights, i);
    if (w == 0) continue;
    const Eigen::Vector3d arm = R * correspondences.source[i] + t;
    if (primitive == Primitive::kPlane) {
      const Eigen::Vector3d& n = correspondences.target_normals[i];
      Vector6d row;
      row << arm.cross(n), n;
      information.noalias() += w * row * row.transpose();
    } else {
      arms.noalias() += (w * arm) * arm.transpose();
      arm_sum += w * arm;
      sum += w;
    }
  }
  if (primitive == Primitive::kPlane) return information;
  information.topLeftCorner<3, 3>() = arms.trace() * Eigen::Matrix3d::Identity() - arms;
  information.topRightCorner<3, 3>() = skew(arm_sum);
  information.bottomLeftCorner<3, 3>() = -skew(arm_sum);
  information.bottomRightCorner<3, 3>() = sum * Eigen::Matrix3d::Identity();
  return information;
}

}  // namespace palpate::registration
