#include "sinew/server/web_assets.h"

namespace sinew::server {

std::span<const Asset> web_assets() {
  return {};
}

}  // namespace sinew::server
