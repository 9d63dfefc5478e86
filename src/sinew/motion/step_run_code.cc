#include "sinew/motion/step_run_code.h"

#include <bit>

namespace sinew::motion {
namespace {

constexpr int kGroupBits = 7;

/// Rounded to `bits` behind the binary point from `from` bits.
std::int64_t rescaled(std::int64_t value, int from, int bits) {
  if (bits >= from) return value << (bits - from);
  const int cut = from - bits;
  return (value >> cut) + ((value >> (cut - 1)) & 1);
}

std::uint64_t zigzag(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
}

std::int64_t unzigzag(std::uint64_t value) {
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

void put(std::uint64_t value, std::span<std::uint8_t> out, std::size_t& size) {
  while (value >> kGroupBits != 0) {
    out[size++] = static_cast<std::uint8_t>(value | 0x80);
    value >>= kGroupBits;
  }
  out[size++] = static_cast<std::uint8_t>(value);
}

bool get(std::span<const std::uint8_t> in, std::size_t& at, std::uint64_t& value) {
  value = 0;
  for (int shift = 0; shift < 64 && at < in.size(); shift += kGroupBits) {
    const std::uint8_t byte = in[at++];
    value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
    if ((byte & 0x80) == 0) return true;
  }
  return false;
}

}  // namespace

StepRunPrecision::StepRunPrecision(std::uint32_t count) {
  const auto bits = static_cast<int>(std::bit_width(count));
  // What is rounded off the interval grows with the count, off its growth with the square, and so
  // on: each is half a tick at the end at most.
  interval = bits;
  add = count > 1 ? 2 * bits - 1 : 0;
  add2 = count > 2 ? 3 * bits - 2 : 0;
}

void StepRunCode::follow(const StepRun& run) {
  // Unsigned: a damaged message may say anything, and an overflow must stay a wrong number.
  const std::uint64_t n = run.count;
  const auto add = static_cast<std::uint64_t>(run.add);
  const auto add2 = static_cast<std::uint64_t>(run.add2);
  interval_ = static_cast<std::int64_t>(static_cast<std::uint64_t>(run.interval) + n * add +
                                        n * (n - 1) / 2 * add2);
  add_ = static_cast<std::int64_t>(add + n * add2);
  shift_ = run.shift;
  direction_ = run.direction;
}

std::size_t StepRunCode::encode(const StepRun& run, std::span<std::uint8_t> out) {
  const StepRunPrecision precision(run.count);
  if (run.direction != direction_) interval_ = add_ = 0;
  // 0: evenly spaced, 1: growing evenly, 2: all three.
  const int order = run.add2 != 0 ? 2 : (run.add != 0 ? 1 : 0);
  std::size_t size = 0;
  put((static_cast<std::uint64_t>(run.count) << 3) | static_cast<std::uint64_t>(order << 1) |
          (run.direction > 0 ? 1U : 0U),
      out, size);
  const auto put_difference = [&](std::int64_t value, std::int64_t expected, int bits) {
    const std::int64_t said = rescaled(value, run.shift, bits);
    put(zigzag(said - rescaled(expected, shift_, bits)), out, size);
  };
  put_difference(run.interval, interval_, precision.interval);
  if (order > 0) put_difference(run.add, add_, precision.add);
  if (order > 1) put_difference(run.add2, 0, precision.add2);
  follow(run);
  return size;
}

std::size_t StepRunCode::decode(std::span<const std::uint8_t> in, StepRun& run) {
  std::size_t at = 0;
  std::uint64_t head = 0;
  if (!get(in, at, head) || head >> 3 == 0 || head >> 3 > 0xFFFF || (head >> 1 & 3) == 3) return 0;
  const auto order = static_cast<int>(head >> 1 & 3);
  run = {};
  run.count = static_cast<std::uint32_t>(head >> 3);
  run.direction = (head & 1) != 0 ? 1 : -1;
  if (run.direction != direction_) interval_ = add_ = 0;
  const StepRunPrecision precision(run.count);
  const int shift = order == 2 ? precision.add2 : (order == 1 ? precision.add : precision.interval);
  run.shift = static_cast<std::int8_t>(shift > precision.interval ? shift : precision.interval);
  const auto get_difference = [&](std::int64_t expected, int bits, std::int64_t& value) {
    std::uint64_t said = 0;
    if (!get(in, at, said)) return false;
    const auto from = static_cast<std::uint64_t>(rescaled(expected, shift_, bits));
    const auto sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(unzigzag(said)) + from);
    value = rescaled(sum, bits, run.shift);
    return true;
  };
  if (!get_difference(interval_, precision.interval, run.interval)) return 0;
  if (order > 0 && !get_difference(add_, precision.add, run.add)) return 0;
  if (order > 1 && !get_difference(0, precision.add2, run.add2)) return 0;
  follow(run);
  return at;
}

}  // namespace sinew::motion
