// error: cannot convert .* to '(const )?double'|no viable conversion
#include "sinew/core/error.h"

using namespace sinew;

int main() {
  const Expected<double> reach = 0.5;
#ifdef MUST_NOT_COMPILE
  const double reach_m = reach;
#else
  const double reach_m = reach.value_or(0);
#endif
  return reach_m > 0 ? 0 : 1;
}
