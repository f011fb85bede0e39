// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "palpate/core/statistics.hpp"
#include "tactile/biotac/faults.hpp"
#include "tactile/biotac/rest_tracker.hpp"

namespace palpate::tactile {
namespace {

constexpr std::size_t kBlock = 5;  // frames whose median stands for them
constexpr double kDriftRate = 2;   // counts/s, of the envelope
constexpr double kQuiet = 12;      // counts above the envelope that still are rest
constexpr auto kStuck = static_cast<std::size_t>(kStuckFrames);

bool is_sound(unsigned flags) {
  return (flags & (bit(BiotacFlag::missing) | bit(BiotacFlag::out_of_range))) == 0;
}

void flag_times(const BiotacLog& log, std::vector<unsigned>& flags) {
  const std::size_t n = log.time.size();
  const double span = log.time.back() - log.time.front();
  // Clocks that tick coarsely repeat their times; a gap is long only against both.
  const double gap =
      std::max(0.25, 5 * span / static_cast<double>(std::max<std::size_t>(1, n - 1)));
  for (std::size_t i = 1; i < n; ++i) {
    const double step = log.time[i] - log.time[i - 1];
    if (step < 0) flags[i] |= bit(BiotacFlag::out_of_order);
    if (step > gap) flags[i] |= bit(BiotacFlag::late);
    if (log.channels[i] == log.channels[i - 1]) flags[i] |= bit(BiotacFlag::repeated);
  }
}

/// Flags the frames in which an electrode keeps its count for long while the pressure changes;
/// causally, only those from which on that has been seen.
void flag_stuck(const BiotacLog& log, BiotacRest rest, std::vector<unsigned>& flags) {
  const std::size_t n = log.time.size();
  for (int c = 1; c < kBiotacChannels; ++c) {
    for (std::size_t start = 0, end = 0; start < n; start = end) {
      double low = log.channels[start][0], high = low;
      std::optional<std::size_t> seen;
      for (end = start; end < n && log.channels[end][c] == log.channels[start][c]; ++end) {
        low = std::min(low, log.channels[end][0]);
        high = std::max(high, log.channels[end][0]);
        const bool stuck = end - start + 1 >= kStuck && high - low > kStuckPressure;
        if (stuck && !seen) seen = rest == BiotacRest::causal ? end : start;
      }
      if (end == start) ++end;  // nan
      for (std::size_t i = seen.value_or(end); i < end; ++i) flags[i] |= bit(BiotacFlag::stuck);
    }
  }
}

/// The medians of a few frames that follow each other.
struct Block {
  double time;
  BiotacChannels median;
};

std::vector<Block> blocks_of(const BiotacLog& log, const std::vector<unsigned>& flags) {
  std::vector<std::size_t> sound;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (is_sound(flags[i])) sound.push_back(i);
  }
  std::vector<Block> blocks;
  std::vector<double> values;
  for (std::size_t start = 0; start < sound.size(); start += kBlock) {
    const std::size_t end = std::min(start + kBlock, sound.size());
    Block block{.time = log.time[sound[(start + end) / 2]], .median = {}};
    for (int c = 0; c < kBiotacChannels; ++c) {
      values.clear();
      for (std::size_t i = start; i < end; ++i) values.push_back(log.channels[sound[i]][c]);
      block.median[c] = median(values);
    }
    blocks.push_back(block);
  }
  std::stable_sort(blocks.begin(), blocks.end(),
                   [](const Block& a, const Block& b) { return a.time < b.time; });
  return blocks;
}

/// Blocks near the lower envelope of the pressure, whose slope is limited.
std::vector<Block> quiet_blocks(const std::vector<Block>& blocks) {
  std::vector<double> envelope;
  for (const Block& block : blocks) envelope.push_back(block.median[0]);
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    const double rise = kDriftRate * (blocks[i].time - blocks[i - 1].time);
    envelope[i] = std::min(envelope[i], envelope[i - 1] + rise);
  }
  for (std::size_t i = blocks.size(); i-- > 1;) {
    const double rise = kDriftRate * (blocks[i].time - blocks[i - 1].time);
    envelope[i - 1] = std::min(envelope[i - 1], envelope[i] + rise);
  }
  std::vector<Block> quiet;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].median[0] < envelope[i] + kQuiet) quiet.push_back(blocks[i]);
  }
  return quiet;
}

