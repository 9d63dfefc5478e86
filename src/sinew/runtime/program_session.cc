#include "sinew/runtime/program_session.h"

#include <algorithm>

namespace sinew::runtime {
namespace {

constexpr Duration kSliceMax = std::chrono::milliseconds(50);
/// A stopped driver may still have to say so to its device.
constexpr Duration kSettleMax = std::chrono::seconds(5);

bool at_rest(const Driver& driver) {
  return driver.state() != DriverState::kMoving && driver.state() != DriverState::kStopping;
}

Duration slice(const program::Run& run, const io::Clock& clock) {
  const auto deadline = run.next_deadline(clock.now());
  return deadline ? std::min(kSliceMax, clock.until(*deadline)) : kSliceMax;
}

}  // namespace

ProgramEnd run_program(program::Run& run, Driver& driver, DriverLine& line, const io::Clock& clock,
                       const ProgramHooks& hooks) {
  ProgramEnd end;
  std::optional<Instant> finished_at;
  run.start(clock.now());
  while (true) {
    run.poll(clock.now());
    if (hooks.progress) hooks.progress(run, clock.now());
    const int interrupts = hooks.interrupts ? hooks.interrupts() : 0;
    end.left_at_once = interrupts > 1;
    if (end.left_at_once) break;
    if (interrupts == 1) run.stop(clock.now());
    if (run.finished()) {
      if (!finished_at) finished_at = clock.now();
      const bool patience = clock.now() - *finished_at < kSettleMax;
      if (at_rest(driver) || !patience) break;
    }
    if (const auto turned = line.turn(slice(run, clock)); !turned) {
      end.wire_failure = turned.error();
      run.poll(clock.now());
      break;
    }
  }
  end.bytes = line.count();
  return end;
}

}  // namespace sinew::runtime
