#pragma once

#include <cstdint>

namespace sinew::test {

/// Counts the heap allocations of this thread since it was made; real-time code must show none.
class AllocationCounter {
 public:
  AllocationCounter();
  std::uint64_t count() const;

 private:
  std::uint64_t start_;
};

}  // namespace sinew::test
