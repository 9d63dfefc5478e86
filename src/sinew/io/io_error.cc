#include "sinew/io/io_error.h"

#include <cctype>
#include <system_error>

namespace sinew::io {

IoError system_error(const std::string& subject, int errno_value) {
  std::string message = std::generic_category().message(errno_value);
  if (!message.empty()) message[0] = static_cast<char>(std::tolower(message[0]));
  return {(subject.empty() ? "''" : subject) + ": " + message};
}

}  // namespace sinew::io
