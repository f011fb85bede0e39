// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/energy_maker.hpp"

#include <algorithm>

#include "localization/likelihood/balance_term.hpp"
#include "localization/likelihood/contact_term.hpp"
#include "localization/likelihood/plane_term.hpp"
#include "localization/likelihood/prior_term.hpp"
#include "localization/likelihood/table_term.hpp"

namespace palpate::localization {
namespace {

/// Of a prior that no contact can overrule: the floor holds nearly everywhere, so without contacts
/// most of the mass would be on it.
constexpr double kUncontestedFloor = 1e-12;
constexpr double kMinSigma = 1e-5;  // m, of a point: what is less does not lengthen the search

}  // namespace

EnergyMaker::EnergyMaker(const geometry::ObjectModel& model, const Evidence& evidence,
                         const LocalizerOptions& options)
    : model_(model),
      evidence_(evidence),
      contact_offset_(options.contact_offset),
      default_first_scale_(options.first_scale),
      first_point_sigma_(options.first_point_sigma) {
  if (evidence.prior) prior_ = std::make_shared<const PoseMixture>(*evidence.prior);
  if (evidence.free_space.empty()) return;
  balls_ = std::make_shared<const FreeSpaceTerm::Balls>(model, evidence);
}

double EnergyMaker::first_scale() const {
  double first = default_first_scale_;
  for (const tactile::Contact& contact : evidence_.contacts) {
    first = std::max(first, first_point_sigma_ / std::max(contact.point_sigma, kMinSigma));
  }
  return first;
}

/// Beyond options.first_scale only the errors of contacts with a small stated error grow, and up to
/// options.first_point_sigma.
Evidence EnergyMaker::widened(double scale) const {
  Evidence evidence = evidence_;
  for (tactile::Contact& contact : evidence.contacts) {
    if (default_first_scale_ * contact.point_sigma >= first_point_sigma_) continue;
    contact.point_sigma = std::min(scale * contact.point_sigma, first_point_sigma_) /
                          std::min(scale, default_first_scale_);
  }
  return evidence;
}

Energy EnergyMaker::operator()(double scale) const {
  const double usual = std::min(scale, default_first_scale_);
  Energy energy;  // cheap and informative terms first
  if (prior_) {
    const double floor = evidence_.contacts.empty() ? kUncontestedFloor : evidence_.prior->floor;
    energy.add(std::make_unique<PriorTerm>(prior_, floor));
  }
  if (evidence_.table) energy.add(std::make_unique<TableTerm>(model_, *evidence_.table));
  if (evidence_.balance) {
    energy.add(std::make_unique<BalanceTerm>(model_, *evidence_.balance, usual));
  }
  if (!evidence_.planes.empty()) {
    energy.add(std::make_unique<PlaneTerm>(model_, evidence_, usual));
  }
  if (!evidence_.contacts.empty()) {
    energy.add(std::make_unique<ContactTerm>(model_, widened(scale), contact_offset_, usual));
  }
  if (balls_) energy.add(std::make_unique<FreeSpaceTerm>(model_, evidence_, balls_, usual));
  return energy;
}

}  // namespace palpate::localization
