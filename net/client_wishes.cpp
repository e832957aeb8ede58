#include <algorithm>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <cmath>

#include "net/client_state.hpp"

/// What is sent while a stream plays: what the player asked for and the server does not know yet, and pings.
namespace mien::net {

namespace {

std::uint64_t microseconds(double seconds) {
    const double us = std::ceil(std::clamp(seconds, 0.0, 1e9) * 1e6 - 1e-3);  // never before what was meant
    return std::uint64_t(us);
}
std::uint32_t thousandths(double rate) {
    return std::uint32_t(std::lround(std::clamp(rate, 0.0, protocol::kMaxRate / 1000.0) * 1000));
}

}  // namespace

void Client::State::begin_play(Connection& c) {
    {
        const std::lock_guard lock(mutex);
        sent = wish;
        if (last_group) sent.seek = last_start;
    }
    if (~sent.slots != 0) c.send(protocol::Select{sent.slots});
    c.send(protocol::Play{sent.generation, microseconds(sent.seek), thousandths(sent.rate)});
    if (sent.paused) c.send(protocol::Pause{true});
    c.streaming = true;
    part_due = false;
    if (refining && blobs.contains(refining->hash)) refining.reset();   // another player has put it into the cache meanwhile
    if (refining) refining->resumed = !refining->message.empty();
    ask_for_part(c);
}

void Client::State::send_wishes(Connection& c) {
    Wish now;
    {
        const std::lock_guard lock(mutex);
        now = wish;
    }
    if (now.rate != sent.rate) c.send(protocol::SetRate{thousandths(now.rate)});
    if (now.slots != sent.slots) c.send(protocol::Select{now.slots});
    if (now.generation != sent.generation) c.send(protocol::Seek{now.generation, microseconds(now.seek)});
    if (now.paused != sent.paused) c.send(protocol::Pause{now.paused});
    sent = now;
}

asio::awaitable<void> Client::State::write(ConnectionPtr c) {
    Clock::time_point next_ping = Clock::now() + options.ping_interval;
    while (!c->closed) {
        if (c->streaming) send_wishes(*c);
        if (!c->outgoing.empty()) {
            const Bytes message = std::move(c->outgoing.front());
            c->outgoing.pop_front();
            const auto done = co_await c->wire.write(message);
            if (!done) c->close(done.error().message);
            continue;
        }
        if (c->leaving) {
            c->close("closed by the player");
            co_return;
        }
        if (Clock::now() >= next_ping) {
            next_ping = Clock::now() + options.ping_interval;
            c->send(protocol::Ping{clock_us()});
            continue;
        }
        std::error_code rung;
        c->bell.expires_at(next_ping);
        co_await c->bell.async_wait(asio::redirect_error(asio::use_awaitable, rung));
    }
}

}  // namespace mien::net
