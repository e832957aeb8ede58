#include "tools/udp_listener.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/environment_error.hpp"

namespace mien::tools {
namespace {

constexpr auto kSilence = std::chrono::seconds(2);   // after which another sender may take over
constexpr int kReceiveBuffer = 4 << 20;              // bytes: a second of many markers

}  // namespace

UdpListener::UdpListener(const std::string& bind, std::uint16_t port) : name_(fmt::format("UDP {} port {}", bind, port)) {
    sockaddr_in v4{};
    sockaddr_in6 v6{};
    v4.sin_family = AF_INET, v4.sin_port = htons(port);
    v6.sin6_family = AF_INET6, v6.sin6_port = htons(port);
    const bool is4 = ::inet_pton(AF_INET, bind.c_str(), &v4.sin_addr) == 1;
    if (!is4 && ::inet_pton(AF_INET6, bind.c_str(), &v6.sin6_addr) != 1) throw EnvironmentError(fmt::format("'{}' is not an IP address to listen on", bind));
    socket_ = ::socket(is4 ? AF_INET : AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const auto give_up = [&] {
        const int reason = errno;
        if (socket_ >= 0) ::close(socket_);
        throw EnvironmentError(fmt::format("cannot listen on {}: {}", name_, std::strerror(reason)));
    };
    if (socket_ < 0) give_up();
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
    const auto* address = is4 ? reinterpret_cast<const sockaddr*>(&v4) : reinterpret_cast<const sockaddr*>(&v6);
    if (::bind(socket_, address, is4 ? sizeof v4 : sizeof v6) != 0) give_up();
}

UdpListener::~UdpListener() { ::close(socket_); }

std::optional<ByteView> UdpListener::next(std::chrono::milliseconds longest) {
    pollfd waiting{socket_, POLLIN, 0};
    if (::poll(&waiting, 1, int(longest.count())) <= 0) return std::nullopt;
    last_.size = sizeof last_.address;
    const ssize_t got = ::recvfrom(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&last_.address), &last_.size);
    if (got < 0) return std::nullopt;
    return ByteView(buffer_).first(std::size_t(got));
}

bool UdpListener::welcome() const {
    const bool same = last_.size == heard_.size && std::memcmp(&last_.address, &heard_.address, last_.size) == 0;
    return same || heard_.size == 0 || Clock::now() - when_ >= kSilence;
}

void UdpListener::hear() {
    heard_ = last_;
    when_ = Clock::now();
}

}  // namespace mien::tools
