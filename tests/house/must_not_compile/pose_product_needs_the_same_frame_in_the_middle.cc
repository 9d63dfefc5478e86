// error: no match for 'operator\*'|invalid operands to binary expression
#include "sinew/core/pose.h"

using namespace sinew;

int main() {
  const Pose<frame::Base, frame::Flange> X_BF{};
#ifdef MUST_NOT_COMPILE
  const Pose<frame::Base, frame::Tool> X_FT{};
#else
  const Pose<frame::Flange, frame::Tool> X_FT{};
#endif
  const Pose<frame::Base, frame::Tool> X_BT = X_BF * X_FT;
  return X_BT.p.x > 0 ? 1 : 0;
}
