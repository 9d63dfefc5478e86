#include "sinew/server/web/web_server.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/ssl.hpp>
#include <charconv>

#include "sinew/server/json/open_rpc.h"
#include "sinew/server/web/web_connection.h"

namespace sinew::server {
namespace {

using Plain = beast::tcp_stream;
using Secured = beast::ssl_stream<beast::tcp_stream>;

constexpr int kWaiting = 64;  // connections that wait to be let in
/// Beyond that a slow reader's news would be old before it is read.
constexpr int kSendBuffer = 128 * 1024;

std::unexpected<io::IoError> refuse(std::string sentence) {
  return std::unexpected(io::IoError{std::move(sentence)});
}

struct Place {
  std::string host;
  std::uint16_t port = 0;
};

/// HOST:PORT, [::1]:PORT.
io::IoResult<Place> place_of(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  Place place;
  const auto wrong = [&] {
    return refuse("'" + text + "': write HOST:PORT, as in 127.0.0.1:8700 or [::1]:8700");
  };
  if (colon == std::string::npos || colon == 0) return wrong();
  place.host = text.substr(0, colon);
  if (place.host.starts_with('[') && place.host.ends_with(']')) {
    place.host = place.host.substr(1, place.host.size() - 2);
  } else if (place.host.contains(':')) {
    return wrong();
  }
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + colon + 1, end, place.port);
  if (read.ec != std::errc() || read.ptr != end) return wrong();
  return place;
}

/// An IPv4 client of a socket that hears both is one of IPv4.
std::string text_of(const asio::ip::address& address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_string();
  }
  return address.to_string();
}

io::IoResult<asio::ip::address> address_of(asio::io_context& context, const std::string& host) {
  boost::system::error_code failed;
  auto address = asio::ip::make_address(host, failed);
  if (!failed) return address;
  Tcp::resolver resolver(context);
  const auto found = resolver.resolve(host, "", Tcp::resolver::passive, failed);
  if (failed || found.empty()) return refuse(host + ": no address has this name");
  return found.begin()->endpoint().address();
}

/// As clients may call a server that listens there.
std::vector<std::string> hosts_of(const WebOptions& options, const Place& place,
                                  const asio::ip::address& address) {
  const bool tls = !options.tls_certificate.empty();
  std::vector<std::string> hosts;
  const auto add = [&](const std::string& host) {
    if (std::ranges::find(hosts, host) == hosts.end()) hosts.push_back(host);
  };
  if (!address.is_unspecified()) add(host_text(place.host, place.port, tls));
  if (!address.is_unspecified()) add(host_text(address.to_string(), place.port, tls));
  for (const char* local : {"127.0.0.1", "localhost", "::1"})
    add(host_text(local, place.port, tls));
  for (const std::string& host : options.hosts) add(lower_case(host));
  return hosts;
}

io::IoResult<std::unique_ptr<asio::ssl::context>> secured(const WebOptions& options) {
  auto context = std::make_unique<asio::ssl::context>(asio::ssl::context::tls_server);
  using Ssl = asio::ssl::context;
  boost::system::error_code failed;
  context->set_options(Ssl::default_workarounds | Ssl::no_sslv2 | Ssl::no_sslv3 | Ssl::no_tlsv1 |
                           Ssl::no_tlsv1_1 | Ssl::single_dh_use,
                       failed);
  context->use_certificate_chain_file(options.tls_certificate, failed);
  if (failed) return refuse(options.tls_certificate + ": no certificate can be read there (PEM)");
  context->use_private_key_file(options.tls_key, Ssl::pem, failed);
  if (failed) {
    return refuse(options.tls_key + ": no key can be read there that fits the certificate (PEM)");
  }
  return context;
}

}  // namespace

class WebServer::Implementation : public std::enable_shared_from_this<WebServer::Implementation> {
 public:
  Implementation(Tcp::acceptor acceptor, std::shared_ptr<WebDoor> door,
                 std::unique_ptr<asio::ssl::context> tls, std::string url)
      : acceptor_(std::move(acceptor)),
        door_(std::move(door)),
        tls_(std::move(tls)),
        url_(std::move(url)),
        endpoint_(acceptor_.local_endpoint()) {}

  const std::string& url() const { return url_; }
  std::uint16_t port() const { return endpoint_.port(); }
  bool loopback() const { return endpoint_.address().is_loopback(); }

  void begin() {
    door_->loop.each_turn([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->turn();
    });
    accept();
  }
  void end() {
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    for (const auto& connection : door_->connections) connection->end();
    door_->connections.clear();
    door_->loop.drain();
  }

 private:
  void accept() {
    accepting_ = true;
    acceptor_.async_accept([self = shared_from_this()](auto error, Tcp::socket socket) {
      self->accepting_ = false;
      // Out of descriptors, perhaps: the next turn tries again.
      if (error) return;
      self->let_in(std::move(socket));
      self->accept();
    });
  }

