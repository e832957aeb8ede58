#include "harness.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace mien::net::harness {

namespace {

constexpr int kLineBuffer = 16 << 10;   // of a line that may become slow: what it holds is late

sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

/// receive_buffer: bytes; 0: the system's choice.
int connect_to(std::uint16_t port, int receive_buffer = 0) {
    const int s = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (receive_buffer) ::setsockopt(s, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    const sockaddr_in address = loopback(port);
    if (::connect(s, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return s;
    ::close(s);
    return -1;
}

bool send_all(int socket, ByteView bytes) {
    while (!bytes.empty()) {
        const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent <= 0) return false;
        bytes = bytes.subspan(std::size_t(sent));
    }
    return true;
}

/// A listening socket on a free port, which comes back in `port`.
int listen_on_any(std::uint16_t& port) {
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    ::bind(listener, reinterpret_cast<const sockaddr*>(&address), size);
    ::listen(listener, 16);
    ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    return listener;
}

}  // namespace

RawServer::RawServer() : listener_(listen_on_any(port_)) {}
RawServer::~RawServer() { ::close(listener_); }
RawSocket RawServer::accept() { return RawSocket(RawSocket::Accepted{::accept(listener_, nullptr, nullptr)}); }

RawSocket::RawSocket(std::uint16_t port) : RawSocket(Accepted{connect_to(port)}) {}
RawSocket::RawSocket(Accepted accepted) : socket_(accepted.socket) {
    const timeval patience{std::chrono::seconds(kPatience).count(), 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
}
RawSocket::~RawSocket() {
    if (socket_ >= 0) ::close(socket_);
}
bool RawSocket::send(ByteView bytes) { return send_all(socket_, bytes); }

std::optional<protocol::Message> RawSocket::receive() {
    for (;;) {
        const auto head = protocol::parse_head(buffer_);
        if (head && buffer_.size() >= head->total()) {
            auto message = protocol::parse_message(ByteView(buffer_).first(head->total()));
            buffer_.erase(buffer_.begin(), buffer_.begin() + std::ptrdiff_t(head->total()));
            EXPECT_TRUE(message.ok()) << message.error().message;
            if (!message) return {};
            return std::move(*message);
        }
        std::byte chunk[65536];
        const ssize_t got = ::recv(socket_, chunk, sizeof chunk, 0);
        if (got <= 0) return {};
        buffer_.insert(buffer_.end(), chunk, chunk + got);
    }
}

bool RawSocket::closed_by_peer() {
    std::byte chunk[65536];
    for (;;) {
        const ssize_t got = ::recv(socket_, chunk, sizeof chunk, 0);
        if (got > 0) continue;
        return got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK);
    }
}

void RawSocket::shrink_receive_buffer() {
    const int small = 4096;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
}

Proxy::Proxy(std::uint16_t target) : listener_(listen_on_any(port_)), target_(target) {
    acceptor_ = std::thread([this] { accept(); });
}

Proxy::~Proxy() {
    stop_ = true;
    acceptor_.join();
    cut();
    for (std::thread& thread : threads_) thread.join();
    for (const int socket : open_) ::close(socket);
    ::close(listener_);
}

void Proxy::cut() {
    const std::lock_guard lock(mutex_);
    for (const int socket : open_) ::shutdown(socket, SHUT_RDWR);
}

void Proxy::accept() {
    while (!stop_) {
        pollfd waiting{listener_, POLLIN, 0};
        if (::poll(&waiting, 1, 10) <= 0) continue;
        const int client = ::accept(listener_, nullptr, nullptr);
        if (client < 0) continue;
        const int server = refuse_ ? -1 : connect_to(target_, kLineBuffer);
        if (server < 0) {
            ::close(client);
            continue;
        }
        ++connections_;
        const std::lock_guard lock(mutex_);
        open_.push_back(client);
        open_.push_back(server);
        threads_.emplace_back([this, client, server] { pump(client, server, false); });
        threads_.emplace_back([this, client, server] { pump(server, client, true); });
    }
}

void Proxy::pump(int from, int to, bool from_server) {
    const std::uint64_t most = from_server ? cut_after_.load() : 0;
    std::uint64_t passed = 0;
    std::byte chunk[16384];
    while (!stop_) {
        pollfd waiting{from, POLLIN, 0};
        const std::uint64_t hold = from_server ? hold_after_.load() : 0;
        const std::uint64_t served = served_.load();
        if (frozen_ || (hold && served >= hold)) {
            std::this_thread::sleep_for(2ms);
            continue;
        }
        if (::poll(&waiting, 1, 10) <= 0) continue;
        const std::uint64_t rate = from_server ? throttle_.load() : 0;
        std::size_t room = rate ? std::clamp<std::size_t>(rate / 50, 1, sizeof chunk) : sizeof chunk;
        if (hold) room = std::size_t(std::min<std::uint64_t>(room, hold - served));
        ssize_t got = ::recv(from, chunk, room, 0);
        if (got <= 0) break;
        if (rate) std::this_thread::sleep_for(std::chrono::duration<double>(double(got) / double(rate)));
        if (most && passed + std::uint64_t(got) >= most) got = ssize_t(most - passed);
        if (from_server) served_ += std::uint64_t(got);   // before: who has received them finds them counted
        if (!send_all(to, ByteView(chunk, std::size_t(got)))) break;
        passed += std::uint64_t(got);
        if (most && passed >= most) break;
    }
    ::shutdown(from, SHUT_RDWR);
    ::shutdown(to, SHUT_RDWR);
}

}  // namespace mien::net::harness
