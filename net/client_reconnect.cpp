#include <fmt/format.h>

#include <algorithm>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <cmath>

#include "net/client_state.hpp"

/// The life of a client: one connection after another, with back-off between them, until it is stopped or it is no use.
namespace mien::net {

namespace {

constexpr auto kGoodbye = std::chrono::milliseconds(300);  // for BYE to leave when the player closes

}  // namespace

asio::awaitable<void> Client::State::run() {
    for (;;) {
        const Lost why = co_await connect_and_play();
        if (stopping && connection && connection->leaving && !connection->closed) co_return;   // BYE is under way; stop() gives it a while
        if (connection) connection->close(why.reason);
        connection.reset();
        serving.reset();
        if (stopping) {
            io.stop();
            co_return;
        }
        ++attempts;
        const int most = connected_once ? options.max_reconnects : options.max_attempts;
        // A live stream that has been there comes back with its server, and after that with its publisher.
        const bool live = connected_once && header.frames == 0;
        if ((why.for_good && !(live && why.no_such_stream)) || (most >= 0 && attempts >= most)) {
            const bool gave_up = !why.for_good && attempts > 1;
            set_status(SourceState::failed, gave_up ? fmt::format("gave up on {} after {} tries: {}", to_string(url), attempts, why.reason) : why.reason);
            co_return;
        }
        std::error_code ignored;
        if (ended() && !live && !missing_refinement()) {
            // Nothing is missing: a new connection is only worth it when somebody seeks.
            waiting_for_seek = true;
            while (ended() && !stopping) {
                pause_timer.expires_at(Clock::time_point::max());
                co_await pause_timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
            }
            waiting_for_seek = false;
            if (stopping) co_return;
            continue;
        }
        // Of a recording that is over only refinements are missing, and nobody waits for them.
        if (live || !over()) set_status(connected_once ? SourceState::reconnecting : SourceState::connecting, why.reason);
        // Doubling, and half of it by chance, so that the viewers of a restarted server do not all come at once.
        const auto longest = std::min<double>(double(options.first_backoff.count()) * std::pow(2.0, std::min(attempts - 1, 20)),
                                              double(options.last_backoff.count()));
        std::uniform_real_distribution<double> jitter(0.5, 1.0);
        pause_timer.expires_after(std::chrono::microseconds(std::int64_t(longest * 1000 * jitter(random))));
        co_await pause_timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
        if (stopping) co_return;
    }
}

asio::awaitable<void> Client::State::watch(ConnectionPtr c) {
    const auto begun = Clock::now();
    const auto step = std::clamp(std::min(options.silence_timeout, options.connect_timeout) / 4, std::chrono::milliseconds(5),
                                 std::chrono::milliseconds(500));
    while (!c->closed) {
        std::error_code ignored;
        c->guard.expires_after(step);
        co_await c->guard.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
        if (c->closed) co_return;
        const auto now = Clock::now();
        if (!c->wire.socket().is_open() || !c->streaming) {
            // Until the blobs have come: connecting and the first answers have one limit, the blobs as long as they flow.
            if (now - std::max(begun, c->wire.last_heard()) > options.connect_timeout) c->close("the server does not answer");
        } else if (!c->holding && now - c->wire.last_heard() > options.silence_timeout) {
            c->close("nothing was heard of the server for too long");
        }
    }
}

void Client::State::set_status(SourceState state, std::string reason) {
    SourceStatus now;
    {
        const std::lock_guard lock(mutex);
        status = {state, std::move(reason)};
        now = status;
    }
    changed.notify_all();
    if (options.on_status) options.on_status(now);
}

void Client::State::stop() {
    stopping = true;
    pause_timer.cancel();
    space.cancel();
    if (!connection || !connection->streaming) {
        io.stop();
        return;
    }
    connection->outgoing.clear();
    connection->send(protocol::Bye{});
    connection->leaving = true;
    // With the server's bytes unread the queue may hold the reader up; the writer does not wait for it.
    pause_timer.expires_after(kGoodbye);
    pause_timer.async_wait([this](const std::error_code&) { io.stop(); });
}

}  // namespace mien::net
