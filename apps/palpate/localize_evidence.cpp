// SPDX-License-Identifier: Apache-2.0
#include "localize_evidence.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/localization/contacts_io.hpp"
#include "palpate/localization/pose_prior.hpp"
#include "palpate/recording/json_text.hpp"

namespace palpate::app {
namespace {

namespace lo = localization;

constexpr double kFar = 20;  // sizes of the object, from the contacts' median

Eigen::Vector3d median_of(const std::vector<tactile::Contact>& contacts) {
  Eigen::Vector3d result;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto& contact : contacts) values.push_back(contact.p[axis]);
    result[axis] = median(values);
  }
  return result;
}

Eigen::Vector3d vector_of(const nlohmann::json& values) {
  const auto v = values.get<std::array<double, 3>>();
  return {v[0], v[1], v[2]};
}

/// A mode as it stands in a report, of the mesh's own coordinates.
lo::Mode mode_of(const nlohmann::json& entry, const Eigen::Isometry3d& T_mesh_object) {
  lo::Mode mode;
  const auto pose = entry.at("T_contact_object").get<std::array<double, 16>>();
  const Eigen::Isometry3d T_contact_mesh = pose_from_row_major(pose);
  mode.T_frame_object = T_contact_mesh * T_mesh_object;
  mode.weight = entry.at("weight").get<double>();
  auto covariance = entry.at("covariance").get<std::array<double, 36>>();
  mode.covariance = covariance_at(
      T_contact_mesh.linear() * T_mesh_object.translation(),
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(covariance.data()));
  if (const auto& axis = entry.at("free_axis"); !axis.is_null()) {
    mode.free_axis = {vector_of(axis.at("point")), vector_of(axis.at("direction")),
                      axis.at("extent").get<double>()};
  }
  return mode;
}

/// Of the object that a report names best, in any size, among several candidates; one of the single
/// one.
double object_probability(const nlohmann::json& report, const std::string& object) {
  const std::string shape = geometry::sized_name(object).name;
  double probability = 0;
  for (const auto& candidate : report.value("objects", nlohmann::json::array())) {
    if (geometry::sized_name(candidate.at("name").get<std::string>()).name != shape) continue;
    probability += candidate.at("probability").get<double>();
  }
  return probability > 0 ? probability : 1;
}

/// Where the contacts are, or where nothing is touched the poses of what was known before.
Eigen::AlignedBox3d rough_place(const lo::Evidence& evidence) {
  Eigen::AlignedBox3d box;
  for (const tactile::Contact& contact : evidence.contacts) box.extend(contact.p);
  if (!box.isEmpty()) return box;
  if (!evidence.prior) return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (const auto& component : evidence.prior->components) {
    box.extend(component.T_frame_object.translation());
  }
  return box;
}

}  // namespace

Matrix6d covariance_at(const Eigen::Vector3d& arm, const Matrix6d& covariance) {
  Matrix6d J = Matrix6d::Identity();
  J.bottomLeftCorner<3, 3>() = -skew(arm);
  return J * covariance * J.transpose();
}

lo::TableSupport table_at(double height, const lo::Evidence& evidence,
                          const geometry::KnownObject& object) {
  const Eigen::AlignedBox3d place = rough_place(evidence);
  const Eigen::Vector3d middle = place.center();
  lo::TableSupport table;
  table.T_frame_table = Eigen::Isometry3d::Identity();
  table.T_frame_table.translation() << middle.x(), middle.y(), height;
  table.half_width = geometry::bounds(object.mesh).diagonal().norm();
  if (evidence.contacts.empty()) table.half_width += 0.5 * place.diagonal().norm();
  return table;
}

lo::PosePrior read_prior(const std::filesystem::path& path, const std::string& object,
                         const Eigen::Isometry3d& T_mesh_object) {
  try {
    lo::Posterior before;
    const auto report = recording::parse_json(read_file(path));
    const auto of = report.value("object", object);
    if (std::filesystem::path(of).filename() != std::filesystem::path(object).filename()) {
      throw BadInput(fmt::format("the report is of the object '{}', not of '{}'", of, object));
    }
    for (const auto& entry : report.at("modes")) {
      before.modes.push_back(mode_of(entry, T_mesh_object));
    }
    for (const auto& entry : report.at("residual_set")) {
      const Eigen::Isometry3d T_contact_mesh =
          pose_from_row_major(entry.get<std::array<double, 16>>());
      before.residual_set.push_back(T_contact_mesh * T_mesh_object);
    }
    before.credible_mass = report.at("credible_mass").get<double>();
    before = lo::weighted(std::move(before), 1 / object_probability(report, of));
    return lo::prior_from(before, Matrix6d::Zero());
  } catch (const nlohmann::json::exception&) {
    throw BadInput(fmt::format(
        "{} is not a report that palpate localize --json wrote, or it is damaged", path.string()));
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("{}: {}", path.string(), error.what()));
  }
}

void check_together(const ContactFile& file, double size) {
  const auto& contacts = file.contacts;
  if (contacts.empty()) return;
  const Eigen::Vector3d middle = median_of(contacts);
  std::vector<std::size_t> far;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if ((contacts[k].p - middle).norm() > kFar * size) far.push_back(k);
  }
  if (far.empty() || 2 * far.size() >= contacts.size()) return;
  const auto lines = lo::contact_lines(file.text, file.name);
  const std::string more =
      far.size() == 1 ? "" : fmt::format(", and {} more are as far", far.size() - 1);
  throw BadInput(fmt::format("{}:{}: the contact is {:.3g} m from the others{}", file.name,
                             lines.at(far.front()), (contacts[far.front()].p - middle).norm(),
                             more));
}

}  // namespace palpate::app
