// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/hand/biotac_reading.hpp"

namespace palpate::tactile {

using hand::kElectrodes;
/// Channels of a log, in this order: the static pressure pdc, then the electrodes e1..e19.
inline constexpr int kBiotacChannels = 1 + kElectrodes;
using BiotacChannels = Eigen::Matrix<double, kBiotacChannels, 1>;

/// What is wrong with a frame. All but `late`, `drifted` and `out_of_order` forbid its use.
enum class BiotacFlag : unsigned {
  no_contact = 1u << 0,    ///< the pressure is that of rest
  missing = 1u << 1,       ///< a channel without a value
  out_of_range = 1u << 2,  ///< a count outside 0..4095
  saturated = 1u << 3,     ///< a count at the converter's end
  stuck = 1u << 4,         ///< an electrode keeps its count while the pressure changes
  repeated = 1u << 5,      ///< all channels equal those of the frame before
  late = 1u << 6,          ///< a gap before it, long against the log's period
  out_of_order = 1u << 7,  ///< it lies before the frame before it
  drifted = 1u << 8,       ///< the rest values have moved far since the log's start
  no_rest = 1u << 9,       ///< there is no rest to compare with
  unexplained = 1u << 10,  ///< no contact explains the channels
};
inline constexpr int kBiotacFlags = 11;

/// Names of the flags that are set, joined by "+".
std::string biotac_flag_names(unsigned flags);
/// Whether a frame with these flags may be used.
bool biotac_usable(unsigned flags);

/// A log of one BioTac: raw 12-bit counts.
struct BiotacLog {
  std::string name;
  std::vector<double> time;              ///< s
  std::vector<BiotacChannels> channels;  ///< counts; nan where missing
  /// Outward unit normal of the object in the sensor's frame, where the log gives it.
  std::vector<std::optional<Eigen::Vector3d>> normals;
};

/// Log from a CSV text with columns t_s,pdc,e1..e19 and, optionally, nx,ny,nz; others are ignored.
/// @param source  named in errors, as in "log.csv:3: ..."
/// @throws BadInput for a missing column, a cell that is neither a number nor empty, a time that is
///         not finite, a normal without direction, or no rows
BiotacLog parse_biotac_log(std::string_view text, const std::string& source);

/// As parse_biotac_log, from a file. @throws BadInput also if the file cannot be read
BiotacLog read_biotac_log(const std::filesystem::path& path);

/// A log freed of its rest values.
struct BiotacSignals {
  std::vector<BiotacChannels> rests;    ///< counts without contact at that time; nan: not known
  std::vector<BiotacChannels> changes;  ///< counts minus the rest at that time
  std::vector<unsigned> flags;          ///< BiotacFlag, or-ed
};

/// Change of the pressure, counts, from which on there is contact.
inline constexpr double kContactPressure = 20;

/// What the rest of a frame is found from.
enum class BiotacRest {
  whole_log,  ///< frames before and after it
  causal      ///< the frames up to it, as in a stream
};

/// Follows the slowly drifting rest values through a log and names faults.
///
/// Rest is where the pressure lies near its lower envelope, which may rise by at most 2 counts a
/// second. From the whole log, it may fall as slowly only, and in between the rest values are
/// interpolated, so that the start of a log need not be free of contact. Causally, rest is known
/// after ten quiet frames: a log that starts in contact has `no_rest` until the contact ends, or,
/// where its pressure does not change for a while, takes it for rest until the pressure falls
/// below.
BiotacSignals biotac_signals(const BiotacLog& log, BiotacRest rest = BiotacRest::whole_log);

}  // namespace palpate::tactile
