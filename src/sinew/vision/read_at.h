#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace sinew::vision {

/// Bytes of a file from an offset on, at most `size`; fewer where the file ends before that.
using ReadAt = std::function<std::vector<std::uint8_t>(std::uint64_t offset, std::size_t size)>;

}  // namespace sinew::vision
