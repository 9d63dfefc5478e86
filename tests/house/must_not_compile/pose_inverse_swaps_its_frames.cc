// error: conversion from .* to non-scalar type|no viable conversion
#include "sinew/core/pose.h"

using namespace sinew;

int main() {
  const Pose<frame::Base, frame::Tool> X_BT{};
#ifdef MUST_NOT_COMPILE
  const Pose<frame::Base, frame::Tool> X_TB = X_BT.inverse();
#else
  const Pose<frame::Tool, frame::Base> X_TB = X_BT.inverse();
#endif
  return X_TB.p.x > 0 ? 1 : 0;
}
