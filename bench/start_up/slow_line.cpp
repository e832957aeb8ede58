#include "bench/start_up/slow_line.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

#include "core/environment_error.hpp"

using namespace mien;

namespace {

using Clock = std::chrono::steady_clock;
constexpr int kBuffer = 8 << 10;   // bytes in the kernel on either side: on a slow line what waits there is seconds
constexpr std::size_t kPiece = 1400;

sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

int small_socket() {
    const int s = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (s < 0) throw EnvironmentError("no socket is to be had");
    ::setsockopt(s, SOL_SOCKET, SO_RCVBUF, &kBuffer, sizeof kBuffer);
    ::setsockopt(s, SOL_SOCKET, SO_SNDBUF, &kBuffer, sizeof kBuffer);
    return s;
}

}  // namespace

SlowLine::SlowLine(std::uint16_t server, double bits_per_second) : server_(server), rate_(bits_per_second), listener_(small_socket()) {
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), size) != 0 || ::listen(listener_, 8) != 0) throw EnvironmentError("no port is to be had");
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    accepting_ = std::thread([this] { accept(); });
}

SlowLine::~SlowLine() {
    stop_ = true;
    accepting_.join();
    for (const int socket : sockets_) ::shutdown(socket, SHUT_RDWR);
    for (std::thread& thread : passing_) thread.join();
    for (const int socket : sockets_) ::close(socket);
    ::close(listener_);
}

void SlowLine::accept() {
    while (!stop_) {
        pollfd waiting{listener_, POLLIN, 0};
        if (::poll(&waiting, 1, 20) <= 0) continue;
        const int viewer = ::accept(listener_, nullptr, nullptr), server = small_socket();
        const sockaddr_in address = loopback(server_);
        sockets_.insert(sockets_.end(), {viewer, server});
        if (::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) ::shutdown(viewer, SHUT_RDWR);
        passing_.emplace_back([this, viewer, server] { pass(viewer, server, 0); });
        passing_.emplace_back([this, viewer, server] { pass(server, viewer, rate_); });
    }
}

void SlowLine::pass(int from, int to, double bits_per_second) {
    Clock::time_point free = Clock::now();   // when the line has taken what was sent before
    char piece[kPiece];
    for (ssize_t got; (got = ::recv(from, piece, sizeof piece, 0)) > 0;) {
        if (bits_per_second > 0) {
            free = std::max(free, Clock::now()) + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(8 * double(got) / bits_per_second));
            std::this_thread::sleep_until(free);
        }
        for (ssize_t sent = 0; sent < got;) {
            const ssize_t now = ::send(to, piece + sent, std::size_t(got - sent), MSG_NOSIGNAL);
            if (now <= 0) break;
            sent += now;
        }
    }
    ::shutdown(from, SHUT_RDWR);
    ::shutdown(to, SHUT_RDWR);
}
