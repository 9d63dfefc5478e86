#include "sinew/runtime/sequence_session.h"

#include "sinew/runtime/byte_line.h"
#include "sinew/runtime/session_pace.h"

namespace sinew::runtime {
SessionEnd run_sequence(sequence::Run& run, BigRobotArmDriver& driver, io::Port& port,
                        const io::Clock& clock, ByteLog& log, const SessionHooks& hooks) {
  SessionEnd end;
  ByteLine line(driver, port, clock, log);
  ByteCount before;  // the order under way
  bool opening = true;
  const auto fail = [&](const io::IoError& error) {
    driver.close();
    run.poll(clock.now());
    end.port_failure = error;
  };

  run.start(clock.now());
  while (true) {
    const std::size_t done_before = run.records().size();
    run.poll(clock.now());
    const ByteCount& count = line.count();
    if (run.records().size() > done_before) {
      end.bytes.push_back({count.to_device - before.to_device, count.to_host - before.to_host});
    }
    // What it took to find the device belongs to the total, not to the first order.
    if (opening || run.records().size() > done_before) before = count;
    opening = run.phase() == sequence::Run::Phase::kOpening;
    const auto sent = line.send();
    end.total = count;
    if (!sent) fail(sent.error());
    if (hooks.progress) hooks.progress({run, clock.now()});
    if (run.finished()) return end;
    const int interrupts = hooks.interrupts ? hooks.interrupts() : 0;
    end.left_at_once = interrupts > 1;
    if (end.left_at_once) return end;
    if (interrupts == 1) run.stop();
    const auto received = line.receive(kSliceMax);
    end.total = count;
    if (!received) fail(received.error());
  }
}

}  // namespace sinew::runtime
