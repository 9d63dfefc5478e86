#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

namespace sinew::test {

/// A server on a port of its own of this computer, with a thread of its own. Clients are served one
/// after the other; each is closed where its script ends.
class TcpTestServer {
 public:
  class Client {
   public:
    Client(int descriptor, const std::stop_token& ending)
        : descriptor_(descriptor), ending_(ending) {}

    /// Whether all of it was taken, and the client is still there.
    bool send(std::string_view text) {
      while (!text.empty()) {
        pollfd waiting{descriptor_, POLLOUT, 0};
        if (ending_.stop_requested()) return false;
        if (::poll(&waiting, 1, 20) == 0) continue;
        const auto count = ::send(descriptor_, text.data(), text.size(), MSG_NOSIGNAL);
        if (count < 0) return false;
        text.remove_prefix(static_cast<std::size_t>(count));
      }
      return true;
    }
    /// Whether the client is still there after so long.
    bool stays(int milliseconds) {
      pollfd waiting{descriptor_, POLLRDHUP, 0};
      return ::poll(&waiting, 1, milliseconds) == 0 && !ending_.stop_requested();
    }
    /// What came, if anything does within so long.
    std::string receive(int milliseconds) {
      pollfd waiting{descriptor_, POLLIN, 0};
      if (::poll(&waiting, 1, milliseconds) <= 0) return {};
      std::array<char, 4096> buffer;
      const auto count = ::recv(descriptor_, buffer.data(), buffer.size(), 0);
      return count <= 0 ? std::string()
                        : std::string(buffer.data(), static_cast<std::size_t>(count));
    }
    /// Up to an empty line.
    std::string request() {
      std::string text;
      while (!text.contains("\r\n\r\n")) {
        pollfd waiting{descriptor_, POLLIN, 0};
        if (ending_.stop_requested()) break;
        if (::poll(&waiting, 1, 20) == 0) continue;
        std::array<char, 4096> buffer;
        const auto count = ::recv(descriptor_, buffer.data(), buffer.size(), 0);
        if (count <= 0) break;
        text.append(buffer.data(), static_cast<std::size_t>(count));
      }
      return text;
    }

   private:
    int descriptor_;
    std::stop_token ending_;
  };
  /// What to do with the client of this number, from 1 on.
  using Script = std::function<void(Client& client, int number)>;

  explicit TcpTestServer(Script script)
      : script_(std::move(script)), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* any = reinterpret_cast<sockaddr*>(&address);
    if (::bind(listener_, any, size) != 0 || ::listen(listener_, 8) != 0 ||
        ::getsockname(listener_, any, &size) != 0) {
      throw std::runtime_error("no server");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::jthread([this](const std::stop_token& ending) { serve(ending); });
  }
  ~TcpTestServer() { end(); }
  TcpTestServer(const TcpTestServer&) = delete;
  TcpTestServer& operator=(const TcpTestServer&) = delete;

  /// No server listens from then on.
  void end() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
    if (listener_ >= 0) ::close(listener_);
    listener_ = -1;
  }
  std::uint16_t port() const { return port_; }
  std::string address(const std::string& path = "/video", const std::string& user = "") const {
    return "http://" + user + "127.0.0.1:" + std::to_string(port_) + path;
  }
  int clients() const { return clients_; }

 private:
  void serve(const std::stop_token& ending) {
    while (!ending.stop_requested()) {
      pollfd waiting{listener_, POLLIN, 0};
      if (::poll(&waiting, 1, 20) == 0) continue;
      const int descriptor = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (descriptor < 0) continue;
      Client client(descriptor, ending);
      script_(client, ++clients_);
      ::close(descriptor);
    }
  }

  Script script_;
  int listener_;
  std::uint16_t port_ = 0;
  std::atomic<int> clients_ = 0;
  std::jthread thread_;
};

}  // namespace sinew::test
