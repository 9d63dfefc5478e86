#pragma once

#include <expected>
#include <string>

namespace sinew::io {

/// What the operating system refused, as a sentence that names the thing and, where there is one,
/// the remedy.
struct IoError {
  std::string sentence;
};

template <class T>
using IoResult = std::expected<T, IoError>;

/// "PATH: no such file or directory" for an errno value.
IoError system_error(const std::string& subject, int errno_value);

}  // namespace sinew::io
