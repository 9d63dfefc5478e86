#include "sinew/vision/view_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "sinew/core/assert.h"

namespace sinew::vision {
namespace {

constexpr float kShadow = 0.5F;  ///< of a cell's sRGB value: darker is no shadow
constexpr float kGlare = 1.12F;
constexpr float kOther = 22;  ///< of 255 in each color: noise and compression stay below
/// Brighter than in glare, as where a shadow has gone: what is alike then has so nearly the same
/// hue. Skin on wood has not.
constexpr float kAlike = 14;
constexpr float kFollow = 0.1F;
constexpr float kFull = 240;   ///< of 255: a channel that may be cut off
constexpr float kLift = 1.5F;  ///< where a shadow has gone and channels are full

float sum(const std::array<float, 3>& color) {
  return color[0] + color[1] + color[2];
}

std::array<float, 3> color_at(const Picture& cells, std::size_t i) {
  const std::uint8_t* p = cells.rgb.data() + 3 * i;
  return {1.0F * p[0], 1.0F * p[1], 1.0F * p[2]};
}

/// Whether a color is another one, and not the same where a shadow has come or gone. A full channel
/// may be brighter than it says, and where it was full it says nothing. One that is full no more is
/// taken as it was: else skin on a bright table would pass for a shadow.
/// @param full  of `now`, a channel from there on
bool is_other(const std::array<float, 3>& now, const std::array<float, 3>& was,
              const std::array<float, 3>& full) {
  float across = 0;
  float along = 0;
  float least = 0;  // by full channels
  bool is_full = false;
  for (std::size_t c = 0; c < 3; ++c) {
    least = std::max(least, now[c] / std::max(1.0F, was[c]));
    is_full = is_full || now[c] >= full[c];
    if (now[c] >= full[c]) continue;
    across += now[c] * was[c];
    along += was[c] * was[c];
  }
  const float most_share = is_full ? kLift : 1 / kShadow;
  const float share = std::clamp(along > 0 ? across / along : least, kShadow, most_share);
  float off = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const float apart = now[c] - share * was[c];
    const bool is_hidden = now[c] >= full[c] && (apart < 0 || was[c] >= kFull);
    off += is_hidden ? 0 : apart * apart;
  }
  const float most = share > kGlare ? kAlike : kOther;
  return off > most * most;
}

}  // namespace

CellGrid grid_of(int width, int height) {
  const int longest = std::max(width, height);
  if (longest <= kCellsAcross) return {width, height};
  // As shrunk() has it.
  const double scale = 1.0 * kCellsAcross / longest;
  return {std::max(1, static_cast<int>(std::lround(width * scale))),
          std::max(1, static_cast<int>(std::lround(height * scale)))};
}

std::optional<std::size_t> cell_of(const CellGrid& grid, int width, int height, Pixel p) {
  if (p.x < 0 || p.y < 0) return std::nullopt;
  const int column = static_cast<int>(p.x * grid.columns / width);
  const int row = static_cast<int>(p.y * grid.rows / height);
  if (column >= grid.columns || row >= grid.rows) return std::nullopt;
  return grid.at(column, row);
}

void ViewWatch::begin_again() {
  was_.clear();
  seen_ = false;
}

std::optional<Pixel> ViewWatch::look(const Picture& picture, const std::vector<bool>& may_move) {
  const Picture cells = shrunk(picture, kCellsAcross);
  const CellGrid grid{cells.width, cells.height};
  SINEW_ASSERT(may_move.size() == grid.size());
  if (was_.size() != grid.size()) {
    was_.assign(grid.size(), {});
    known_.assign(grid.size(), false);
    seen_ = false;
  }
  const Color exposure = exposure_of(cells, may_move);
  const Color full{kFull / exposure[0], kFull / exposure[1], kFull / exposure[2]};
  std::vector<bool> changed(grid.size(), false);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (may_move[i]) {
      known_[i] = false;
      continue;
    }
    Color now = color_at(cells, i);
    for (std::size_t c = 0; c < 3; ++c) now[c] /= exposure[c];
    if (!known_[i]) {
      was_[i] = now;
      known_[i] = true;
    } else if (is_other(now, was_[i], full)) {
      changed[i] = true;
    } else if (sum(now) > kGlare * sum(was_[i])) {
      was_[i] = now;  // a shadow has gone
    } else {
      for (std::size_t c = 0; c < 3; ++c) was_[i][c] += kFollow * (now[c] - was_[i][c]);
    }
  }
  const auto there = largest(grid, std::move(changed));
  const bool before = std::exchange(seen_, there.has_value());
  if (!before || !there) return std::nullopt;
  return 1.0 * picture.width / grid.columns * *there;
}

/// Light of the picture as a whole against what it was, in each channel: the median over cells.
ViewWatch::Color ViewWatch::exposure_of(const Picture& cells,
                                        const std::vector<bool>& may_move) const {
  constexpr float kDark = 20;  // a value below says little
  // More is no exposure: the camera is covered, or the lamps went out.
  constexpr float kMost = 1.4F;
  constexpr float kUnknown = 0;
  Color exposure{};
  float known = 0, count = 0;
  std::vector<float> shares;
  for (std::size_t c = 0; c < 3; ++c) {
    shares.clear();
    for (std::size_t i = 0; i < was_.size(); ++i) {
      const float now = color_at(cells, i)[c], was = was_[i][c];
      // What is cut off says nothing.
      if (!known_[i] || may_move[i] || was < kDark || std::max(was, now) >= kFull) continue;
      shares.push_back(now / was);
    }
    exposure[c] = kUnknown;
    if (shares.size() < was_.size() / 4) continue;
    const auto middle = shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2);
    std::ranges::nth_element(shares, middle);
    exposure[c] = std::clamp(*middle, 1 / kMost, kMost);
    known += exposure[c];
    ++count;
  }
  for (float& one : exposure) {
    if (one == kUnknown) one = count > 0 ? known / count : 1;
  }
  return exposure;
}

/// Middle of the largest part that hangs together, cells, where it counts.
std::optional<Pixel> ViewWatch::largest(const CellGrid& grid, std::vector<bool> changed) const {
  std::size_t most = 0;
  Pixel middle;
  std::vector<std::pair<int, int>> open;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      std::size_t count = 0;
      Pixel total;
      open.emplace_back(column, row);
      while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        if (x < 0 || y < 0 || x >= grid.columns || y >= grid.rows || !changed[grid.at(x, y)]) {
          continue;
        }
        changed[grid.at(x, y)] = false;
        ++count;
        total = total + Pixel{x + 0.5, y + 0.5};
        for (const auto& [dx, dy] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
          open.emplace_back(x + dx, y + dy);
        }
      }
      if (count <= most) continue;
      most = count;
      middle = (1.0 / static_cast<double>(count)) * total;
    }
  }
  if (static_cast<double>(most) < least_ || most == 0) return std::nullopt;
  return middle;
}

}  // namespace sinew::vision
