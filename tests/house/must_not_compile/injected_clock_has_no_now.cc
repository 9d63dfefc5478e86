// error: 'now' is not a member of|no member named 'now'
#include "sinew/core/instant.h"

using namespace sinew;

int main() {
#ifdef MUST_NOT_COMPILE
  const Instant now = InjectedClock::now();
#else
  const Instant now = Instant{} + from_seconds(0.5);
#endif
  return now == Instant{} ? 1 : 0;
}
