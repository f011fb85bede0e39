// SPDX-License-Identifier: Apache-2.0
#include "localization/tracking/contact_memory.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::localization {
namespace {

constexpr double kMinVariance = 1e-4;  // of a mean, those of a frame being 1

/// The contact of a frame that is the same fingertip's as the i-th of another.
const tactile::Contact* same_tip(const std::vector<tactile::Contact>& frame, std::size_t i,
                                 const tactile::Contact& contact) {
  if (contact.finger < 0) return i < frame.size() ? &frame[i] : nullptr;
  const auto found = std::find_if(frame.begin(), frame.end(), [&](const tactile::Contact& other) {
    return other.finger == contact.finger;
  });
  return found == frame.end() ? nullptr : &*found;
}

/// The contacts of all frames with the fingertip of the i-th contact of the last.
std::vector<const tactile::Contact*> tips_like(const ContactFrames& frames, std::size_t i) {
  std::vector<const tactile::Contact*> tips;
  for (const auto& frame : frames) {
    if (const auto* tip = same_tip(frame, i, frames.back()[i])) tips.push_back(tip);
  }
  return tips;
}

}  // namespace

double variance_of_mean(std::size_t count, const LastingErrors& errors) {
  const auto n = static_cast<double>(count);
  const double keep = std::exp(-errors.frame / errors.time);
  double sum = n;  // of the correlations of all pairs
  double correlation = 1;
  for (std::size_t lag = 1; lag < count; ++lag) {
    correlation *= keep;
    sum += 2 * static_cast<double>(count - lag) * correlation;
  }
  return errors.share * sum / (n * n) + (1 - errors.share) / n;
}

double covariance_of_means(std::size_t before, std::size_t count, const LastingErrors& errors) {
  const double keep = std::exp(-errors.frame / errors.time);
  const auto sum = [keep](std::size_t n) {  // of keep^i, i < n
    double power = 1, total = 0;
    for (std::size_t i = 0; i < n; ++i, power *= keep) total += power;
    return total;
  };
  return errors.share * keep * sum(before) * sum(count) / static_cast<double>(before * count);
}

KnownErrors mean_errors(const ContactFrames& frames, const geometry::ObjectModel& model,
                        const Eigen::Isometry3d& T_frame_object) {
  KnownErrors result{mean_contacts(frames, {}), {}};
  for (std::size_t i = 0; i < result.mean.size(); ++i) {
    result.frames.push_back(tips_like(frames, i).size());
  }
  const Eigen::Isometry3d T_object_frame = T_frame_object.inverse();
  for (tactile::Contact& contact : result.mean) {
    const auto surface = model.field().at((T_object_frame * contact.p).cast<float>());
    if (!surface) {
      contact.p.setZero();
      contact.n.setZero();
      continue;
    }
    const Eigen::Vector3d n =
        T_frame_object.linear() * surface->gradient.cast<double>().normalized();
    contact.p = static_cast<double>(surface->distance) * n;
    if (contact.has_normal()) contact.n -= n;
  }
  return result;
}

std::vector<tactile::Contact> mean_contacts(const ContactFrames& frames,
                                            const LastingErrors& errors,
                                            const KnownErrors& before) {
  std::vector<tactile::Contact> means;
  if (frames.empty()) return means;
  const auto& last = frames.back();
  for (std::size_t i = 0; i < last.size(); ++i) {
    const auto tips = tips_like(frames, i);
    tactile::Contact mean = last[i];
    mean.p.setZero();
    mean.n.setZero();
    for (const tactile::Contact* tip : tips) {
      mean.p += tip->p / static_cast<double>(tips.size());
      mean.n += tip->n;
    }
    mean.n.normalize();
    double variance = variance_of_mean(tips.size(), errors);
    if (const tactile::Contact* known = same_tip(before.mean, i, last[i])) {
      const std::size_t seen = before.frames[static_cast<std::size_t>(known - before.mean.data())];
      const double covariance = covariance_of_means(seen, tips.size(), errors);
      const double share = covariance / variance_of_mean(seen, errors);
      mean.p -= share * known->p;
      if (mean.has_normal()) mean.n = (mean.n - share * known->n).normalized();
      variance = std::max(kMinVariance, variance - share * covariance);
    }
    const double scale = std::sqrt(variance);
    mean.point_sigma *= scale;
    mean.normal_sigma *= scale;
    means.push_back(mean);
  }
  return means;
}

}  // namespace palpate::localization
