#include "sinew/io/terminal.h"

#include <unistd.h>

namespace sinew::io {

bool stderr_is_terminal() {
  return isatty(STDERR_FILENO) == 1;
}

}  // namespace sinew::io
