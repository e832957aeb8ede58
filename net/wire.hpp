#pragma once

#include <asio/awaitable.hpp>
#include <asio/ip/tcp.hpp>
#include <chrono>
#include <functional>

#include "core/result.hpp"
#include "protocol/messages.hpp"

/// A TCP socket as a sequence of messages. Internal to this room.
namespace mien::net {

using Clock = std::chrono::steady_clock;

/// The clock of PING and PONG, microseconds.
inline std::uint64_t clock_us() {
    return std::uint64_t(std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count());
}

/// A message as it came, not yet parsed.
struct RawMessage {
    std::uint8_t type = 0;
    Bytes body;
    std::uint64_t wire_bytes = 0;   ///< with type and length
};

/// One reader and one writer may use it at a time. Failed calls return `unavailable` when the connection is gone.
class Wire {
public:
    explicit Wire(asio::ip::tcp::socket socket) : socket_(std::move(socket)) {}

    asio::ip::tcp::socket& socket() { return socket_; }

    /// The next message; its body may have up to `limit` bytes. Memory grows with what arrives, not with what is announced.
    asio::awaitable<Result<RawMessage>> read(std::uint64_t limit);
    /// Reads and forgets until the other side closes.
    asio::awaitable<void> drain();
    asio::awaitable<Result<void>> write(ByteView message);

    /// No byte is sent after this; what was sent still arrives.
    void finish_sending();
    void close();

    Clock::time_point last_heard() const { return heard_; }        ///< the last byte read
    void hear() { heard_ = Clock::now(); }
    std::function<void(std::size_t bytes)> on_bytes;               ///< called for all that is read, as it comes
    /// How long the write under way has made no progress; zero when none is.
    Clock::duration stalled() const { return writing_ ? Clock::now() - progress_ : Clock::duration::zero(); }

private:
    void hear(std::size_t bytes) {
        hear();
        if (on_bytes) on_bytes(bytes);
    }

    asio::ip::tcp::socket socket_;
    Bytes buffer_;                  ///< read and not yet taken: buffer_[at_ ..]
    std::size_t at_ = 0;
    Clock::time_point heard_ = Clock::now();
    Clock::time_point progress_ = heard_;
    bool writing_ = false;
};

}  // namespace mien::net
