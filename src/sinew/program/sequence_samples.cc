#include "sinew/program/sequence_samples.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::sequence {
namespace {

Sample moving(const MoveOrder& move, double since_start, double t) {
  Sample sample{.t = t, .q = move.q_start, .qd = {}, .predicted = true};
  for (std::size_t i = 0; i < sample.q.size(); ++i) {
    const auto point = move.profiles[i].at(since_start);
    sample.q[i] += point.position;
    sample.qd[i] = point.velocity;
  }
  return sample;
}

}  // namespace

std::vector<Sample> sample(std::span<const Record> records, double period) {
  SINEW_ASSERT(period > 0);
  std::vector<Sample> samples;
  if (records.empty()) return samples;
  const Instant zero = records.front().asked;
  for (const Record& record : records) {
    const double end = to_seconds(record.done - zero);
    if (const auto* move = std::get_if<MoveOrder>(&record.order->what)) {
      const double start = to_seconds(record.started - zero);
      // A host hears of a start late and of an end in time: its count may be the shorter one.
      const double length = std::min(move->duration, end - start);
      const auto count = static_cast<std::size_t>(std::ceil(length / period));
      for (std::size_t i = 0; i < count; ++i) {
        const double t = static_cast<double>(i) * period;
        samples.push_back(moving(*move, t, start + t));
      }
    }
    samples.push_back({.t = end, .q = record.q_reported, .qd = {}, .predicted = false});
  }
  return samples;
}

}  // namespace sinew::sequence
