// error: no match for 'operator=='|invalid operands to binary expression
#include "sinew/core/pose.h"

using namespace sinew;

int main() {
  const Pose<frame::Base, frame::Flange> X_BF{};
#ifdef MUST_NOT_COMPILE
  const Pose<frame::Base, frame::Tool> other{};
#else
  const Pose<frame::Base, frame::Flange> other{};
#endif
  return X_BF == other ? 0 : 1;
}
