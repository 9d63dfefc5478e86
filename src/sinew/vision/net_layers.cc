#include "sinew/vision/net_layers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "sinew/core/assert.h"
#include "sinew/core/dispatch.h"

namespace sinew::vision {
namespace {

/// How a sum is laid out for vectors of so many floats.
template <std::size_t floats, std::size_t results>
struct Lanes {
  using Vector [[gnu::vector_size(floats * sizeof(float))]] = float;
  /// Columns that are summed together: two of a processor's wide registers.
  static constexpr std::ptrdiff_t kColumns = 2 * floats;
  /// Results that are: with what they are made of they fill the registers.
  static constexpr std::size_t kResults = results;
};
using Wide = Lanes<8, 6>;
using Widest = Lanes<16, 8>;
/// Floats that may be read behind a row.
constexpr std::ptrdiff_t kBehind = Widest::kColumns;
/// Columns whose numbers stay in the nearest cache while all results are made of them.
constexpr std::ptrdiff_t kNear = 64;

std::size_t results_at_once() {
  return vectors() == Vectors::kWidest ? Widest::kResults : Wide::kResults;
}

/// Calls work(Lanes) compiled for the processor at hand.
template <class Work>
void with_lanes(const Work& work) {
  const auto wide = [&] { work(Wide{}); };
  dispatched(wide, wide, [&] { work(Widest{}); });
}

/// Without a branch, so that many are converted at once. Neither infinite nor no number.
float from_half(std::uint16_t half) {
  const std::uint32_t sign = (half & 0x8000U) << 16U;
  const float size = std::bit_cast<float>((half & 0x7FFFU) << 13U) * 0x1p112F;
  return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(size));
}

/// A layer's filters: `results` rows of as many weights as there are inputs, and what is added.
struct Filters {
  std::size_t results = 0;
  std::size_t inputs = 0;
  std::vector<float> weights;
  std::vector<float> offsets;

  Filters(std::size_t results_count, std::size_t inputs_count, Weights& file)
      : results(results_count),
        inputs(inputs_count),
        weights(file.take(results * inputs)),
        offsets(file.take(results)) {}
};

/// Filters in the order in which sum_block() reads them: of results_at_once() results at a time,
/// one weight of each for every input.
struct Packed {
  std::size_t results = 0;
  std::size_t inputs = 0;
  std::size_t at_once = results_at_once();
  std::vector<float> weights;
  std::vector<float> offsets;

