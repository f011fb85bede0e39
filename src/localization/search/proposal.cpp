// SPDX-License-Identifier: Apache-2.0
#include "localization/search/proposal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "localization/likelihood/contact_noise.hpp"
#include "localization/likelihood/contact_term.hpp"
#include "localization/likelihood/pose_mixture.hpp"
#include "localization/likelihood/table_term.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

constexpr std::size_t kMaxAnchors = 5;
constexpr double kMinElsewhere = 0.2;  // of the draws, however sure the prior is

/// Contacts far from each other: each the farthest from those before it.
std::vector<tactile::Contact> spread_contacts(const std::vector<tactile::Contact>& contacts) {
  std::vector<tactile::Contact> chosen;
  std::vector<double> gap(contacts.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  while (chosen.size() < std::min(kMaxAnchors, contacts.size())) {
    chosen.push_back(contacts[next]);
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      gap[k] = std::min(gap[k], (contacts[k].p - chosen.back().p).squaredNorm());
    }
    next = static_cast<std::size_t>(std::max_element(gap.begin(), gap.end()) - gap.begin());
  }
  return chosen;
}

/// Contacts that bear their shared offset as noise of their own.
std::vector<tactile::Contact> displaced_contacts(const Evidence& evidence) {
  std::vector<tactile::Contact> contacts = evidence.contacts;
  for (const CommonModeBias& offset : evidence.offsets) {
    for (const auto& member : offset.members) {
      double& sigma = contacts[member.contact].point_sigma;
      sigma = std::hypot(sigma, offset.sigma);
    }
  }
  return contacts;
}

/// Contacts of which each touches by itself, or else the smallest set of candidates of which one
/// does.
std::vector<tactile::Contact> anchor_contacts(const std::vector<tactile::Contact>& contacts) {
  std::map<int, std::vector<tactile::Contact>> groups;
  for (const tactile::Contact& contact : contacts) {
    groups[contact.group].push_back(contact);
    groups[contact.group].back().group = -1;
  }
  if (const auto sure = groups.find(-1); sure != groups.end()) return spread_contacts(sure->second);
  return std::min_element(
             groups.begin(), groups.end(),
             [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); })
      ->second;
}

/// Poses that put some point of the surface at one of the contacts: a mixture of the posteriors
/// given a single contact each.
class AnchorProposal : public Proposal {
 public:
  AnchorProposal(const geometry::ObjectModel& model, Evidence evidence, double offset)
      : surface_(model.surface()),
        anchors_(anchor_contacts(displaced_contacts(evidence))),
        likelihood_(model, with_contacts(std::move(evidence), anchors_), offset, 1.0) {
    const auto count = static_cast<double>(anchors_.size());
    for (const tactile::Contact& contact : anchors_) {  // the roll is uniform
      peaks_.push_back(
          peak_contact_density(model.area(), contact.point_sigma, normal_sigma_of(contact)) /
          (2 * std::numbers::pi * count));
    }
  }

  SearchPose draw(RandomStream& random) const override {
    const tactile::Contact& anchor = anchors_[random.index(anchors_.size())];
    const auto& touched = surface_[random.index(surface_.size())];
    const Eigen::Vector3d n = draw_normal(anchor, random);
    const double roll = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Matrix3d onto = frame_with_z(n) * exp_so3(Eigen::Vector3d(0, 0, roll));
    SearchPose pose;
    pose.R = (onto * frame_with_z(touched.n.cast<double>()).transpose()).cast<float>();
    const Eigen::Vector3d at = anchor.p + anchor.point_sigma * random.normal3();
    pose.t = at.cast<float>() - pose.R * touched.p;
    return pose;
  }

  float energy(const SearchPose& pose) const override {
    double density = 0;
    for (std::size_t k = 0; k < anchors_.size(); ++k) {
      density += peaks_[k] * static_cast<double>(std::exp(-likelihood_.contact_energy(k, pose)));
    }
    return static_cast<float>(-std::log(density));
  }

 private:
  static Eigen::Vector3d draw_normal(const tactile::Contact& anchor, RandomStream& random) {
    if (!anchor.has_normal()) return random.unit_vector();
    const Eigen::Matrix3d tangent = frame_with_z(anchor.n);
    const double y = random.normal(), x = random.normal();
    const Eigen::Vector3d jitter(x, y, 0);
    return (anchor.n + anchor.normal_sigma * (tangent * jitter)).normalized();
  }

  static Evidence with_contacts(Evidence evidence, const std::vector<tactile::Contact>& contacts) {
    evidence.contacts = contacts;
    evidence.offsets.clear();
    evidence.noise_scale_prior = evidence.size_prior = 0;
    return evidence;
  }

  const std::vector<geometry::ObjectModel::SurfacePoint>& surface_;
  std::vector<tactile::Contact> anchors_;
  ContactTerm likelihood_;
  std::vector<double> peaks_;
};

class TableProposal : public Proposal {
 public:
  TableProposal(const geometry::ObjectModel& model, const TableSupport& table)
      : prior_(model, table), log_peak_(static_cast<float>(prior_.log_peak())) {}
  SearchPose draw(RandomStream& random) const override { return prior_.draw(random); }
  float energy(const SearchPose& pose) const override {
    return prior_.energy(pose, kNoBound) - log_peak_;
  }

 private:
  TableTerm prior_;
  float log_peak_;
};

/// The prior's mixture and, in case it is wrong, a share of some other proposal (which may be
/// none).
class PriorProposal : public Proposal {
 public:
  PriorProposal(const PosePrior& prior, std::unique_ptr<Proposal> elsewhere)
      : mixture_(prior),
        elsewhere_(std::move(elsewhere)),
        share_(elsewhere_ ? std::max(kMinElsewhere, 1 - total_weight(prior)) : 0),
        peak_((1 - share_) * std::exp(mixture_.log_peak())) {}

  SearchPose draw(RandomStream& random) const override {
    return random.uniform() < share_ ? elsewhere_->draw(random) : mixture_.draw(random);
  }

  float energy(const SearchPose& pose) const override {
    double density = std::numeric_limits<double>::min();  // its logarithm stays finite
    density += peak_ * mixture_.relative_density(pose);
    if (elsewhere_) density += share_ * std::exp(-static_cast<double>(elsewhere_->energy(pose)));
    return static_cast<float>(-std::log(density));
  }

 private:
  PoseMixture mixture_;
  std::unique_ptr<Proposal> elsewhere_;
  double share_;
  double peak_;
};

/// What the search starts from without a prior; none without a table and contacts.
std::unique_ptr<Proposal> proposal_without_prior(const geometry::ObjectModel& model,
                                                 const Evidence& evidence,
                                                 const LocalizerOptions& options) {
  if (evidence.table) return std::make_unique<TableProposal>(model, *evidence.table);
  if (evidence.contacts.empty()) return nullptr;
  return std::make_unique<AnchorProposal>(model, evidence, options.contact_offset);
}

}  // namespace

std::unique_ptr<Proposal> make_proposal(const geometry::ObjectModel& model,
                                        const Evidence& evidence, const LocalizerOptions& options) {
  auto proposal = proposal_without_prior(model, evidence, options);
  if (!evidence.prior) return proposal;
  return std::make_unique<PriorProposal>(*evidence.prior, std::move(proposal));
}

std::unique_ptr<Proposal> mixture_proposal(const PosePrior& mixture) {
  return std::make_unique<PriorProposal>(mixture, nullptr);
}

}  // namespace palpate::localization
