#include <cstddef>

#include "firmware/stm32/registers.h"
#include "sinew/core/assert.h"

// What the language asks for and a board has not. Nothing here is ever deleted, and a program that
// is broken begins anew.

namespace {

[[noreturn]] void broken() {
  sinew::stm32::restart();
}

}  // namespace

void operator delete(void* /*object*/) noexcept {
  broken();
}
void operator delete(void* /*object*/, std::size_t /*size*/) noexcept {
  broken();
}

extern "C" {

// NOLINTBEGIN(bugprone-reserved-identifier): names of the C++ ABI for ARM
void* __dso_handle = nullptr;
void __cxa_pure_virtual() {
  broken();
}
/// Objects that live as long as the board does are never destroyed.
int __aeabi_atexit(void* /*object*/, void (* /*destroy*/)(void*), void* /*module*/) {
  return 0;
}
// NOLINTEND(bugprone-reserved-identifier)

}  // extern "C"

namespace sinew {

void assertion_failed(const char* /*condition*/, const char* /*file*/, int /*line*/) noexcept {
  broken();
}

}  // namespace sinew
