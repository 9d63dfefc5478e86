#include "sinew/server/web/local_server.h"

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/write.hpp>
#include <list>

namespace sinew::server {
namespace {

namespace asio = boost::asio;
using Socket = asio::local::stream_protocol::socket;

constexpr std::size_t kReadSize = 64 * 1024;

/// One client. Lives as long as a handler of it is under way.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Socket socket, ServerLoop& loop, SessionId session)
      : socket_(std::move(socket)), loop_(loop), api_(&loop.api()), session_(session) {}

  /// What has come is taken; where all of it was, more is read.
  void read() {
    if (reading_ || !open()) return;
    take();
    if (!open() || taken_ < filled_) return;
    reading_ = true;
    socket_.async_read_some(asio::buffer(buffer_),
                            [self = shared_from_this()](auto error, std::size_t count) {
                              self->reading_ = false;
                              if (error) return self->end();
                              self->taken_ = 0;
                              self->filled_ = count;
                              self->read();
                              self->write();
                            });
  }

  /// What the session has to say goes out, as fast as the client reads.
  void write() {
    if (writing_ || !open()) return;
    std::string().swap(outgoing_);  // a large one's room is not kept
    while (outgoing_.size() < kReadSize) {
      auto text = api_->take_output(session_);
      if (!text) break;
      *text += '\n';
      if (outgoing_.empty()) {
        outgoing_ = std::move(*text);
      } else {
        outgoing_ += *text;
      }
    }
    if (outgoing_.empty()) {
      if ((last_ && api_->settled(session_)) || api_->too_slow(session_)) end();
      return;
    }
    writing_ = true;
    asio::async_write(socket_, asio::buffer(outgoing_),
                      [self = shared_from_this()](auto error, std::size_t) {
                        self->writing_ = false;
                        if (error) return self->end();
                        self->write();
                      });
  }

  bool open() const { return api_ != nullptr; }
  void end() {
    if (!open()) return;
    api_->close(session_);
    api_ = nullptr;
    boost::system::error_code ignored;
    socket_.close(ignored);
  }

 private:
  void take() {
    while (taken_ < filled_ && open() && !last_ && api_->has_room(session_)) {
      const char byte = buffer_[taken_++];
      if (byte != '\n') {
        // Nobody knows where the next message begins.
        last_ = line_.size() > kMessageMax;
        if (!last_) {
          line_ += byte;
          continue;
        }
      }
      if (!line_.empty()) loop_.receive(session_, line_);
      if (line_.capacity() > kReadSize) line_.shrink_to_fit();
      line_.clear();
    }
  }

  Socket socket_;
  ServerLoop& loop_;
  Api* api_;  ///< null: over
  SessionId session_;
  std::array<char, kReadSize> buffer_{};
  std::size_t filled_ = 0;  ///< bytes in it
  std::size_t taken_ = 0;   ///< of them
  std::string line_;
  std::string outgoing_;
  bool reading_ = false;
  bool writing_ = false;
  bool last_ = false;  ///< a line that has no end
};

}  // namespace

class LocalServer::Implementation
    : public std::enable_shared_from_this<LocalServer::Implementation> {
 public:
  Implementation(io::LocalListener listener, ServerLoop& loop)
      : listener_(std::move(listener)), loop_(loop), descriptor_(loop.context()) {
    descriptor_.assign(listener_.descriptor());
  }

  const std::string& path() const { return listener_.path(); }

  void begin() {
    loop_.each_turn([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->turn();
    });
    accept();
  }
  void end() {
    for (const auto& connection : connections_) connection->end();
    connections_.clear();
    descriptor_.release();  // the listener's own
    loop_.drain();
  }

 private:
  void accept() {
    descriptor_.async_wait(asio::posix::stream_descriptor::wait_read,
                           [self = shared_from_this()](auto error) {
                             if (error) return;
                             self->let_in();
                             self->accept();
                           });
  }

  void let_in() {
    Socket socket(loop_.context());
    const int client = listener_.accept_descriptor();
    if (client < 0) return;
    boost::system::error_code failed;
    socket.assign(asio::local::stream_protocol(), client, failed);
    if (failed) return;
    const auto session = loop_.api().open(Role::kOperator);
    if (!session) {
      const std::string text =
          error_text(nullptr,
                     {RpcCode::kBusy, "this server has as many clients as it serves", nullptr}) +
          "\n";
      asio::write(socket, asio::buffer(text), failed);
      return;
    }
    connections_.push_back(std::make_shared<Connection>(std::move(socket), loop_, *session));
    connections_.back()->read();
  }

  void turn() {
    for (auto it = connections_.begin(); it != connections_.end();) {
      (*it)->read();
      (*it)->write();
      it = (*it)->open() ? std::next(it) : connections_.erase(it);
    }
  }

  io::LocalListener listener_;
  ServerLoop& loop_;
  asio::posix::stream_descriptor descriptor_;
  std::list<std::shared_ptr<Connection>> connections_;
};

LocalServer::LocalServer(std::shared_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
LocalServer::~LocalServer() {
  implementation_->end();
}

io::IoResult<std::unique_ptr<LocalServer>> LocalServer::listen(const std::string& path,
                                                               ServerLoop& loop) {
  constexpr int kWaiting = 16;
  auto listener = io::LocalListener::create(path, kWaiting);
  if (!listener) return std::unexpected(listener.error());
  auto implementation = std::make_shared<Implementation>(std::move(*listener), loop);
  implementation->begin();
  return std::unique_ptr<LocalServer>(new LocalServer(std::move(implementation)));
}

const std::string& LocalServer::path() const {
  return implementation_->path();
}

}  // namespace sinew::server
