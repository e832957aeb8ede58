#pragma once

#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "core/hash.hpp"

namespace mien::tools {

/// Hears one sender at a time: another one is heard when the first has been silent for two seconds.
class UdpListener {
public:
    /// Throws EnvironmentError: address or port not to be had.
    UdpListener(const std::string& bind, std::uint16_t port);
    ~UdpListener();
    UdpListener(const UdpListener&) = delete;
    UdpListener& operator=(const UdpListener&) = delete;

    /// Waits up to `longest` (and not longer than a signal lets it) for a packet, which stays until the next call.
    std::optional<ByteView> next(std::chrono::milliseconds longest);
    /// Whether the last packet comes from whom we hear, or nobody is heard.
    bool welcome() const;
    /// The last packet was what we wait for: its sender is heard from now on.
    void hear();

    const std::string& name() const { return name_; }   ///< "UDP 127.0.0.1 port 9000"

private:
    using Clock = std::chrono::steady_clock;
    struct Sender {
        sockaddr_storage address{};
        socklen_t size = 0;
    };

    std::string name_;
    int socket_ = -1;
    std::array<std::byte, 65536> buffer_;
    Sender last_, heard_;
    Clock::time_point when_;
};

}  // namespace mien::tools
