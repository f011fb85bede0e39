// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// How the errors of a frame's contacts hang together with those of other frames: a share of their
/// variance keeps for a time (Ornstein-Uhlenbeck), the rest is white.
struct LastingErrors {
  double share = 0.5;
  double time = 0.5;    ///< s
  double frame = 0.01;  ///< s between frames
};

/// Contacts of each of some frames, carried along with the object to the present.
using ContactFrames = std::vector<std::vector<tactile::Contact>>;

/// Variance of the mean of errors of `count` frames, those of a frame being 1.
double variance_of_mean(std::size_t count, const LastingErrors& errors);

/// Covariance of that mean with the mean over `before` frames just before them.
double covariance_of_means(std::size_t before, std::size_t count, const LastingErrors& errors);

/// What is known of the contacts' errors: `p` and `n` of each is the mean over some frames of what
/// was sensed, less what the pose known then predicts.
struct KnownErrors {
  std::vector<tactile::Contact> mean;
  std::vector<std::size_t> frames;  ///< in which each was sensed
};

/// Off the surface, and off its normal.
KnownErrors mean_errors(const ContactFrames& frames, const geometry::ObjectModel& model,
                        const Eigen::Isometry3d& T_frame_object);

/// One contact for each fingertip that touches in the last frame, or for each place in the frame
/// where fingers are unknown: the mean over the frames in which it touches, less what is expected
/// of the errors known from just before them. Its sigmas are those of a frame times the root of the
/// variance that is left.
std::vector<tactile::Contact> mean_contacts(const ContactFrames& frames,
                                            const LastingErrors& errors,
                                            const KnownErrors& before = {});

}  // namespace palpate::localization
