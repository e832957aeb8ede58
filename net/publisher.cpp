#include "net/publisher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <cassert>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <random>
#include <set>
#include <thread>
#include <utility>

#include "net/connection.hpp"

namespace mien::net {

namespace {

constexpr auto kLastWords = std::chrono::seconds(1);   // for what is queued to leave at the end

}  // namespace

struct Publisher::State {
    State(Url u, protocol::StreamHeader h, std::vector<protocol::StaticBlob> b, PublisherOptions o)
        : url(std::move(u)), header(std::move(h)), blobs(std::move(b)), options(std::move(o)), pause(io) {}

    const Url url;
    const protocol::StreamHeader header;
    const std::vector<protocol::StaticBlob> blobs;
    const PublisherOptions options;
    asio::io_context io{1};
    asio::steady_timer pause;
    std::thread thread;

    // On the io thread only.
    ConnectionPtr connection;
    bool stopping = false;
    bool published_once = false;
    int attempts = 0;
    std::mt19937 random{std::random_device{}()};
    std::set<std::uint8_t> open;                     ///< slots whose group this connection knows
    std::optional<protocol::Publishing> answer;      ///< of this connection, until the first group
    std::uint32_t group_shift = 0;
    double time_shift = 0;                           ///< seconds
    std::size_t queued = 0;                          ///< bytes of connection->outgoing

    mutable std::mutex mutex;                        ///< of everything below
    std::condition_variable changed;
    SourceStatus status;
    PublisherStatistics statistics;
    bool ready = false;