/// Median of each block and its two neighbours, channel by channel.
std::vector<Block> smoothed(const std::vector<Block>& blocks) {
  auto result = blocks;
  for (std::size_t i = 1; i + 1 < blocks.size(); ++i) {
    for (int c = 0; c < kBiotacChannels; ++c) {
      const double a = blocks[i - 1].median[c], b = blocks[i].median[c],
                   d = blocks[i + 1].median[c];
      result[i].median[c] = std::max(std::min(a, b), std::min(std::max(a, b), d));
    }
  }
  return result;
}

BiotacChannels rest_at(const std::vector<Block>& rest, double time) {
  const auto after = std::lower_bound(rest.begin(), rest.end(), time,
                                      [](const Block& b, double t) { return b.time < t; });
  if (after == rest.begin()) return rest.front().median;
  if (after == rest.end()) return rest.back().median;
  const Block& before = *(after - 1);
  const double span = after->time - before.time;
  const double share = span > 0 ? (time - before.time) / span : 0;
  return (1 - share) * before.median + share * after->median;
}

const BiotacChannels kUnknown = BiotacChannels::Constant(std::nan(""));

std::vector<BiotacChannels> interpolated_rests(const BiotacLog& log,
                                               const std::vector<unsigned>& flags) {
  const auto rest = smoothed(quiet_blocks(blocks_of(log, flags)));
  std::vector<BiotacChannels> rests(log.time.size(), kUnknown);
  for (std::size_t i = 0; i < rests.size() && !rest.empty(); ++i) {
    rests[i] = rest_at(rest, log.time[i]);
  }
  return rests;
}

std::vector<BiotacChannels> causal_rests(const BiotacLog& log, const std::vector<unsigned>& flags) {
  BiotacRestTracker tracker;
  std::vector<BiotacChannels> rests;
  BiotacChannels now = kUnknown;
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    if (is_sound(flags[i])) now = tracker.step(log.time[i], log.channels[i]).value_or(kUnknown);
    rests.push_back(now);
  }
  return rests;
}

}  // namespace

unsigned count_flags(const BiotacChannels& channels) {
  unsigned flags = 0;
  for (const double count : channels) {
    if (std::isnan(count)) {
      flags |= bit(BiotacFlag::missing);
    } else if (count < 0 || count > hand::kBiotacFullScale) {
      flags |= bit(BiotacFlag::out_of_range);
    } else if (count == 0 || count == hand::kBiotacFullScale) {
      flags |= bit(BiotacFlag::saturated);
    }
  }
  return flags;
}

bool far_from(const BiotacChannels& rest, const BiotacChannels& start) {
  const BiotacChannels change = (rest - start).cwiseAbs();
  return change[0] > kPressureDrift || change.tail<kElectrodes>().maxCoeff() > kElectrodeDrift;
}

BiotacSignals biotac_signals(const BiotacLog& log, BiotacRest rest) {
  BiotacSignals signals;
  for (const auto& channels : log.channels) signals.flags.push_back(count_flags(channels));
  flag_times(log, signals.flags);
  flag_stuck(log, rest, signals.flags);
  signals.rests = rest == BiotacRest::causal ? causal_rests(log, signals.flags)
                                             : interpolated_rests(log, signals.flags);
  std::optional<BiotacChannels> first;
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    const BiotacChannels& now = signals.rests[i];
    signals.changes.emplace_back(log.channels[i] - now);
    if (!now.allFinite()) {
      signals.flags[i] |= bit(BiotacFlag::no_rest);
      continue;
    }
    if (!first) first = now;
    if (far_from(now, *first)) signals.flags[i] |= bit(BiotacFlag::drifted);
    if (signals.changes[i][0] <= kContactPressure) {
      signals.flags[i] |= bit(BiotacFlag::no_contact);
    }
  }
  return signals;
}

}  // namespace palpate::tactile
