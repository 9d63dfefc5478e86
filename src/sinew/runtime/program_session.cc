#include "sinew/runtime/program_session.h"

#include <algorithm>

#include "sinew/runtime/session_pace.h"

namespace sinew::runtime {
namespace {

Duration slice(const program::Run& run, const ControlLoop& loop, const io::Clock& clock) {
  const Instant now = clock.now();
  const bool moves = control::may_move(loop.controller().state());
  Instant due = now + (moves ? kFeedInterval : kSliceMax);
  if (const auto deadline = run.next_deadline()) due = std::min(due, *deadline);
  return std::min(kSliceMax, clock.until(due));
}

/// Nothing moves but what goes on by itself, and nothing waits to be recorded.
bool settled(const ControlLoop& loop, Instant now) {
  const Driver& driver = loop.controller().driver();
  const bool busy =
      driver.state() == DriverState::kMoving || driver.state() == DriverState::kStopping;
  if (busy) return false;
  const auto until = driver.goes_on_until();
  return (until && *until > now) ||
         (!control::may_move(loop.controller().state()) && loop.recorded());
}

}  // namespace

control::ControllerSettings session_settings(const io::Clock& clock, Duration opening) {
  const double scale = std::max(1.0, clock.scale());
  const auto stretched = [&](Duration real) { return from_seconds(to_seconds(real) * scale); };
  using std::chrono::milliseconds;
  const control::ControllerSettings usual;
  return {.cycle = stretched(3 * kSliceMax),
          .gap = stretched(milliseconds(1000)),
          .lease_life = stretched(control::Lease::kLife),
          .opening_limit = stretched(opening),
          .stop_limit = stretched(usual.stop_limit),
          .start_limit = stretched(usual.start_limit),
          .journal = std::nullopt};
}

ProgramEnd run_program(program::Run& run, ControlLoop& loop, DriverLine& line,
                       const io::Clock& clock, const ProgramHooks& hooks) {
  ProgramEnd end;
  std::optional<Instant> finished_at;
  run.start(clock.now());
  while (true) {
    const Instant now = clock.now();
    loop.set_wall(io::wall_time_ns());
    loop.step(now, [&] { run.poll(now); });
    // Nobody else is there to say that a motion may go on that was held for want of time.
    if (run.paused()) run.resume();
    if (hooks.progress) hooks.progress(run, now);
    const int interrupts = hooks.interrupts ? hooks.interrupts() : 0;
    end.left_at_once = interrupts > 1;
    if (end.left_at_once) break;
    if (interrupts == 1) run.stop(now);
    if (run.finished()) {
      loop.begin_closing();
      if (!finished_at) finished_at = now;
      const bool patience = now - *finished_at < kSettleMax;
      if (settled(loop, now) || !patience) break;
    }
    if (const auto turned = line.turn(slice(run, loop, clock)); !turned) {
      end.wire_failure = turned.error();
      loop.set_port_open(false);
      loop.step(clock.now(), [&] { run.poll(clock.now()); });
      break;
    }
  }
  end.bytes = line.count();
  return end;
}

}  // namespace sinew::runtime
