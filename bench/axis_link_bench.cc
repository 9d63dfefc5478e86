#include <benchmark/benchmark.h>

#include <array>
#include <cstdlib>
#include <vector>

#include "bench/ideal_axis.h"
#include "sinew/core/split_mix.h"
#include "sinew/devices/axis_link/axis_link_driver.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_link/axis_link_wire.h"

namespace sinew::bench {
namespace {

using namespace axis_link;

constexpr std::size_t kMessages = 1024;

std::vector<Request> requests() {
  SplitMix64 numbers(42);
  std::vector<Request> all;
  for (std::size_t i = 0; i < kMessages; ++i) {
    const std::uint64_t bits = numbers.bits();
    all.push_back({.axis = static_cast<std::uint8_t>(bits & 7),
                   .mode = Mode::kTrack,
                   .sequence = static_cast<std::uint16_t>(bits >> 8),
                   .target = static_cast<std::int32_t>(bits >> 32),
                   .velocity = static_cast<std::int32_t>(bits >> 40 & 0x3F'FFFF),
                   .session = 1});
  }
  return all;
}

void axis_link_encode(benchmark::State& state) {
  const auto all = requests();
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(encode(all[i++ % kMessages]));
}
BENCHMARK(axis_link_encode);

void axis_link_decode(benchmark::State& state) {
  std::vector<Frame> frames;
  for (const Request& request : requests()) {
    State body{.position = request.target, .velocity = 5, .position_ok = true, .homed = true};
    frames.push_back(encode(
        Reply{.axis = request.axis, .session = 1, .sequence = request.sequence, .body = body}));
  }
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(decode_reply(frames[i++ % kMessages]));
}
BENCHMARK(axis_link_decode);

/// What the host's processor does for one cycle of six axes in motion; the axes' answers are made
/// here as well, one encode() each.
void axis_link_cycle_6_axes(benchmark::State& state) {
  AxisLinkDevice device;
  const std::vector<Joint> joints(6, free_joint());
  for (int i = 0; i < 6; ++i) device.boards.push_back({});
  AxisLinkTiming timing;
  timing.cycle = Duration::zero();
  AxisLinkDriver driver(device, joints, timing);
  Instant now{};
  std::array<std::uint16_t, 6> executed{};
  std::array<std::int32_t, 6> target{};
  std::array<bool, 6> greeted{};
  const auto frame = [&] {
    const auto transfer = driver.take_transfer(now);
    const auto request = decode_request(std::span(transfer->mosi.data(), kFrameSize).first<16>());
    const std::size_t axis = request->axis;
    Reply reply{.axis = request->axis, .session = 1, .sequence = executed[axis], .body = {}};
    if (greeted[axis]) {
      const AxisModel model{request->axis, -6, 6, 10, 100, 1000};
      reply.body = Identity{model_hash(model), 1, 1608};
    } else {
      reply.body = State{.position = target[axis], .position_ok = true, .homed = true};
    }
    greeted[axis] = request->mode == Mode::kHello;
    executed[axis] = request->sequence;
    if (request->mode == Mode::kTrack) target[axis] = request->target;
    now += std::chrono::microseconds(82);
    driver.exchanged(encode(reply), now);
  };
  const auto go = [&] {
    JointMove move{.q = {}, .qd = {}, .duration = std::chrono::hours(1)};
    for (int i = 0; i < 6; ++i) {
      move.q.push_back(driver.positions()[0].q < 0 ? 5 : -5);
      move.qd.push_back(0);
    }
    if (!driver.move(move, now)) std::abort();
  };
  driver.open(now);
  while (driver.state() != DriverState::kReady) frame();
  for (auto _ : state) {
    if (driver.state() != DriverState::kMoving) {
      while (driver.take_event()) continue;
      go();
    }
    for (int i = 0; i < 6; ++i) frame();
  }
  if (driver.health().unexpected != 0) state.SkipWithError("frames were lost");
}
BENCHMARK(axis_link_cycle_6_axes);

}  // namespace
}  // namespace sinew::bench
