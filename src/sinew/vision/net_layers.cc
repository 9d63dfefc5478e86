#include "sinew/vision/net_layers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "sinew/core/assert.h"
#include "sinew/core/dispatch.h"

namespace sinew::vision {
namespace {

/// Columns that are summed together: two of a processor's wide registers.
constexpr std::ptrdiff_t kColumns = 16;
/// Results that are.
constexpr std::size_t kResults = 6;
/// Columns whose numbers stay in the nearest cache while all results are made of them.
constexpr std::ptrdiff_t kNear = 64;

using Eight [[gnu::vector_size(32)]] = float;

float from_half(std::uint16_t half) {
  const std::uint32_t sign = (half & 0x8000U) << 16U;
  const std::uint32_t exponent = half >> 10U & 0x1FU;
  const std::uint32_t fraction = half & 0x3FFU;
  if (exponent == 0) {
    const float tiny = static_cast<float>(fraction) * 0x1p-24F;
    return sign != 0 ? -tiny : tiny;
  }
  return std::bit_cast<float>(sign | (exponent + 112) << 23U | fraction << 13U);
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

/// A few results of 16 columns. Reads a whole number of columns, writes `count` of them.
[[gnu::always_inline]] inline void sum_block(const Filters& filters, const float* const* inputs,
                                             std::ptrdiff_t column, std::ptrdiff_t count,
                                             std::size_t result, Clip clip, float* const* out) {
  Eight sums[kResults][2];
  const std::size_t results = std::min(kResults, filters.results - result);
  std::array<const float*, kResults> weights;
  for (std::size_t m = 0; m < kResults; ++m) {
    const std::size_t row = result + std::min(m, results - 1);
    weights[m] = filters.weights.data() + row * filters.inputs;
    sums[m][0] = sums[m][1] = Eight{} + filters.offsets[row];
  }
  for (std::size_t k = 0; k < filters.inputs; ++k) {
    const float* in = inputs[k] + column;
    Eight low;
    Eight high;
    std::memcpy(&low, in, sizeof low);
    std::memcpy(&high, in + 8, sizeof high);
    for (std::size_t m = 0; m < kResults; ++m) {
      sums[m][0] += weights[m][k] * low;
      sums[m][1] += weights[m][k] * high;
    }
  }
  for (std::size_t m = 0; m < results; ++m) {
    std::array<float, kColumns> values;
    std::memcpy(values.data(), sums[m], sizeof values);
    if (clip == Clip::kZero) {
      for (float& value : values) value = std::max(value, 0.0F);
    }
    std::copy_n(values.data(), count, out[result + m] + column);
  }
}

/// out[m] = offset[m] + sum over k of weight[m][k] * inputs[k], column by column.
void sum(const Filters& filters, const std::vector<const float*>& inputs, std::ptrdiff_t columns,
         Clip clip, const std::vector<float*>& out) {
  dispatched([&] {
    for (std::ptrdiff_t near = 0; near < columns; near += kNear) {
      for (std::size_t m = 0; m < filters.results; m += kResults) {
        const std::ptrdiff_t end = std::min(columns, near + kNear);
        for (std::ptrdiff_t n = near; n < end; n += kColumns) {
          sum_block(filters, inputs.data(), n, std::min(kColumns, end - n), m, clip, out.data());
        }
      }
    }
  });
}

}  // namespace

Maps::Maps(int channels_count, int rows, int columns)
    : channels(channels_count),
      height(rows),
      width(columns),
      values(static_cast<std::size_t>(channels * plane() + kColumns)) {}

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
  const Filters filters(static_cast<std::size_t>(channels),
                        9 * static_cast<std::size_t>(in.channels), weights);
  Maps out(channels, in.height / 2, in.width / 2);
  // Of each row the even columns, and the odd ones behind a zero.
  const auto stride = static_cast<std::size_t>(out.width + 1 + kColumns);
  std::vector<float> parts(static_cast<std::size_t>(in.channels) * 3 * 2 * stride);
  std::vector<const float*> inputs;
  for (std::size_t row = 0; row < static_cast<std::size_t>(in.channels) * 3; ++row) {
    const float* even = parts.data() + 2 * row * stride;
    const float* odd = even + stride;
    inputs.insert(inputs.end(), {odd, even, odd + 1});
  }
  std::vector<float*> results(static_cast<std::size_t>(channels));
  for (int y = 0; y < out.height; ++y) {
    float* part = parts.data();
    for (int channel = 0; channel < in.channels; ++channel) {
      for (int k = 0; k < 3; ++k, part += 2 * stride) {
        const int from = 2 * y + k - 1;
        if (from < 0 || from >= in.height) {
          std::fill_n(part, 2 * stride, 0.0F);
          continue;
        }
        const float* row = in.row(channel, from);
        for (int x = 0; x < out.width; ++x) {
          part[x] = row[2 * x];
          part[static_cast<std::ptrdiff_t>(stride) + 1 + x] = row[2 * x + 1];
        }
      }
    }
    for (int m = 0; m < channels; ++m) results[static_cast<std::size_t>(m)] = out.row(m, y);
    sum(filters, inputs, out.width, Clip::kZero, results);
  }
  return out;
}

Maps filtered(const Maps& in, Weights& weights) {
  const Filters filters(static_cast<std::size_t>(in.channels), 9, weights);
  Maps out(in.channels, in.height, in.width);
  const auto stride = static_cast<std::size_t>(in.width + 2);
  std::vector<float> rows(3 * stride);
  dispatched([&] {
    for (int channel = 0; channel < in.channels; ++channel) {
      const float* w = filters.weights.data() + 9 * channel;
      const float offset = filters.offsets[static_cast<std::size_t>(channel)];
      for (int y = 0; y < in.height; ++y) {
        for (int k = 0; k < 3; ++k) {
          const int from = y + k - 1;
          float* row = rows.data() + static_cast<std::size_t>(k) * stride + 1;
          if (from < 0 || from >= in.height) {
            std::fill_n(row, in.width, 0.0F);
          } else {
            std::copy_n(in.row(channel, from), in.width, row);
          }
        }
        const float* above = rows.data();
        const float* here = above + stride;
        const float* below = here + stride;
        float* to = out.row(channel, y);
        for (int x = 0; x < in.width; ++x) {
          const float sum = offset + w[0] * above[x] + w[1] * above[x + 1] + w[2] * above[x + 2] +
                            w[3] * here[x] + w[4] * here[x + 1] + w[5] * here[x + 2] +
                            w[6] * below[x] + w[7] * below[x + 1] + w[8] * below[x + 2];
          to[x] = std::max(sum, 0.0F);
        }
      }
    }
  });
  return out;
}

Maps mixed(const Maps& in, int channels, Clip clip, Weights& weights) {
  const Filters filters(static_cast<std::size_t>(channels), static_cast<std::size_t>(in.channels),
                        weights);
  Maps out(channels, in.height, in.width);
  std::vector<const float*> inputs;
  for (int k = 0; k < in.channels; ++k) inputs.push_back(in.row(k, 0));
  std::vector<float*> results;
  for (int m = 0; m < channels; ++m) results.push_back(out.row(m, 0));
  sum(filters, inputs, in.plane(), clip, results);
  return out;
}

void add_doubled(const Maps& in, Maps& to) {
  for (int channel = 0; channel < to.channels; ++channel) {
    for (int y = 0; y < to.height; ++y) {
      const float* from = in.row(channel, y / 2);
      float* row = to.row(channel, y);
      for (int x = 0; x < to.width; ++x) row[x] += from[x / 2];
    }
  }
}

void add_clipped(const Maps& in, Maps& to) {
  const auto count = static_cast<std::size_t>(to.channels * to.plane());
  for (std::size_t i = 0; i < count; ++i) {
    to.values[i] = std::max(to.values[i] + in.values[i], 0.0F);
  }
}

}  // namespace sinew::vision
