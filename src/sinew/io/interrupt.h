#pragma once

namespace sinew::io {

/// Catches Ctrl-C (SIGINT), SIGTERM and SIGHUP for the life of the process, so that a run can end
/// in order. Loops look at `interrupts()` at least every 50 ms.
void catch_interrupts();

/// How often somebody wished for an end. The same signal again, other than Ctrl-C, counts once.
int interrupts();

/// How often SIGUSR1 came, by which somebody asks how it goes.
int status_requests();

}  // namespace sinew::io