    asio::awaitable<void> run();
    asio::awaitable<Lost> connect_and_publish();
    asio::awaitable<std::optional<Lost>> handshake(ConnectionPtr c);
    asio::awaitable<Lost> receive(ConnectionPtr c);
    asio::awaitable<void> write(ConnectionPtr c);
    asio::awaitable<void> watch(ConnectionPtr c);
    asio::awaitable<Result<protocol::Message>> read(ConnectionPtr c);
    void start_group(protocol::GroupStart start);
    void send(protocol::LiveBytes object);
    void push(const protocol::Message& message);
    double ticks_per_second(std::uint8_t slot) const;
    bool crowded() const { return queued > options.queue_bytes; }
    void set_status(SourceState state, std::string reason = {});
    void stop();
};

asio::awaitable<Result<protocol::Message>> Publisher::State::read(ConnectionPtr c) {
    for (;;) {
        const auto raw = co_await c->wire.read(protocol::kMaxControlBytes);
        if (!raw) co_return Error{raw.error().code, c->closed ? c->reason : raw.error().message};
        auto message = protocol::parse_body(raw->type, raw->body);
        if (message && std::holds_alternative<protocol::Pong>(*message)) continue;
        co_return message;
    }
}

asio::awaitable<void> Publisher::State::run() {
    for (;;) {
        const Lost why = co_await connect_and_publish();
        if (connection) connection->close(why.reason);
        connection.reset();
        open.clear();
        queued = 0;
        if (stopping) {
            io.stop();
            co_return;
        }
        ++attempts;
        // Before it has worked a person waits for an answer; after that viewers wait for us.
        if (!published_once || why.for_good || (options.max_reconnects >= 0 && attempts > options.max_reconnects)) {
            set_status(SourceState::failed, why.reason);
            co_return;
        }
        set_status(SourceState::reconnecting, why.reason);
        const auto longest = std::min<double>(double(options.first_backoff.count()) * std::pow(2.0, std::min(attempts - 1, 20)),
                                              double(options.last_backoff.count()));
        std::uniform_real_distribution<double> jitter(0.5, 1.0);
        std::error_code ignored;
        pause.expires_after(std::chrono::microseconds(std::int64_t(longest * 1000 * jitter(random))));
        co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
        if (stopping) {
            io.stop();
            co_return;
        }
    }
}

asio::awaitable<Lost> Publisher::State::connect_and_publish() {
    connection = std::make_shared<Connection>(asio::ip::tcp::socket(io));
    const ConnectionPtr c = connection;
    asio::co_spawn(io, watch(c), asio::detached);
    if (const auto failed = co_await connect(c, url)) co_return *failed;
    asio::co_spawn(io, write(c), asio::detached);
    if (const auto failed = co_await handshake(c)) co_return *failed;
    c->streaming = true;
    attempts = 0;
    {
        const std::lock_guard lock(mutex);
        ready = true;
        statistics.reconnects += std::exchange(published_once, true);
    }
    set_status(SourceState::playing);
    co_return co_await receive(c);
}

asio::awaitable<std::optional<Lost>> Publisher::State::handshake(ConnectionPtr c) {
    push(protocol::Hello{protocol::kWireVersion, options.software});
    push(protocol::Publish{url.name});
    push(header);
    protocol::Catalogue catalogue;
    for (const protocol::StaticBlob& blob : blobs) catalogue.blobs.push_back({blob.hash, blob.kind, blob.bytes.size()});
    push(catalogue);
    const auto foreign = [](const Error& error) { return Lost{error.message, error.code != ErrorCode::unavailable}; };
    auto hello = co_await read(c);
    if (const auto no_server = not_a_server(*c, url, hello)) co_return no_server;
    auto want = co_await read(c);
    if (!want) co_return foreign(want.error());
    if (!std::holds_alternative<protocol::Want>(*want)) co_return unexpected(*want, "what it wants");
    for (const Hash& hash : std::get<protocol::Want>(*want).hashes) {
        const auto blob = std::ranges::find(blobs, hash, &protocol::StaticBlob::hash);
        if (blob == blobs.end()) co_return Lost{"the server wants a static blob that this stream does not have", true};
        push(*blob);
    }
    auto taken = co_await read(c);
    if (!taken) co_return foreign(taken.error());
    if (!std::holds_alternative<protocol::Publishing>(*taken)) co_return unexpected(*taken, "PUBLISHING");
    answer = std::get<protocol::Publishing>(*taken);
    co_return std::nullopt;
}

asio::awaitable<Lost> Publisher::State::receive(ConnectionPtr c) {
    const auto message = co_await read(c);
    if (!message) co_return Lost{message.error().message, false};
    co_return unexpected(*message, "what a publisher expects");
}

asio::awaitable<void> Publisher::State::write(ConnectionPtr c) {
    Clock::time_point next_ping = Clock::now() + options.ping_interval;
    while (!c->closed) {
        if (!c->outgoing.empty()) {
            const Bytes message = std::move(c->outgoing.front());
            c->outgoing.pop_front();
            const auto done = co_await c->wire.write(message);
            if (!done) c->close(done.error().message);
            else if (c == connection) queued -= message.size();
            continue;
        }
        if (c->leaving) {
            c->close("the stream is over");
            co_return;
        }
        if (Clock::now() >= next_ping) {
            next_ping = Clock::now() + options.ping_interval;
            push(protocol::Ping{clock_us()});
            continue;
        }
        std::error_code rung;
        c->bell.expires_at(next_ping);
        co_await c->bell.async_wait(asio::redirect_error(asio::use_awaitable, rung));
    }
}

asio::awaitable<void> Publisher::State::watch(ConnectionPtr c) {
    const auto step = std::clamp(std::min(options.silence_timeout, options.connect_timeout) / 4, std::chrono::milliseconds(5),
                                 std::chrono::milliseconds(500));
    const auto begun = Clock::now();
    while (!c->closed) {
        std::error_code ignored;
        c->guard.expires_after(step);
        co_await c->guard.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
        if (c->closed) co_return;
        const auto longest = c->streaming ? options.silence_timeout : options.connect_timeout;
        // While blobs flow there is nothing to hear.
        const auto stalled = c->wire.stalled();
        const auto silent = Clock::now() - std::max(begun, c->wire.last_heard());
        if ((stalled > Clock::duration::zero() ? stalled : silent) > longest) c->close("the server does not answer");
    }
}

void Publisher::State::push(const protocol::Message& message) {
    Bytes bytes = protocol::encode(message);
    queued += bytes.size();
    connection->outgoing.push_back(std::move(bytes));
    connection->bell.cancel();
}

double Publisher::State::ticks_per_second(std::uint8_t slot) const {
    for (const protocol::Track& track : header.tracks)
        for (const protocol::Rung& rung : track.rungs)
            if (rung.slot == slot) return 1 / track.time_base.value();
    assert(false);
    return 1;
}

void Publisher::State::start_group(protocol::GroupStart start) {
    open.erase(start.slot);
    if (!connection || !connection->streaming || crowded()) return;
    if (answer) {
        group_shift = std::max(group_shift, answer->group > start.group ? answer->group - start.group : 0);
        const double before = double(answer->frames) / header.frame_rate.value();
        time_shift = std::max(time_shift, before - double(start.first_time) / ticks_per_second(start.slot));
        answer.reset();
    }
    open.insert(start.slot);
    start.group += group_shift;
    start.first_time += std::llround(time_shift * ticks_per_second(start.slot));
    push(start);
}

void Publisher::State::send(protocol::LiveBytes object) {
    const bool goes = open.contains(object.slot) && !crowded();
    if (!goes) open.erase(object.slot);
    if (goes) push(object);
    const std::lock_guard lock(mutex);
    goes ? ++statistics.objects : ++statistics.dropped;
    if (goes) statistics.bytes += connection->outgoing.back().size();
}

void Publisher::State::set_status(SourceState state, std::string reason) {
    SourceStatus now;
    {
        const std::lock_guard lock(mutex);
        status = {state, std::move(reason)};
        now = status;
    }
    changed.notify_all();
    if (options.on_status) options.on_status(now);
}

void Publisher::State::stop() {
    stopping = true;
    pause.cancel();
    if (!connection || !connection->streaming) {
        io.stop();
        return;
    }
    push(protocol::End{});
    push(protocol::Bye{});
    connection->leaving = true;
    connection->bell.cancel();
    pause.expires_after(kLastWords);
    pause.async_wait([this](const std::error_code&) { io.stop(); });
}

Publisher::Publisher(Url url, protocol::StreamHeader header, std::vector<protocol::StaticBlob> blobs, PublisherOptions options)
    : state_(std::make_unique<State>(std::move(url), std::move(header), std::move(blobs), std::move(options))) {
    State& state = *state_;
    assert(state.header.frames == 0);
    asio::co_spawn(state.io, state.run(), asio::detached);
    state.thread = std::thread([&state] {
        try {
            state.io.run();
        } catch (const std::exception& e) {
            state.set_status(SourceState::failed, e.what());
        }
    });
}

Publisher::~Publisher() {
    State& state = *state_;
    asio::post(state.io, [&state] { state.stop(); });
    state.thread.join();
}

Result<void> Publisher::wait_ready(std::chrono::milliseconds timeout) {
    State& state = *state_;
    std::unique_lock lock(state.mutex);
    state.changed.wait_for(lock, timeout, [&] { return state.ready || state.status.state == SourceState::failed; });
    if (state.ready) return {};
    if (state.status.state == SourceState::failed) return Error{ErrorCode::unavailable, state.status.reason};
    return Error{ErrorCode::unavailable, fmt::format("{} did not answer in time", to_string(state.url))};
}

void Publisher::start_group(const protocol::GroupStart& start) {
    asio::post(state_->io, [&state = *state_, start] { state.start_group(start); });
}

void Publisher::send(protocol::LiveBytes object) {
    asio::post(state_->io, [&state = *state_, object = std::move(object)]() mutable { state.send(std::move(object)); });
}

SourceStatus Publisher::status() const {
    const std::lock_guard lock(state_->mutex);
    return state_->status;
}

PublisherStatistics Publisher::statistics() const {
    const std::lock_guard lock(state_->mutex);
    return state_->statistics;
}

}  // namespace mien::net
