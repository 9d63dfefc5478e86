// error: conversion from .* to non-scalar type|no viable conversion
#include "sinew/core/pose.h"

using namespace sinew;

int main() {
  const Pose<frame::Base, frame::Flange> X_BF{};
#ifdef MUST_NOT_COMPILE
  const Pose<frame::Base, frame::Tool> X_BT = X_BF;
#else
  const Pose<frame::Base, frame::Flange> X_BT = X_BF;
#endif
  return X_BT.p.x > 0 ? 1 : 0;
}
