#pragma once

#include <asio/awaitable.hpp>
#include <asio/steady_timer.hpp>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "net/url.hpp"
#include "net/wire.hpp"

/// One connection to a server, as a client has it. Internal to this room.
namespace mien::net {

/// Why a connection ended, and whether another one could do better.
struct Lost {
    std::string reason;
    bool for_good = false;
    bool no_such_stream = false;   ///< nobody has it now; a live one may come back
};

/// One connection: the socket, what waits to be sent on it, and its timers.
struct Connection {
    explicit Connection(asio::ip::tcp::socket socket)
        : wire(std::move(socket)), bell(wire.socket().get_executor()), guard(wire.socket().get_executor()) {}

    void close(const std::string& why) {
        if (closed) return;
        closed = true;
        reason = why;
        wire.close();
        bell.cancel();
        guard.cancel();
    }
    void send(const protocol::Message& message) {
        outgoing.push_back(protocol::encode(message));
        bell.cancel();
    }

    Wire wire;
    asio::steady_timer bell;       ///< wakes the writer
    asio::steady_timer guard;      ///< the watchdog's
    std::deque<Bytes> outgoing;
    bool closed = false;
    bool leaving = false;          ///< closes when all is sent
    bool streaming = false;        ///< PLAY has been sent: play, pause, ... may follow
    bool holding = false;          ///< the queue is full and nothing is read on purpose
    std::string reason;
};
using ConnectionPtr = std::shared_ptr<Connection>;

/// Resolves the host and connects; what went wrong, if anything did.
asio::awaitable<std::optional<Lost>> connect(ConnectionPtr c, const Url& url);

/// Of the first thing a server says, which is its HELLO: what is wrong with it, if anything. Who speaks otherwise, or hangs up, is no mien server.
std::optional<Lost> not_a_server(const Connection& c, const Url& url, const Result<protocol::Message>& hello);

/// What the server said instead of what we expected: its own words when it refused.
Lost unexpected(const protocol::Message& message, std::string_view expected);

}  // namespace mien::net
