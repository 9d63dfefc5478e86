#pragma once

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/stream_base.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket.hpp>
#include <list>
#include <memory>
#include <string>

#include "sinew/server/web/server_loop.h"
#include "sinew/server/web/web_answer.h"
#include "sinew/server/web/web_gate.h"
#include "sinew/server/web/web_session.h"

/// The connections of the network door, plain and with TLS. Slow to compile: web_server.cc alone
/// includes it.
namespace sinew::server {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;

inline constexpr auto kHeadTime = std::chrono::seconds(10);  ///< for a head, from the answer before
inline constexpr auto kBodyTime = std::chrono::seconds(10);  ///< for the rest of a request
inline constexpr auto kWriteTime = std::chrono::seconds(30);  ///< for an answer to be taken
inline constexpr auto kDrainTime = std::chrono::seconds(2);   ///< for what comes behind a refusal
inline constexpr auto kTokenTime = std::chrono::seconds(5);   ///< for a WebSocket's first message
inline constexpr auto kQuietTime =
    std::chrono::seconds(20);  ///< then a WebSocket is pinged, and ends
inline constexpr auto kAnswerTime = std::chrono::seconds(60);   ///< for the Api to answer a post
inline constexpr std::size_t kDrainMax = std::size_t{4} << 20;  ///< bytes

/// One connection. Lives as long as a handler of it is under way, or the door keeps it.
class WebConnection {
 public:
  virtual ~WebConnection() = default;
  /// What its session has to say goes out; what it may read again is read.
  virtual void turn() = 0;
  virtual void end() = 0;
  virtual bool open() const = 0;
  /// It has shown no token yet.
  virtual bool stranger() const = 0;
  /// It has posted, got its answer, and keeps its place.
  virtual bool lingers() const { return false; }
  /// Its session moves something, or may.
  virtual bool holds() const { return false; }
  /// What lingers leaves its place to another; it stays open, since its client may be sending.
  virtual void give_place() {}
};

/// What connections share.
struct WebDoor {
  ServerLoop& loop;
  WebGate gate;
  std::string document;  ///< OpenRPC
  std::list<std::shared_ptr<WebConnection>> connections;
  std::size_t sockets = 0;
  std::size_t posters = 0;
  std::size_t sockets_max = 0;
  std::size_t posters_max = 0;
};

/// A WebSocket, from its upgrade to its end.
template <class Stream>
class SocketConnection final : public WebConnection,
                               public std::enable_shared_from_this<SocketConnection<Stream>> {
 public:
  SocketConnection(Stream stream, std::shared_ptr<WebDoor> door, WebCaller caller)
      : socket_(std::move(stream)), door_(std::move(door)), caller_(std::move(caller)) {}
  ~SocketConnection() override { end(); }

  void accept(const WebRequest& request) {
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(websocket::stream_base::timeout{kHeadTime, kQuietTime, true});
    socket_.set_option(websocket::stream_base::decorator([&](websocket::response_type& answer) {
      if (request.subprotocol) {
        answer.set("Sec-WebSocket-Protocol",
                   beast::string_view(kSubprotocol.data(), kSubprotocol.size()));
      }
      answer.set("Server", "Sinew");
    }));
    socket_.read_message_max(request.role ? kMessageMax : kFirstMessageMax);
    socket_.auto_fragment(false);  // a large answer is one frame, and not 150 writes
    beast::http::request<beast::http::empty_body> upgrade;
    upgrade.version(11);
    upgrade.method(beast::http::verb::get);
    upgrade.target("/ws");
    for (const char* name :
         {"Host", "Upgrade", "Connection", "Sec-WebSocket-Key", "Sec-WebSocket-Version"}) {
      if (const std::string* value = request.head.find(lower_case(name))) upgrade.set(name, *value);
    }
    // One word is enough for the library, whatever else stood there.
    upgrade.set("Upgrade", "websocket");
    upgrade.set("Connection", "Upgrade");
    if (request.role) open_session(*request.role);
    token_until_ = door_->loop.now() + kTokenTime;
    accepting_ = true;
    socket_.async_accept(upgrade, [self = this->shared_from_this()](auto error) {
      self->accepting_ = false;
      if (error) return self->end();
      self->read();
    });
  }

  void turn() override {
    if (!open_) return;
    if (!session_ && !ending_ && door_->loop.now() > token_until_) {
      return finish(websocket::close_code::policy_error, "no token came");
    }
    if (session_ && door_->loop.api().too_slow(*session_)) {
      return finish(websocket::close_code::policy_error, "answers are not read");
    }
    pace_.pass(door_->loop.now());
    read();
    write();
  }
  void end() override {
    if (!open_) return;
    open_ = false;
    close_session();
    boost::system::error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }
  bool open() const override { return open_; }
  bool stranger() const override { return !session_; }

 private:
  bool open_session(Role role) {
    if (door_->sockets >= door_->sockets_max) return false;
    session_ = door_->loop.api().open(role);
    if (session_) ++door_->sockets;
    return session_.has_value();
  }
  void close_session() {
    if (!session_) return;
    door_->loop.api().close(*session_);
    --door_->sockets;
    session_.reset();
  }

  void read() {
    // Somebody who is refused is not read any more: the refusal may still be on its way out.
    const bool room = !session_ || door_->loop.api().has_room(*session_);
    const bool may_read = open_ && !ending_ && last_reason_ == nullptr && pace_.may_read() && room;
    if (!may_read || accepting_ || reading_) return;
    reading_ = true;
    socket_.async_read(buffer_, [self = this->shared_from_this()](auto error, std::size_t size) {
      self->reading_ = false;
      if (error) return self->end();
      self->pace_.spend(size);
      self->take();
      self->read();
    });
  }

  void take() {
    if (!open_ || ending_) return;
    if (!socket_.got_text()) {
      return finish(websocket::close_code::unknown_data, "messages are text");
    }
    const std::string_view text(static_cast<const char*>(buffer_.cdata().data()),
                                buffer_.cdata().size());
    if (session_) {
      door_->loop.receive(*session_, text);
    } else {
      take_token(text);
    }
    buffer_.consume(buffer_.size());
    // A large message's room is not kept.
    if (buffer_.capacity() > kSmallBuffer) buffer_.shrink_to_fit();
    write();
  }

  void take_token(std::string_view text) {
    const auto first = read_session_open(text);
    if (!first) return refuse(error_text(first.error().id, first.error().error), "no token");
    const auto role = door_->gate.admit(first->token, caller_, door_->loop.now());
    if (!role) {
      return refuse(error_text(first->id, {RpcCode::kRefused, role.error().sentence, nullptr}),
                    "no token");
    }
    if (!open_session(*role)) {
      return refuse(error_text(first->id, {RpcCode::kBusy, kFull, nullptr}), "full");
    }
    socket_.read_message_max(kMessageMax);
    outgoing_ = result_text(first->id, {{"role", role_name(*role)}});
  }

  /// Says why, and ends.
  void refuse(std::string text, const char* reason) {
    outgoing_ = std::move(text);
    last_reason_ = reason;
    write();
  }

  void write() {
    if (!open_ || accepting_ || writing_ || ending_) return;
    if (outgoing_.empty() && session_) {
      if (auto text = door_->loop.api().take_output(*session_)) outgoing_ = std::move(*text);
    }
    if (outgoing_.empty()) {
      if (last_reason_ != nullptr) finish(websocket::close_code::policy_error, last_reason_);
      return;
    }
    writing_ = true;
    socket_.text(true);
    socket_.async_write(asio::buffer(outgoing_),
                        [self = this->shared_from_this()](auto error, std::size_t) {
                          self->writing_ = false;
                          std::string().swap(self->outgoing_);  // a large one's room is not kept
                          if (error) return self->end();
                          self->write();
                        });
  }

  void finish(websocket::close_code code, const char* reason) {
    if (!open_ || ending_) return;
    ending_ = true;
    close_session();
    // Somebody who does not read cannot be told; a write under way ends with the connection.
    if (writing_ || accepting_) return end();
    socket_.async_close({code, reason}, [self = this->shared_from_this()](auto) { self->end(); });
  }

  static constexpr std::size_t kSmallBuffer = std::size_t{64} * 1024;
  static constexpr std::size_t kFirstMessageMax = 4096;  ///< bytes, of who has no token yet

  websocket::stream<Stream, false> socket_;  // nothing is compressed: a bomb needs that
  std::shared_ptr<WebDoor> door_;
  WebCaller caller_;
  std::optional<SessionId> session_;
  beast::flat_buffer buffer_;
  std::string outgoing_;
  WebPace pace_;
  Instant token_until_{};
  const char* last_reason_ = nullptr;
  bool open_ = true;
  bool accepting_ = false;
  bool reading_ = false;
  bool writing_ = false;
  bool ending_ = false;
};

/// Requests one after the other, until one of them becomes a WebSocket.
template <class Stream>
class HttpConnection final : public WebConnection,
                             public std::enable_shared_from_this<HttpConnection<Stream>> {
 public:
  HttpConnection(Stream stream, std::shared_ptr<WebDoor> door, WebCaller caller)
      : stream_(std::move(stream)), door_(std::move(door)), caller_(std::move(caller)) {}
  ~HttpConnection() override { end(); }

  void begin() {
    if constexpr (std::is_same_v<Stream, beast::tcp_stream>) {
      next();
    } else {
      lowest().expires_after(kHeadTime);
      stream_.async_handshake(asio::ssl::stream_base::server,
                              [self = this->shared_from_this()](auto error) {
                                if (error) return self->end();
                                self->next();
                              });
    }
  }

  void turn() override {
    if (!open_ || !waiting_) return;
    if (auto text = door_->loop.api().take_output(*session_)) {
      waiting_ = false;
      return answer({.status = 200, .type = "application/json"}, std::move(*text));
    }
    if (door_->loop.now() > answer_until_) {
      waiting_ = false;
      refuse({504, "the cell did not answer within a minute", {}});
    }
  }
  void end() override {
    if (!open_) return;
    open_ = false;
    close_session();
    boost::system::error_code ignored;
    lowest().socket().close(ignored);
  }
  bool open() const override { return open_; }
  bool stranger() const override { return !session_; }
  bool lingers() const override { return open_ && session_ && !waiting_ && outgoing_.empty(); }
  bool holds() const override { return session_ && door_->loop.api().holds(*session_); }
  void give_place() override { close_session(); }

 private:
  auto& lowest() { return beast::get_lowest_layer(stream_); }

  void close_session() {
    if (!session_) return;
    door_->loop.api().close(*session_);
    --door_->posters;
    session_.reset();
  }

  void next() {
    lowest().expires_after(kHeadTime);
    read_head_part();
  }

  void read_head_part() {
    if (!open_) return;
    const auto size = head_size(received_);
    if (!size) return refuse(size.error());
    if (*size != 0) return decide(*size);
    stream_.async_read_some(asio::buffer(part_),
                            [self = this->shared_from_this()](auto error, std::size_t count) {
                              if (error) return self->end();
                              self->received_.append(self->part_.data(), count);
                              self->read_head_part();
                            });
  }

  void decide(std::size_t size) {
    const std::string_view head = std::string_view(received_).substr(0, size);
    head_only_ = head.starts_with("HEAD ");
    auto request = door_->gate.decide(head, caller_, door_->loop.now());
    received_.erase(0, size);
    if (!request) return refuse(request.error());
    request_ = std::move(*request);
    origin_ = door_->gate.origin_of(*request_.head.find("host"));
    switch (request_.kind) {
      case WebRequest::Kind::kAsset:
        return answer_asset();
      case WebRequest::Kind::kNoPanel:
        return answer({.status = 200, .type = "text/html; charset=utf-8"},
                      std::string(no_panel_page()));
      case WebRequest::Kind::kDocument:
        return answer({.status = 200, .type = "application/json"}, door_->document);
      case WebRequest::Kind::kRpc:
        lowest().expires_after(kBodyTime);
        return read_body();
      case WebRequest::Kind::kSocket:
        return become_socket();
    }
  }

  void answer_asset() {
    const Asset& asset = *request_.asset;
    // Names in /assets/ carry the hash of what they hold.
    WebAnswer what{
        .status = request_.not_modified ? 304 : 200,
        .type = asset.type,
        .fields = "Content-Encoding: gzip\r\nVary: Accept-Encoding\r\nETag: " +
                  std::string(asset.etag) + "\r\nCache-Control: " +
                  (asset.path.starts_with("/assets/") ? "public, max-age=31536000, immutable"
                                                      : "no-cache") +
                  "\r\n"};
    if (request_.not_modified) {
      what.type = {};
      return answer(what, {});
    }
    answer(what, std::string(reinterpret_cast<const char*>(asset.gzip.data()), asset.gzip.size()));
  }

  void read_body() {
    if (!open_) return;
    if (received_.size() >= request_.body) return take_message();
    stream_.async_read_some(asio::buffer(part_),
                            [self = this->shared_from_this()](auto error, std::size_t count) {
                              if (error) return self->end();
                              self->received_.append(self->part_.data(), count);
                              self->read_body();
                            });
  }

  void take_message() {
    const std::string text = received_.substr(0, request_.body);
    received_.erase(0, request_.body);
    if (session_ && role_ != request_.role) close_session();
    if (!session_) {
      // Somebody who only keeps a place must not keep others from a stop.
      if (door_->posters >= door_->posters_max) free_a_place();
      if (door_->posters < door_->posters_max) {
        session_ = door_->loop.api().open(*request_.role, Delivery::kAnswersOnly);
      }
      if (!session_) return refuse({503, kFull, "Retry-After: 1\r\n"});
      ++door_->posters;
      role_ = request_.role;
    }
    lowest().expires_never();
    const bool answered = is_answered(text);
    door_->loop.receive(*session_, text);
    if (!answered) return answer({.status = 204}, {});
    waiting_ = true;
    answer_until_ = door_->loop.now() + kAnswerTime;
    turn();
  }

  void free_a_place() {
    // Who holds a lease or runs a program only where all the others do too.
    for (const bool taking : {false, true}) {
      for (const auto& connection : door_->connections) {
        if (!connection->lingers() || (connection->holds() && !taking)) continue;
        return connection->give_place();
      }
    }
  }

  void become_socket() {
    // The first frames of a client wait for the answer to its upgrade.
    if (!received_.empty()) return refuse({400, "frames came before the upgrade", {}});
    const bool room =
        door_->sockets < door_->sockets_max && door_->loop.api().sessions() < Api::kSessionsMax;
    if (request_.role && !room) {
      return refuse({503, kFull, "Retry-After: 10\r\n"});
    }
    close_session();
    auto socket = std::make_shared<SocketConnection<Stream>>(std::move(stream_), door_, caller_);
    open_ = false;  // it has given its stream away
    door_->connections.push_back(socket);
    socket->accept(request_);
  }

  void answer(WebAnswer what, std::string body) {
    what.close = request_.close;
    what.length = body.size();
    outgoing_ = answer_head(what, origin_);
    if (!request_.head_only) outgoing_ += body;
    last_ = what.close;
    write();
  }
  void refuse(const HttpRefusal& refusal) {
    outgoing_ = refusal_text(refusal, head_only_);
    last_ = true;
    write();
  }

  void write() {
    lowest().expires_after(kWriteTime);
    asio::async_write(stream_, asio::buffer(outgoing_),
                      [self = this->shared_from_this()](auto error, std::size_t) {
                        if (error) return self->end();
                        self->outgoing_.clear();
                        if (self->last_) return self->drain_and_end();
                        self->next();
                      });
  }

  /// Closing while bytes come in would tear the answer out of the client's hands.
  void drain_and_end() {
    close_session();
    lowest().expires_after(kDrainTime);
    boost::system::error_code failed;
    lowest().socket().shutdown(Tcp::socket::shutdown_send, failed);
    if (failed) return end();
    drain();
  }
  void drain() {
    if (!open_) return;
    lowest().async_read_some(asio::buffer(part_),
                             [self = this->shared_from_this()](auto error, std::size_t count) {
                               self->drained_ += count;
                               if (error || self->drained_ > kDrainMax) return self->end();
                               self->drain();
                             });
  }

  Stream stream_;
  std::shared_ptr<WebDoor> door_;
  WebCaller caller_;
  std::array<char, 16384> part_{};
  std::string received_;
  WebRequest request_;
  std::string origin_;
  std::string outgoing_;
  std::optional<SessionId> session_;
  std::optional<Role> role_;
  Instant answer_until_{};
  std::size_t drained_ = 0;
  bool open_ = true;
  bool head_only_ = false;
  bool waiting_ = false;
  bool last_ = false;
};

}  // namespace sinew::server
