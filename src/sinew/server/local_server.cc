#include "sinew/server/local_server.h"

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <list>

#include "sinew/io/clock.h"

namespace sinew::server {
namespace {

namespace asio = boost::asio;
using Socket = asio::local::stream_protocol::socket;

constexpr auto kPollInterval = std::chrono::milliseconds(5);
constexpr std::size_t kReadSize = 64 * 1024;

/// One client. Lives as long as a handler of it is under way.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Socket socket, Api& api, SessionId session, const io::Clock& clock)
      : socket_(std::move(socket)), api_(&api), session_(session), clock_(clock) {}

  void read() {
    if (reading_ || !open()) return;
    reading_ = true;
    socket_.async_read_some(asio::buffer(buffer_),
                            [self = shared_from_this()](auto error, std::size_t count) {
                              self->reading_ = false;
                              if (error) return self->end();
                              self->take(count);
                              self->read();
                            });
  }

  /// What the session has to say goes out, as fast as the client reads.
  void write() {
    if (writing_ || !open()) return;
    outgoing_.clear();
    while (outgoing_.size() < kReadSize) {
      const auto text = api_->take_output(session_);
      if (!text) break;
      outgoing_ += *text + "\n";
    }
    if (outgoing_.empty()) {
      if (last_ || api_->too_slow(session_)) end();
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
  void take(std::size_t count) {
    for (std::size_t k = 0; k < count && open() && !last_; ++k) {
      if (buffer_[k] != '\n') {
        // Nobody knows where the next message begins.
        last_ = line_.size() > kMessageMax;
        if (!last_) {
          line_ += buffer_[k];
          continue;
        }
      }
      if (!line_.empty()) api_->receive(session_, line_, clock_.now());
      line_.clear();
    }
    write();
  }

  Socket socket_;
  Api* api_;  ///< null: over
  SessionId session_;
  const io::Clock& clock_;
  std::array<char, kReadSize> buffer_{};
  std::string line_;
  std::string outgoing_;
  bool reading_ = false;
  bool writing_ = false;
  bool last_ = false;  ///< a line that has no end
};

}  // namespace

class LocalServer::Implementation {
 public:
  Implementation(io::LocalListener listener, Api& api)
      : listener_(std::move(listener)), api_(api), descriptor_(context_), timer_(context_) {
    descriptor_.assign(listener_.descriptor());
  }
  ~Implementation() {
    for (const auto& connection : connections_) connection->end();
    descriptor_.release();  // the listener's own
    context_.restart();
    context_.poll();
  }

  const std::string& path() const { return listener_.path(); }

  void run(const std::function<bool()>& stop) {
    stop_ = &stop;
    accept();
    tick();
    context_.run();
  }

 private:
  void accept() {
    descriptor_.async_wait(asio::posix::stream_descriptor::wait_read, [this](auto error) {
      if (error) return;
      let_in();
      accept();
    });
  }

  void let_in() {
    Socket socket(context_);
    const int client = listener_.accept_descriptor();
    if (client < 0) return;
    boost::system::error_code failed;
    socket.assign(asio::local::stream_protocol(), client, failed);
    if (failed) return;
    const auto session = api_.open(Role::kOperator);
    if (!session) {
      const std::string text =
          error_text(nullptr,
                     {RpcCode::kBusy, "this server has as many clients as it serves", nullptr}) +
          "\n";
      asio::write(socket, asio::buffer(text), failed);
      return;
    }
    connections_.push_back(std::make_shared<Connection>(std::move(socket), api_, *session, clock_));
    connections_.back()->read();
  }

  void tick() {
    api_.poll(clock_.now());
    for (auto it = connections_.begin(); it != connections_.end();) {
      (*it)->write();
      it = (*it)->open() ? std::next(it) : connections_.erase(it);
    }
    if ((*stop_)()) return context_.stop();
    timer_.expires_after(kPollInterval);
    timer_.async_wait([this](auto error) {
      if (!error) tick();
    });
  }

  io::LocalListener listener_;
  Api& api_;
  io::Clock clock_;
  asio::io_context context_;
  asio::posix::stream_descriptor descriptor_;
  asio::steady_timer timer_;
  std::list<std::shared_ptr<Connection>> connections_;
  const std::function<bool()>* stop_ = nullptr;
};

LocalServer::LocalServer(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
LocalServer::~LocalServer() = default;

io::IoResult<std::unique_ptr<LocalServer>> LocalServer::listen(const std::string& path, Api& api) {
  constexpr int kWaiting = 16;
  auto listener = io::LocalListener::create(path, kWaiting);
  if (!listener) return std::unexpected(listener.error());
  return std::unique_ptr<LocalServer>(
      new LocalServer(std::make_unique<Implementation>(std::move(*listener), api)));
}

const std::string& LocalServer::path() const {
  return implementation_->path();
}

void LocalServer::run(const std::function<bool()>& stop) {
  implementation_->run(stop);
}

}  // namespace sinew::server
