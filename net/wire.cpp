#include "net/wire.hpp"

#include <asio/buffer.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <cstring>

namespace mien::net {

namespace {

constexpr std::size_t kReadBytes = 64u << 10;    // a socket's usual receive buffer gives no more at once
constexpr std::size_t kGrowBytes = 1u << 20;     // a body grows by this as its bytes arrive
constexpr std::size_t kWriteBytes = 64u << 10;   // a write's progress is seen in steps of this

Error gone(const std::error_code& error) {
    if (error == asio::error::eof) return {ErrorCode::unavailable, "the other side closed the connection"};
    return {ErrorCode::unavailable, error.message()};
}

}  // namespace

asio::awaitable<Result<RawMessage>> Wire::read(std::uint64_t limit) {
    std::error_code error;
    protocol::MessageHead head;
    for (;;) {
        const auto parsed = protocol::parse_head(ByteView(buffer_).subspan(at_), limit);
        if (parsed) {
            head = *parsed;
            break;
        }
        if (parsed.error().code != ErrorCode::truncated) co_return parsed.error();
        buffer_.erase(buffer_.begin(), buffer_.begin() + std::ptrdiff_t(at_));
        at_ = 0;
        const std::size_t kept = buffer_.size();
        buffer_.resize(kept + kReadBytes);
        const std::size_t got = co_await socket_.async_read_some(asio::buffer(buffer_.data() + kept, kReadBytes),
                                                                 asio::redirect_error(asio::use_awaitable, error));
        buffer_.resize(kept + got);
        if (error) co_return gone(error);
        hear(got);
    }
    at_ += head.size;
    RawMessage message{head.type, {}, head.total()};
    const std::size_t ready = std::min<std::uint64_t>(head.body, buffer_.size() - at_);
    message.body.assign(buffer_.begin() + std::ptrdiff_t(at_), buffer_.begin() + std::ptrdiff_t(at_ + ready));
    at_ += ready;
    while (message.body.size() < head.body) {
        const std::size_t have = message.body.size();
        const std::size_t more = std::min<std::uint64_t>(head.body - have, kGrowBytes);
        message.body.resize(have + more);
        const std::size_t got = co_await socket_.async_read_some(asio::buffer(message.body.data() + have, more),
                                                                 asio::redirect_error(asio::use_awaitable, error));
        message.body.resize(have + got);
        if (error) co_return gone(error);
        hear(got);
    }
    co_return message;
}

asio::awaitable<void> Wire::drain() {
    std::error_code error;
    buffer_.resize(kReadBytes);
    at_ = kReadBytes;
    while (!error)
        co_await socket_.async_read_some(asio::buffer(buffer_), asio::redirect_error(asio::use_awaitable, error));
}

asio::awaitable<Result<void>> Wire::write(ByteView message) {
    std::error_code error;
    writing_ = true;
    progress_ = Clock::now();
    while (!message.empty()) {
        const std::size_t step = std::min(message.size(), kWriteBytes);
        const std::size_t sent = co_await socket_.async_write_some(asio::buffer(message.data(), step),
                                                                   asio::redirect_error(asio::use_awaitable, error));
        if (error) {
            writing_ = false;
            co_return gone(error);
        }
        message = message.subspan(sent);
        progress_ = Clock::now();
    }
    writing_ = false;
    co_return Result<void>();
}

void Wire::finish_sending() {
    std::error_code ignored;
    socket_.shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
}

void Wire::close() {
    std::error_code ignored;
    socket_.close(ignored);
}

}  // namespace mien::net