  void let_in(Tcp::socket socket) {
    boost::system::error_code failed;
    const auto theirs = socket.remote_endpoint(failed);
    if (failed) return;
    const auto ours = socket.local_endpoint(failed);
    if (failed) return;
    socket.set_option(Tcp::no_delay(true), failed);
    socket.set_option(asio::socket_base::send_buffer_size(kSendBuffer), failed);
    make_room();
    WebCaller caller{text_of(theirs.address()),
                     host_text(text_of(ours.address()), ours.port(), tls_ != nullptr)};
    if (tls_) {
      add(std::make_shared<HttpConnection<Secured>>(Secured(Plain(std::move(socket)), *tls_), door_,
                                                    std::move(caller)));
    } else {
      add(std::make_shared<HttpConnection<Plain>>(Plain(std::move(socket)), door_,
                                                  std::move(caller)));
    }
  }

  template <class Connection>
  void add(std::shared_ptr<Connection> connection) {
    door_->connections.push_back(connection);
    connection->begin();
  }

  void make_room() {
    std::size_t strangers = 0;
    WebConnection* oldest = nullptr;
    for (const auto& connection : door_->connections) {
      if (!connection->open() || !connection->stranger()) continue;
      if (oldest == nullptr) oldest = connection.get();
      ++strangers;
    }
    if (strangers >= kStrangersMax) oldest->end();
  }

  void turn() {
    auto& connections = door_->connections;
    for (auto it = connections.begin(); it != connections.end();) {
      const std::shared_ptr<WebConnection> connection = *it;
      connection->turn();
      it = connection->open() ? std::next(it) : connections.erase(it);
    }
    if (!accepting_ && acceptor_.is_open()) accept();
  }

  Tcp::acceptor acceptor_;
  std::shared_ptr<WebDoor> door_;
  std::unique_ptr<asio::ssl::context> tls_;
  std::string url_;
  Tcp::endpoint endpoint_;
  bool accepting_ = false;
};

WebServer::WebServer(std::shared_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
WebServer::~WebServer() {
  implementation_->end();
}
const std::string& WebServer::url() const {
  return implementation_->url();
}
std::uint16_t WebServer::port() const {
  return implementation_->port();
}
bool WebServer::loopback() const {
  return implementation_->loopback();
}

io::IoResult<std::unique_ptr<WebServer>> WebServer::listen(WebOptions options, ServerLoop& loop) {
  auto place = place_of(options.listen);
  if (!place) return std::unexpected(place.error());
  const auto address = address_of(loop.context(), place->host);
  if (!address) return std::unexpected(address.error());
  const bool tls = !options.tls_certificate.empty() || !options.tls_key.empty();
  if (!address->is_loopback() && !tls && !options.insecure_network) {
    return refuse(options.listen +
                  " can be reached from the network, where everybody on the way could read the "
                  "token and what is sent: give --tls-cert and --tls-key, or --insecure-network "
                  "where only people stand on this network who may move the robots");
  }
  std::unique_ptr<asio::ssl::context> context;
  if (tls) {
    auto made = secured(options);
    if (!made) return std::unexpected(made.error());
    context = std::move(*made);
  }
  boost::system::error_code failed;
  Tcp::acceptor acceptor(loop.context());
  acceptor.open(Tcp::endpoint(*address, 0).protocol(), failed);
  if (!failed) acceptor.set_option(Tcp::acceptor::reuse_address(true), failed);
  if (!failed) acceptor.bind({*address, place->port}, failed);
  if (!failed) acceptor.listen(kWaiting, failed);
  if (failed) {
    const bool taken = failed == boost::asio::error::address_in_use;
    return refuse(options.listen + ": " +
                  (taken ? "another program listens there; --listen 127.0.0.1:0 takes a free port"
                         : failed.message()));
  }
  place->port = acceptor.local_endpoint().port();
  WebGate gate({.tls = tls,
                .hosts = hosts_of(options, *place, *address),
                .operator_token = options.operator_token,
                .viewer_token = options.viewer_token,
                .assets = options.assets});
  const std::string name = address->is_unspecified() ? "localhost" : place->host;
  const std::string url = gate.origin_of(host_text(name, place->port, tls)) + "/";
  auto door = std::make_shared<WebDoor>(WebDoor{.loop = loop,
                                                .gate = std::move(gate),
                                                .document = open_rpc_text(loop.api().version()),
                                                .connections = {},
                                                .sockets_max = kSocketsMax,
                                                .posters_max = kPostersMax});
  auto implementation = std::make_shared<Implementation>(std::move(acceptor), std::move(door),
                                                         std::move(context), url);
  implementation->begin();
  return std::unique_ptr<WebServer>(new WebServer(std::move(implementation)));
}

}  // namespace sinew::server