  explicit Packed(const Filters& filters) : results(filters.results), inputs(filters.inputs) {
    weights.reserve((results + at_once) * inputs);
    for (std::size_t first = 0; first < results; first += at_once) {
      for (std::size_t m = first; m < first + at_once; ++m) {
        offsets.push_back(m < results ? filters.offsets[m] : 0);
      }
      for (std::size_t k = 0; k < inputs; ++k) {
        for (std::size_t m = first; m < first + at_once; ++m) {
          weights.push_back(m < results ? filters.weights[m * inputs + k] : 0);
        }
      }
    }
  }
};

/// Whether sums begin with the offsets alone, or with what the results hold already, too.
enum class Begin : bool { kOffsets, kSums };

/// A few results of a few columns. Reads a whole number of columns, writes `count` of them.
/// @param whole  all columns and kResults results are written: what the compiler knows takes less
/// time
template <class L, Begin begin, bool whole>
[[gnu::always_inline]] inline void sum_block(const Packed& filters, const float* const* inputs,
                                             std::ptrdiff_t column, std::ptrdiff_t count,
                                             std::size_t result, Clip clip, float* const* out) {
  using Vector = typename L::Vector;
  constexpr std::size_t kResults = L::kResults;
  Vector sums[kResults][2];
  const std::size_t results = whole ? kResults : std::min(kResults, filters.results - result);
  const float* weights = filters.weights.data() + result * filters.inputs;
  for (std::size_t m = 0; m < kResults; ++m) {
    sums[m][0] = sums[m][1] = Vector{} + filters.offsets[result + m];
    if (begin == Begin::kOffsets || m >= results) continue;
    Vector before[2];
    std::memcpy(before, out[result + m] + column, sizeof before);
    sums[m][0] += before[0];
    sums[m][1] += before[1];
  }
  for (std::size_t k = 0; k < filters.inputs; ++k, weights += kResults) {
    const float* in = inputs[k] + column;
    Vector low;
    Vector high;
    std::memcpy(&low, in, sizeof low);
    std::memcpy(&high, in + L::kColumns / 2, sizeof high);
    for (std::size_t m = 0; m < kResults; ++m) {
      sums[m][0] += weights[m] * low;
      sums[m][1] += weights[m] * high;
    }
  }
  if (clip == Clip::kZero) {
    for (auto& sum : sums) {
      for (Vector& part : sum) part = part > 0.0F ? part : Vector{};
    }
  }
  for (std::size_t m = 0; m < results; ++m) {
    const std::size_t size = (whole ? L::kColumns : count) * sizeof(float);
    std::memcpy(out[result + m] + column, sums[m], size);
  }
}

/// out[m] = offset[m] + sum over k of weight[m][k] * inputs[k], column by column; or what is added
/// to out[m].
template <class L, Begin begin = Begin::kOffsets>
[[gnu::always_inline]] inline void sum(const Packed& filters, const float* const* inputs,
                                       std::ptrdiff_t columns, Clip clip, float* const* out) {
  SINEW_ASSERT(filters.at_once == L::kResults);
  for (std::ptrdiff_t near = 0; near < columns; near += kNear) {
    for (std::size_t m = 0; m < filters.results; m += L::kResults) {
      const std::ptrdiff_t end = std::min(columns, near + kNear);
      for (std::ptrdiff_t n = near; n < end; n += L::kColumns) {
        if (n + L::kColumns <= end && m + L::kResults <= filters.results) {
          sum_block<L, begin, true>(filters, inputs, n, L::kColumns, m, clip, out);
        } else {
          sum_block<L, begin, false>(filters, inputs, n, std::min(L::kColumns, end - n), m, clip,
                                     out);
        }
      }
    }
  }
}

/// A 3 x 3 filter along three rows; nothing of what is negative. `above` and `below` may be zeros.
[[gnu::always_inline]] inline void filter_row(const float* w, float offset, const float* above,
                                              const float* here, const float* below, int width,
                                              float* to) {
  const auto at = [&](int x) {
    return offset + w[0] * above[x - 1] + w[1] * above[x] + w[2] * above[x + 1] +
           w[3] * here[x - 1] + w[4] * here[x] + w[5] * here[x + 1] + w[6] * below[x - 1] +
           w[7] * below[x] + w[8] * below[x + 1];
  };
  for (int x = 1; x < width - 1; ++x) {
    const float sum = at(x);
    to[x] = sum > 0 ? sum : 0;
  }
  for (const int x : {0, width - 1}) {  // beyond which there are zeros
    float sum = offset;
    for (int k = 0; k < 3; ++k) {
      const int u = x + k - 1;
      if (u < 0 || u >= width) continue;
      sum += w[k] * above[u] + w[3 + k] * here[u] + w[6 + k] * below[u];
    }
    to[x] = std::max(sum, 0.0F);
  }
}

}  // namespace

Maps::Maps(int channels_count, int rows, int columns)
    : channels(channels_count),
      height(rows),
      width(columns),
      values(static_cast<std::size_t>(channels * plane() + kBehind)) {}

std::vector<float> Weights::take(std::size_t count) {
  SINEW_ASSERT(left_.size() >= 2 * count);
  std::vector<float> taken(count);
  for (std::size_t i = 0; i < count; ++i) {
    taken[i] = from_half(static_cast<std::uint16_t>(left_[2 * i] | left_[2 * i + 1] << 8U));
  }
  left_ = left_.subspan(2 * count);
  return taken;
}

Maps halved(const Maps& in, int channels, Weights& weights) {
  const Packed filters(Filters(static_cast<std::size_t>(channels),
                               9 * static_cast<std::size_t>(in.channels), weights));
  Maps out(channels, in.height / 2, in.width / 2);
  // Of each row the even columns, and the odd ones behind a zero. A row below the middle is the one
  // above the next: of the three places of a channel the first and the last change roles.
  const std::ptrdiff_t stride = out.width + 1 + kBehind;
  std::vector<float> parts(static_cast<std::size_t>(in.channels * 3 * 2 * stride));
  const auto place = [&](int channel, int row) {
    const int slot = row % 2 == 0 ? 1 : (row + 1) % 4 == 0 ? 0 : 2;
    return parts.data() + (channel * 3 + slot) * 2 * stride;
  };
  std::array<std::vector<const float*>, 2> inputs;
  for (int y = 0; y < 2; ++y) {
    for (int channel = 0; channel < in.channels; ++channel) {
      for (int k = 0; k < 3; ++k) {
        const float* even = place(channel, 2 * y + k + 3);
        const float* odd = even + stride;
        inputs[static_cast<std::size_t>(y)].insert(inputs[static_cast<std::size_t>(y)].end(),
                                                   {odd, even, odd + 1});
      }
    }
  }
  std::vector<float*> results(static_cast<std::size_t>(channels));
  with_lanes([&]<class L>(L) {
    for (int y = 0; y < out.height; ++y) {
      for (int channel = 0; channel < in.channels; ++channel) {
        for (const int from : {2 * y, 2 * y + 1}) {
          const float* row = in.row(channel, from);
          float* even = place(channel, from);
          float* odd = even + stride + 1;
          for (int x = 0; x < out.width; ++x) {
            even[x] = row[2 * x];
            odd[x] = row[2 * x + 1];
          }
        }
      }
      for (int m = 0; m < channels; ++m) results[static_cast<std::size_t>(m)] = out.row(m, y);
      sum<L>(filters, inputs[static_cast<std::size_t>(y % 2)].data(), out.width, Clip::kZero,
             results.data());
    }
  });
  return out;
}

