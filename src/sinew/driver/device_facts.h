#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <optional>
#include <type_traits>

#include "sinew/core/assert.h"
#include "sinew/core/instant.h"

namespace sinew {

/// Something that was said, and when.
template <class What>
struct Heard {
  What what{};
  Instant at{};
};
template <class What>
using LastHeard = std::optional<Heard<What>>;

/// What a device has told of itself last: plain data of its kind, as its wire has it
/// (`KIND_driver_facts.h`). A copy allocates nothing.
class DeviceFacts {
 public:
  static constexpr std::size_t kSizeMax = 2560;  ///< bytes

  /// Of a driver that keeps none.
  DeviceFacts() = default;
  template <class Facts>
    requires std::is_trivially_copyable_v<Facts> && (!std::is_same_v<Facts, DeviceFacts>)
  explicit DeviceFacts(const Facts& facts) : kind_(&kKind<Facts>) {
    static_assert(sizeof(Facts) <= kSizeMax && alignof(Facts) <= alignof(std::max_align_t));
    std::construct_at(reinterpret_cast<Facts*>(data_.data()), facts);
  }

  bool empty() const { return kind_ == nullptr; }
  /// nullptr where they are of another kind.
  template <class Facts>
  const Facts* as() const {
    if (kind_ != &kKind<Facts>) return nullptr;
    return std::launder(reinterpret_cast<const Facts*>(data_.data()));
  }
  /// @pre they are of that kind
  template <class Facts>
  const Facts& get() const {
    SINEW_ASSERT(as<Facts>() != nullptr);
    return *as<Facts>();
  }

 private:
  template <class Facts>
  static constexpr char kKind = 0;  ///< its address is the kind's

  alignas(std::max_align_t) std::array<std::byte, kSizeMax> data_;
  const char* kind_ = nullptr;
};

}  // namespace sinew
