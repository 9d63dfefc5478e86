// error: conversion from .* to non-scalar type|no viable conversion
#include "sinew/core/instant.h"

using namespace sinew;

int main() {
#ifdef MUST_NOT_COMPILE
  const Instant start = std::chrono::steady_clock::time_point{};
#else
  const Instant start = InjectedClock::time_point{};
#endif
  return start == Instant{} ? 0 : 1;
}