Maps filtered(const Maps& in, Weights& weights) {
  const Filters filters(static_cast<std::size_t>(in.channels), 9, weights);
  Maps out(in.channels, in.height, in.width);
  const std::vector<float> zeros(static_cast<std::size_t>(in.width));
  dispatched([&] {
    for (int channel = 0; channel < in.channels; ++channel) {
      for (int y = 0; y < in.height; ++y) {
        const float* above = y > 0 ? in.row(channel, y - 1) : zeros.data();
        const float* below = y + 1 < in.height ? in.row(channel, y + 1) : zeros.data();
        filter_row(filters.weights.data() + 9 * channel,
                   filters.offsets[static_cast<std::size_t>(channel)], above, in.row(channel, y),
                   below, in.width, out.row(channel, y));
      }
    }
  });
  return out;
}

Maps mixed(const Maps& in, int channels, Clip clip, Weights& weights) {
  const Packed filters(
      Filters(static_cast<std::size_t>(channels), static_cast<std::size_t>(in.channels), weights));
  Maps out(channels, in.height, in.width);
  std::vector<const float*> inputs;
  for (int k = 0; k < in.channels; ++k) inputs.push_back(in.row(k, 0));
  std::vector<float*> results;
  for (int m = 0; m < channels; ++m) results.push_back(out.row(m, 0));
  with_lanes([&]<class L>(L) { sum<L>(filters, inputs.data(), in.plane(), clip, results.data()); });
  return out;
}

void refine(Maps& maps, Weights& weights) {
  const Filters filters(static_cast<std::size_t>(maps.channels), 9, weights);
  const Packed mix(Filters(static_cast<std::size_t>(maps.channels),
                           static_cast<std::size_t>(maps.channels), weights));
  const std::ptrdiff_t stride = maps.width + kBehind;
  const auto size = static_cast<std::size_t>(maps.channels * stride);
  const std::vector<float> zeros(static_cast<std::size_t>(maps.width));
  std::vector<float> above(size);  // the row before, as it was
  std::vector<float> inner(size);
  std::vector<const float*> inputs;
  for (int channel = 0; channel < maps.channels; ++channel) {
    inputs.push_back(inner.data() + channel * stride);
  }
  std::vector<float*> results(static_cast<std::size_t>(maps.channels));
  with_lanes([&]<class L>(L) {
    for (int y = 0; y < maps.height; ++y) {
      for (int channel = 0; channel < maps.channels; ++channel) {
        float* here = maps.row(channel, y);
        float* before = above.data() + channel * stride;
        filter_row(filters.weights.data() + 9 * channel,
                   filters.offsets[static_cast<std::size_t>(channel)], before, here,
                   y + 1 < maps.height ? maps.row(channel, y + 1) : zeros.data(), maps.width,
                   inner.data() + channel * stride);
        std::copy_n(here, maps.width, before);
        results[static_cast<std::size_t>(channel)] = here;
      }
      sum<L, Begin::kSums>(mix, inputs.data(), maps.width, Clip::kZero, results.data());
    }
  });
}

void add_doubled(const Maps& in, Maps& to) {
  dispatched([&] {
    for (int channel = 0; channel < to.channels; ++channel) {
      for (int y = 0; y < to.height; ++y) {
        const float* from = in.row(channel, y / 2);
        float* row = to.row(channel, y);
        for (int x = 0; x < to.width / 2; ++x) {
          row[2 * x] += from[x];
          row[2 * x + 1] += from[x];
        }
      }
    }
  });
}

}  // namespace sinew::vision
