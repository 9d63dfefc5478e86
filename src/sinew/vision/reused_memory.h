#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace sinew::vision {

/// Uninitialised memory: a block of exactly this size that this thread returned before, else a new
/// one.
void* reused_block(std::size_t bytes);
/// Returns a block. Each thread keeps up to 48 MB until it ends.
void give_back_block(void* block, std::size_t bytes) noexcept;
/// Of this thread.
std::size_t bytes_kept();

/// Allocator for large arrays that each picture needs again. Avoids page faults, and does not
/// initialise: write every value before it is read.
template <class T>
struct ReusedMemory : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = ReusedMemory<U>;
  };
  T* allocate(std::size_t count) { return static_cast<T*>(reused_block(count * sizeof(T))); }
  void deallocate(T* place, std::size_t count) noexcept {
    give_back_block(place, count * sizeof(T));
  }
  template <class U>
  void construct(U* place) noexcept {
    ::new (static_cast<void*>(place)) U;
  }
};

}  // namespace sinew::vision
