#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>

#include "sinew/core/assert.h"

namespace sinew {

/// A vector that holds at most `Capacity` elements inside itself. Going past the capacity is a bug
/// and asserts; callers that take sizes from outside check `full()` first. @rt
template <class T, std::size_t Capacity>
class FixedVector {
 public:
  using value_type = T;

  constexpr FixedVector() = default;
  constexpr FixedVector(std::initializer_list<T> items) {
    for (const T& item : items) push_back(item);
  }
  constexpr explicit FixedVector(std::span<const T> items) {
    for (const T& item : items) push_back(item);
  }

  constexpr std::size_t capacity() const { return Capacity; }
  constexpr std::size_t size() const { return size_; }
  constexpr bool empty() const { return size_ == 0; }
  constexpr bool full() const { return size_ == Capacity; }

  constexpr void push_back(const T& item) {
    SINEW_ASSERT(size_ < Capacity);
    items_[size_++] = item;
  }
  constexpr void pop_back() {
    SINEW_ASSERT(size_ > 0);
    --size_;
  }
  constexpr void clear() { size_ = 0; }

  /// Takes the first `count` out; the others move up.
  constexpr void drop_front(std::size_t count) {
    SINEW_ASSERT(count <= size_);
    std::copy(begin() + count, end(), begin());
    resize(size_ - count);
  }
  /// Moves as many of the first ones out as `out` has room for; how many.
  constexpr std::size_t take_front(std::span<T> out) {
    const std::size_t count = std::min(out.size(), size_);
    std::copy_n(begin(), count, out.begin());
    drop_front(count);
    return count;
  }
  /// The first one, taken out; nothing where there is none.
  constexpr std::optional<T> take_front() {
    if (empty()) return std::nullopt;
    const T first = items_[0];
    drop_front(1);
    return first;
  }
  /// New elements are value-initialised.
  constexpr void resize(std::size_t size) {
    SINEW_ASSERT(size <= Capacity);
    for (std::size_t i = size_; i < size; ++i) items_[i] = T{};
    size_ = size;
  }

  constexpr T& operator[](std::size_t i) {
    SINEW_ASSERT(i < size_);
    return items_[i];
  }
  constexpr const T& operator[](std::size_t i) const {
    SINEW_ASSERT(i < size_);
    return items_[i];
  }
  constexpr T& back() { return (*this)[size_ - 1]; }
  constexpr const T& back() const { return (*this)[size_ - 1]; }

  constexpr T* data() { return items_.data(); }
  constexpr const T* data() const { return items_.data(); }
  constexpr T* begin() { return items_.data(); }
  constexpr T* end() { return items_.data() + size_; }
  constexpr const T* begin() const { return items_.data(); }
  constexpr const T* end() const { return items_.data() + size_; }

  friend constexpr bool operator==(const FixedVector& a, const FixedVector& b) {
    if (a.size_ != b.size_) return false;
    for (std::size_t i = 0; i < a.size_; ++i) {
      if (!(a.items_[i] == b.items_[i])) return false;
    }
    return true;
  }

 private:
  std::array<T, Capacity> items_{};
  std::size_t size_ = 0;
};

}  // namespace sinew
