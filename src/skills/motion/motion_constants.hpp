// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace palpate::skills {

inline constexpr double kFreeHeight = 0.34;    ///< m of the mount, from where it may go anywhere
inline constexpr double kLeadTakenBack = 0.7;  ///< of the lead of the mount's command, at a touch
inline constexpr double kOpenSeconds = 0.4;
inline constexpr double kPlannedRate = 1.0;  ///< rad/s, of a closing planned; any has its path

}  // namespace palpate::skills
