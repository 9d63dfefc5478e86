#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/server/web/web_server.h"

namespace sinew::cli {

/// What `sinew serve` was told of the network.
struct WebDoorRequest {
  std::optional<std::string> listen;  ///< HOST:PORT, or "none"; 127.0.0.1:8700 where absent
  std::vector<std::string> hosts;     ///< by which it may be called besides
  std::string tls_certificate;
  std::string tls_key;
  bool insecure_network = false;
};

/// The network door of a cell, as far as there is one.
struct WebDoor {
  std::unique_ptr<server::WebServer> server;  ///< null: none
  std::string link;                           ///< with the operator's token, for a browser
  std::string text;                           ///< what there is to say of it, for people
  Json json = nullptr;  ///< the same for programs; where the tokens stand, not what they are
};

/// @error  what was asked for cannot be had. Where nothing was asked for, the cell goes on without
///         a door, and `text` says why.
std::expected<WebDoor, Outcome> open_web_door(const WebDoorRequest& request,
                                              server::ServerLoop& loop);

}  // namespace sinew::cli
