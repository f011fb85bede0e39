// SPDX-License-Identifier: Apache-2.0
#include "simulation/rendering/palette.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace palpate::simulation {
namespace {

constexpr int kBits = 6;  // of a colour's channel that tell cells apart
constexpr std::size_t kCells = std::size_t{1} << (3 * kBits);

/// Colours that agree in their first bits.
struct Cell {
  std::uint32_t index = 0;
  std::uint64_t pixels = 0;
  std::array<std::uint64_t, 3> sum{};  ///< of the pixels' channels
};

/// Cells that one colour stands for: a range of all of them.
struct Box {
  std::vector<Cell>::iterator begin, end;
  int channel = 0;            ///< in which it is widest
  std::uint64_t badness = 0;  ///< how much is gained by splitting it
};

std::uint32_t level(std::uint32_t cell, int channel) {
  return cell >> (kBits * channel) & ((1U << kBits) - 1);
}

std::uint32_t cell_of(const std::uint8_t* rgb) {
  std::uint32_t cell = 0;
  for (int c = 0; c < 3; ++c) {
    cell |= static_cast<std::uint32_t>(rgb[c] >> (8 - kBits)) << (kBits * c);
  }
  return cell;
}

std::vector<Cell> used_cells(const std::vector<Image>& images) {
  std::vector<Cell> cells(kCells);
  for (const Image& image : images) {
    for (std::size_t at = 0; at + 3 <= image.rgb.size(); at += 3) {
      Cell& cell = cells[cell_of(&image.rgb[at])];
      ++cell.pixels;
      for (std::size_t c = 0; c < 3; ++c) cell.sum[c] += image.rgb[at + c];
    }
  }
  for (std::size_t i = 0; i < kCells; ++i) cells[i].index = static_cast<std::uint32_t>(i);
  std::erase_if(cells, [](const Cell& cell) { return cell.pixels == 0; });
  return cells;
}

std::uint64_t pixels_of(const Box& box) {
  return std::accumulate(box.begin, box.end, std::uint64_t{0},
                         [](std::uint64_t sum, const Cell& cell) { return sum + cell.pixels; });
}

Box box_of(std::vector<Cell>::iterator begin, std::vector<Cell>::iterator end) {
  Box box{begin, end};
  std::uint32_t widest = 0;
  for (int c = 0; c < 3; ++c) {
    const auto [low, high] = std::minmax_element(begin, end, [c](const Cell& a, const Cell& b) {
      return level(a.index, c) < level(b.index, c);
    });
    const std::uint32_t width = level(high->index, c) - level(low->index, c);
    if (width > widest) box.channel = c;
    widest = std::max(widest, width);
  }
  box.badness = widest * widest * pixels_of(box);
  return box;
}

/// Halves a box of at least two cells at the median of its pixels. @return the other half
Box split(Box& box) {
  const int channel = box.channel;
  std::sort(box.begin, box.end, [channel](const Cell& a, const Cell& b) {
    const auto la = level(a.index, channel), lb = level(b.index, channel);
    return la != lb ? la < lb : a.index < b.index;
  });
  const std::uint64_t half = pixels_of(box) / 2;
  auto middle = box.begin;
  for (std::uint64_t before = 0; std::next(middle) != box.end; ++middle) {
    before += middle->pixels;
    if (before > half) break;
  }
  if (middle == box.begin) ++middle;
  const Box other = box_of(middle, box.end);
  box = box_of(box.begin, middle);
  return other;
}

Color mean_color(const Box& box) {
  const std::uint64_t pixels = pixels_of(box);
  Color color{};
  for (std::size_t c = 0; c < 3; ++c) {
    std::uint64_t sum = pixels / 2;  // rounds to the nearest
    for (auto cell = box.begin; cell != box.end; ++cell) sum += cell->sum[c];
    color[c] = static_cast<std::uint8_t>(sum / pixels);
  }
  return color;
}

}  // namespace

Palette::Palette(const std::vector<Image>& images, std::size_t most) : index_of_cell_(kCells) {
  auto cells = used_cells(images);
  if (cells.empty()) return;
  std::vector<Box> boxes{box_of(cells.begin(), cells.end())};
  while (boxes.size() < most) {
    auto worst = std::max_element(boxes.begin(), boxes.end(),
                                  [](const Box& a, const Box& b) { return a.badness < b.badness; });
    if (worst->badness == 0) break;  // one cell each
    boxes.push_back(split(*worst));
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    colors_.push_back(mean_color(boxes[i]));
    for (auto cell = boxes[i].begin; cell != boxes[i].end; ++cell) {
      index_of_cell_[cell->index] = static_cast<std::uint8_t>(i);
    }
  }
}

std::uint8_t Palette::index_of(const std::uint8_t* rgb) const {
  return index_of_cell_[cell_of(rgb)];
}

}  // namespace palpate::simulation
