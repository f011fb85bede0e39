// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/energy_maker.hpp"

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

}  // namespace

EnergyMaker::EnergyMaker(const geometry::ObjectModel& model, const Evidence& evidence,
                         double contact_offset)
    : model_(model), evidence_(evidence), contact_offset_(contact_offset) {
  if (evidence.prior) prior_ = std::make_shared<const PoseMixture>(*evidence.prior);
  if (evidence.free_space.empty()) return;
  balls_ = std::make_shared<const FreeSpaceTerm::Balls>(model, evidence);
}

Energy EnergyMaker::operator()(double scale) const {
  Energy energy;  // cheap and telling terms first
  if (prior_) {
    const double floor = evidence_.contacts.empty() ? kUncontestedFloor : evidence_.prior->floor;
    energy.add(std::make_unique<PriorTerm>(prior_, floor));
  }
  if (evidence_.table) energy.add(std::make_unique<TableTerm>(model_, *evidence_.table));
  if (evidence_.balance) {
    energy.add(std::make_unique<BalanceTerm>(model_, *evidence_.balance, scale));
  }
  if (!evidence_.planes.empty()) {
    energy.add(std::make_unique<PlaneTerm>(model_, evidence_, scale));
  }
  if (!evidence_.contacts.empty()) {
    energy.add(std::make_unique<ContactTerm>(model_, evidence_, contact_offset_, scale));
  }
  if (balls_) energy.add(std::make_unique<FreeSpaceTerm>(model_, evidence_, balls_, scale));
  return energy;
}

}  // namespace palpate::localization
