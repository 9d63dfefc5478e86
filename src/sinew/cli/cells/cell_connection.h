#pragma once

#include <chrono>
#include <expected>
#include <string>
#include <string_view>

#include "sinew/cli/output/outcome.h"
#include "sinew/core/instant.h"
#include "sinew/server/web/rpc_client.h"

namespace sinew::cli {

/// A lease lives for a second behind its holder's last word: so often whoever follows something
/// says one, and looks for messages meanwhile.
inline constexpr Duration kAlive = std::chrono::milliseconds(250);
inline constexpr Duration kSlice = std::chrono::milliseconds(50);

/// A running cell as the verbs that talk to it see it.
class CellConnection {
 public:
  /// @error  nobody answers there; says how to start a server
  static std::expected<CellConnection, Outcome> open(const std::optional<std::string>& socket);

  /// @error  the server's refusal, ready to be printed
  std::expected<Json, Outcome> call(std::string_view method, const Json& params = Json::object());
  server::RpcClient& client() { return client_; }
  const std::string& path() const { return path_; }

 private:
  CellConnection(server::RpcClient client, std::string path)
      : client_(std::move(client)), path_(std::move(path)) {}

  server::RpcClient client_;
  std::string path_;
};

/// Of a refusal.
Outcome refused(const server::RpcError& error);

/// The description of a robot of the cell.
/// @error  there is none of this name
std::expected<Json, Outcome> robot_of_cell(CellConnection& cell, const std::string& name);

/// Whether this user's running cell has that port open, as the end of a sentence; else empty.
std::string held_by_cell(const std::string& port);

/// "home", or a value a joint (deg, mm of a leg), as rad and m.
/// @param option  as the user typed it
std::expected<Json, Outcome> positions_of(CellConnection& cell, const std::string& robot,
                                          std::string_view option, const std::string& text);

/// Where a joint of a cell's status stands, deg or mm: "30.00", "29.00..31.00", or `lost`.
std::string place_of(const Json& joint, const char* lost);

}  // namespace sinew::cli
