// SPDX-License-Identifier: Apache-2.0
#include "localization/search/moves.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::localization {
namespace {

constexpr double kNoiseWithoutContacts = 0.001;  // m
constexpr double kLongestStep = 1.2;             // times the noise
constexpr double kStepDecades = 1.3;             // steps spread over so many decades below that
constexpr double kTurnDecades = 1.7, kTurnScale = 3.2;  // turns about an axis: 0.06 .. 3.2 rad
constexpr double kFlipShare = 0.25, kFlipWidth = 0.05;  // half turns, and their spread in rad

Eigen::Vector3f normal3(RandomStream& random) { return random.normal3().cast<float>(); }

Eigen::Matrix3f turn_about(const Eigen::Vector3f& axis, double angle) {
  return Eigen::AngleAxisf(static_cast<float>(angle), axis).toRotationMatrix();
}

double heavy_tailed_angle(RandomStream& random) {
  const double turns = random.normal() * kTurnScale;
  return turns * std::pow(10.0, -kTurnDecades * random.uniform());
}

double median_point_sigma(const std::vector<tactile::Contact>& contacts) {
  if (contacts.empty()) return kNoiseWithoutContacts;
  std::vector<double> sigmas;
  for (const auto& contact : contacts) sigmas.push_back(contact.point_sigma);
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return *middle;
}

double mean_radius(const std::vector<geometry::ObjectModel::SurfacePoint>& surface) {
  double sum = 0;
  for (const auto& point : surface) sum += static_cast<double>(point.p.norm());
  return sum / static_cast<double>(surface.size());
}

}  // namespace

Moves::Moves(const geometry::ObjectModel& model, const Evidence& evidence)
    : noise_(median_point_sigma(evidence.contacts)), lever_(mean_radius(model.surface())) {
  for (const auto& contact : evidence.contacts) {
    anchors_.push_back({contact.p.cast<float>(), contact.n.normalized().cast<float>()});
    center_ += anchors_.back().p / static_cast<float>(evidence.contacts.size());
  }
  kinds_ = {Kind::about_origin, Kind::about_own_axis};
  if (!anchors_.empty()) {
    kinds_.insert(kinds_.end(), {Kind::about_contacts, Kind::about_contact_normal});
  }
  if (evidence.table) {
    table_axes_ = evidence.table->T_frame_table.linear().cast<float>();
    kinds_.insert(kinds_.end(), 4, Kind::about_up);
  }
}

SearchPose Moves::draw(const SearchPose& from, double width, RandomStream& random) const {
  const double shrink = std::pow(10.0, -kStepDecades * random.uniform());
  const double translation = kLongestStep * shrink * width * noise_;
  const Step step{translation, translation / lever_};
  switch (kinds_[random.index(kinds_.size())]) {
    case Kind::about_contacts:
      return jiggled(from, center_, step, random);
    case Kind::about_origin:
      return jiggled(from, from.t, step, random);
    case Kind::about_contact_normal:
      return about_contact_normal(from, step, random);
    case Kind::about_own_axis:
      return about_own_axis(from, step, random);
    case Kind::about_up:
      return about_up(from, step, random);
  }
  return from;
}

SearchPose Moves::jiggled(const SearchPose& from, const Eigen::Vector3f& center, Step step,
                          RandomStream& random) const {
  const auto rotation = static_cast<float>(step.rotation);
  SearchPose to = from.turned(turn_by(rotation * normal3(random)), center);
  to.t += static_cast<float>(step.translation) * normal3(random);
  return to;
}

SearchPose Moves::about_contact_normal(const SearchPose& from, Step step,
                                       RandomStream& random) const {
  const Anchor& anchor = anchors_[random.index(anchors_.size())];
  const double angle = 4 * step.rotation * random.normal();
  const bool known = !anchor.n.isZero(0);
  const Eigen::Vector3f axis = known ? anchor.n : random.unit_vector().cast<float>();
  return from.turned(turn_about(axis, angle), anchor.p);
}

SearchPose Moves::about_own_axis(const SearchPose& from, Step step, RandomStream& random) const {
  const auto axis = static_cast<Eigen::Index>(random.index(3));
  const bool flip = random.uniform() < kFlipShare;
  const double angle =
      flip ? std::numbers::pi + kFlipWidth * random.normal() : heavy_tailed_angle(random);
  SearchPose to = from.turned(turn_about(from.R.col(axis), angle), from.t);
  to.t += static_cast<float>(0.3 * step.translation) * normal3(random);
  return to;
}

/// Keeps the object standing as it does, which most other moves do not.
SearchPose Moves::about_up(const SearchPose& from, Step step, RandomStream& random) const {
  const bool far = random.uniform() < kFlipShare;
  const bool about_contacts = random.uniform() < 0.5;
  const double angle = far ? heavy_tailed_angle(random) : step.rotation * random.normal();
  const Eigen::Vector3f center = about_contacts && !anchors_.empty() ? center_ : from.t;
  SearchPose to = from.turned(turn_about(table_axes_.col(2), angle), center);
  const Eigen::Vector3f slide = static_cast<float>(step.translation) * normal3(random);
  to.t += table_axes_.leftCols<2>() * slide.head<2>();
  return to;
}

}  // namespace palpate::localization
