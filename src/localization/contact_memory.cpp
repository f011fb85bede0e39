// SPDX-License-Identifier: Apache-2.0
#include "contact_memory.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::localization {
namespace {

/// The contact of a frame that is the same fingertip's as the i-th of another.
const touch::Contact* same_tip(const std::vector<touch::Contact>& frame, std::size_t i,
                               const touch::Contact& contact) {
  if (contact.finger < 0) return i < frame.size() ? &frame[i] : nullptr;
  const auto found = std::find_if(frame.begin(), frame.end(), [&](const touch::Contact& other) {
    return other.finger == contact.finger;
  });
  return found == frame.end() ? nullptr : &*found;
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
    return (1 - std::pow(keep, static_cast<double>(n))) / (1 - keep);
  };
  return errors.share * keep * sum(before) * sum(count) / static_cast<double>(before * count);
}

KnownErrors mean_errors(const ContactFrames& frames, const ObjectModel& model,
                        const Eigen::Isometry3d& T_frame_object) {
  KnownErrors result{mean_contacts(frames, {}), frames.size()};
  const Eigen::Isometry3d T_object_frame = T_frame_object.inverse();
  for (touch::Contact& contact : result.mean) {
    const auto surface = model.field().at((T_object_frame * contact.p).cast<float>());
    if (!surface) {
      contact.p.setZero();
      contact.n.setZero();
      continue;
    }
    const Eigen::Vector3d n =
        T_frame_object.linear() * surface->gradient.cast<double>().normalized();
    contact.p = static_cast<double>(surface->distance) * n;
    contact.n -= n;
  }
  return result;
}

std::vector<touch::Contact> mean_contacts(const ContactFrames& frames, const LastingErrors& errors,
                                          const KnownErrors& before) {
  std::vector<touch::Contact> means;
  if (frames.empty()) return means;
  const auto& last = frames.back();
  for (std::size_t i = 0; i < last.size(); ++i) {
    touch::Contact mean = last[i];
    mean.p.setZero();
    mean.n.setZero();
    std::size_t count = 0;
    for (const auto& frame : frames) {
      const touch::Contact* contact = same_tip(frame, i, last[i]);
      if (!contact) continue;
      mean.p += contact->p;
      mean.n += contact->n;
      ++count;
    }
    mean.p /= static_cast<double>(count);
    mean.n.normalize();
    double variance = variance_of_mean(count, errors);
    if (const touch::Contact* known = same_tip(before.mean, i, last[i])) {
      const double covariance = covariance_of_means(before.frames, count, errors);
      const double share = covariance / variance_of_mean(before.frames, errors);
      mean.p -= share * known->p;
      mean.n = (mean.n - share * known->n).normalized();
      variance -= share * covariance;
    }
    const double scale = std::sqrt(variance);
    mean.point_sigma *= scale;
    mean.normal_sigma *= scale;
    means.push_back(mean);
  }
  return means;
}

}  // namespace palpate::localization
