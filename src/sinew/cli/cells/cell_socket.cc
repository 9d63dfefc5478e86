#include "sinew/cli/cells/cell_socket.h"

#include "sinew/io/local_socket.h"

namespace sinew::cli {

io::IoResult<std::string> cell_socket(const std::optional<std::string>& given) {
  if (given) return *given;
  auto folder = io::socket_folder();
  if (!folder) return folder;
  return *folder + "/cell.sock";
}

}  // namespace sinew::cli
