#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace sinew::vision {

/// Memory of so many bytes, of any values: what this thread gave back before, where it fits
/// exactly.
void* reused_block(std::size_t bytes);
/// Keeps it for the next one of the same size; up to 48 MB in a thread, until the thread ends.
void give_back_block(void* block, std::size_t bytes) noexcept;

/// For large arrays of numbers that are made anew for each picture, all of whose values are written
/// before they are read: they are left as they are, and the kernel clears no pages for them.
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
