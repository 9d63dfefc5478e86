// error: conversion from 'double' to non-scalar type|no viable conversion from 'double'
#include "sinew/core/instant.h"

using namespace sinew;

int main() {
#ifdef MUST_NOT_COMPILE
  const Duration timeout = 0.1;
#else
  const Duration timeout = from_seconds(0.1);
#endif
  return timeout > Duration{} ? 0 : 1;
}
