#include "sinew/cli/cells/web_door.h"

#include <fmt/format.h>

#include <array>

#include "sinew/io/private_file.h"
#include "sinew/runtime/journal/position_record.h"
#include "sinew/server/web/web_tokens.h"

namespace sinew::cli {
namespace {

constexpr const char* kFreePort = "127.0.0.1:0";

struct Token {
  std::string file;
  std::string text;
};

/// Made when the door opens for the first time.
io::IoResult<Token> keep_token(const std::string& folder, const char* role) {
  std::array<std::uint8_t, server::kTokenBytes> random{};
  if (auto filled = io::fill_unguessable(random); !filled) return std::unexpected(filled.error());
  Token token{folder + "/" + role + ".token", {}};
  auto text = io::keep_private(token.file, server::token_text(random) + "\n");
  if (!text) return std::unexpected(text.error());
  token.text = text->substr(0, text->find('\n'));
  if (!server::is_token_text(token.text)) {
    return std::unexpected(
        io::IoError{token.file + ": holds no token; delete it, and a new one is made"});
  }
  return token;
}

io::IoResult<WebDoor> open(const WebDoorRequest& request, server::ServerLoop& loop) {
  const auto folder = runtime::web_folder();
  if (!folder) return std::unexpected(folder.error());
  const auto operators = keep_token(*folder, "operator");
  if (!operators) return std::unexpected(operators.error());
  const auto viewers = keep_token(*folder, "viewer");
  if (!viewers) return std::unexpected(viewers.error());
  if (operators->text == viewers->text) {
    return std::unexpected(io::IoError{*folder + ": both tokens are the same; delete one of them"});
  }
  server::WebOptions options{.hosts = request.hosts,
                             .operator_token = operators->text,
                             .viewer_token = viewers->text,
                             .tls_certificate = request.tls_certificate,
                             .tls_key = request.tls_key,
                             .insecure_network = request.insecure_network,
                             .assets = server::web_assets()};
  if (request.listen) options.listen = *request.listen;
  auto server = server::WebServer::listen(std::move(options), loop);
  if (!server) return std::unexpected(server.error());
  WebDoor door;
  door.server = std::move(*server);
  const std::string& url = door.server->url();
  door.link = url + "#token=" + operators->text;
  door.text =
      fmt::format("  panel: {}\n         who has this link may move the robots\n", door.link);
  door.json = {
      {"url", url}, {"operator_token_file", operators->file}, {"viewer_token_file", viewers->file}};
  if (!door.server->loopback() && request.tls_certificate.empty()) {
    door.text +=
        "  without TLS on a network: everybody on the way reads the token and what is sent, and "
        "may "
        "then move the robots\n";
  }
  return door;
}

}  // namespace

std::expected<WebDoor, Outcome> open_web_door(const WebDoorRequest& request,
                                              server::ServerLoop& loop) {
  const bool tls = !request.tls_certificate.empty();
  if (tls == request.tls_key.empty()) {
    return std::unexpected(bad_input("TLS needs both --tls-cert and --tls-key"));
  }
  if (request.listen && *request.listen == "none") return WebDoor{};
  auto door = open(request, loop);
  if (door) return std::move(*door);
  const bool asked = request.listen || tls || request.insecure_network || !request.hosts.empty();
  if (!asked) {
    // Another cell has the usual port, say; a panel elsewhere is better than none.
    WebDoorRequest anywhere = request;
    anywhere.listen = kFreePort;
    if (auto other = open(anywhere, loop)) {
      other->text = fmt::format("  {}\n", door.error().sentence) + other->text;
      return std::move(*other);
    }
  }
  if (asked) return std::unexpected(could_not("--listen: " + door.error().sentence));
  WebDoor none;
  none.text = fmt::format("  no panel: {}\n", door.error().sentence);
  none.json = {{"error", {{"sentence", door.error().sentence}}}};
  return none;
}

}  // namespace sinew::cli
