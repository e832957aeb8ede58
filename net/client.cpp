#include "net/client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <asio/co_spawn.hpp>
#include <asio/connect.hpp>
#include <asio/detached.hpp>
#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "net/wire.hpp"

namespace mien::net {

using asio::ip::tcp;
using protocol::FailureCode;

namespace {

constexpr auto kGoodbye = std::chrono::milliseconds(300);  // for BYE to leave when the player closes

std::uint64_t microseconds(double seconds) {
    const double us = std::ceil(std::clamp(seconds, 0.0, 1e9) * 1e6 - 1e-3);  // never before what was meant
    return std::uint64_t(us);
}
std::uint32_t thousandths(double rate) {
    return std::uint32_t(std::lround(std::clamp(rate, 0.0, protocol::kMaxRate / 1000.0) * 1000));
}
std::uint64_t clock_us() {
    return std::uint64_t(std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch()).count());
}

/// Why a connection ended, and whether another one could do better.
struct Lost {
    std::string reason;
    bool for_good = false;
};

/// One connection: the socket, what waits to be sent on it, and its timers.
struct Connection {
    explicit Connection(tcp::socket socket)
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

}  // namespace

struct Client::State {
    State(Url u, SourceOptions o) : url(std::move(u)), options(std::move(o)), space(io), pause_timer(io) {}

    const Url url;
    const SourceOptions options;
    asio::io_context io{1};
    asio::steady_timer space;        ///< wakes the reader when the queue has room
    asio::steady_timer pause_timer;  ///< back-off, and waiting for a seek after the end
    std::thread thread;

    // On the io thread only.
    ConnectionPtr connection;
    bool stopping = false;
    bool connected_once = false;
    bool waiting_for_seek = false;   ///< the stream has ended and so has the connection
    int attempts = 0;                ///< failed ones in a row
    std::mt19937 random{std::random_device{}()};
    Bytes identity;                  ///< HEADER and CATALOGUE as bytes: after a reconnect they must be the same
    std::optional<std::uint32_t> serving;  ///< generation that the server now answers

    /// What the player asked for; `sent` fields follow it on the io thread.
    struct Wish {
        std::uint32_t generation = 0;
        double seek = 0;             ///< seconds, of this generation
        double rate = 1;
        bool paused = false;
        std::uint64_t slots = ~std::uint64_t(0);
    };
    Wish sent;

    mutable std::mutex mutex;        ///< of everything below
    std::condition_variable changed;
    Wish wish;
    SourceStatus status;
    SourceStatistics statistics;
    bool ready = false;
    protocol::StreamHeader header;
    protocol::Catalogue catalogue;
    std::map<Hash, Bytes> blobs;
    struct Waiting {
        Arrival arrival;
        std::uint64_t bytes = 0;     ///< of its message
    };
    std::deque<Waiting> queue;
    std::uint64_t queued = 0;        ///< sum of their bytes
    bool end_queued = false;
    // How far this generation has come: what a reconnect goes on from, and what must not come twice.
    std::optional<std::uint32_t> last_group;
    std::uint64_t last_slots = 0;    ///< of last_group
    double last_start = 0;           ///< seconds

    asio::awaitable<void> run();
    asio::awaitable<Lost> connect_and_play();
    asio::awaitable<std::optional<Lost>> handshake(ConnectionPtr c);
    asio::awaitable<std::optional<Lost>> fetch_blobs(ConnectionPtr c);
    asio::awaitable<Lost> receive(ConnectionPtr c);
    asio::awaitable<void> write(ConnectionPtr c);
    asio::awaitable<void> watch(ConnectionPtr c);
    asio::awaitable<Result<RawMessage>> read_raw(ConnectionPtr c);
    asio::awaitable<Result<protocol::Message>> read(ConnectionPtr c);
    void note_pong(const protocol::Message& message);
    void begin_play(Connection& c);
    void send_wishes(Connection& c);
    void take_group(protocol::Group group, std::uint64_t bytes);
    void set_status(SourceState state, std::string reason = {});
    void stop();
    template <class Change>
    void tell(Change change);

    Lost lost(const Connection& c, const Error& why) const { return {c.closed ? c.reason : why.message, false}; }
    bool ended() const {
        const std::lock_guard lock(mutex);
        return end_queued;
    }
    double start_of(const protocol::Group& group) const;
    bool visual(std::uint8_t slot) const;
};

namespace {

Lost refused(const protocol::Failure& failure) {
    const bool may_pass =
        failure.code == FailureCode::busy || failure.code == FailureCode::shutting_down || failure.code == FailureCode::timeout;
    return {"the server says: " + failure.text, !may_pass};
}

/// What the server said instead of what we expected.
Lost unexpected(const protocol::Message& message, std::string_view expected) {
    if (const auto* failure = std::get_if<protocol::Failure>(&message)) return refused(*failure);
    if (std::holds_alternative<protocol::Bye>(message)) return {"the server stopped", false};
    return {fmt::format("the server did not send {}", expected), true};
}

}  // namespace

// ---- the life of a client ----

asio::awaitable<void> Client::State::run() {
    for (;;) {
        const Lost why = co_await connect_and_play();
        if (connection) connection->close(why.reason);
        connection.reset();
        serving.reset();
        if (stopping) {
            io.stop();
            co_return;
        }
        ++attempts;
        const int most = connected_once ? options.max_reconnects : options.max_attempts;
        if (why.for_good || (most >= 0 && attempts >= most)) {
            set_status(SourceState::failed, why.reason);
            co_return;
        }
        std::error_code ignored;
        if (ended()) {
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
        {
            const std::lock_guard lock(mutex);
            statistics.reconnects += connected_once;
        }
        set_status(connected_once ? SourceState::reconnecting : SourceState::connecting, why.reason);
        // Doubling, and half of it by chance, so that the viewers of a restarted server do not all come at once.
        const auto longest = std::min<double>(double(options.first_backoff.count()) * std::pow(2.0, std::min(attempts - 1, 20)),
                                              double(options.last_backoff.count()));
        std::uniform_real_distribution<double> jitter(0.5, 1.0);
        pause_timer.expires_after(std::chrono::microseconds(std::int64_t(longest * 1000 * jitter(random))));
        co_await pause_timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
        if (stopping) co_return;
    }
}

asio::awaitable<Lost> Client::State::connect_and_play() {
    connection = std::make_shared<Connection>(tcp::socket(io));
    const ConnectionPtr c = connection;
    asio::co_spawn(io, watch(c), asio::detached);

    std::error_code error;
    tcp::resolver resolver(io);
    const std::string port = std::to_string(url.port);
    const auto endpoints =
        co_await resolver.async_resolve(url.host, port, asio::redirect_error(asio::use_awaitable, error));
    if (c->closed) co_return Lost{c->reason, false};
    if (error) co_return Lost{fmt::format("the host {} is not known: {}", url.host, error.message()), false};
    co_await asio::async_connect(c->wire.socket(), endpoints, asio::redirect_error(asio::use_awaitable, error));
    if (c->closed) co_return Lost{c->reason, false};
    if (error) co_return Lost{fmt::format("cannot connect to {} port {}: {}", url.host, url.port, error.message()), false};
    c->wire.socket().set_option(tcp::no_delay(true), error);
    c->wire.hear();
    asio::co_spawn(io, write(c), asio::detached);

    if (const auto failed = co_await handshake(c)) co_return *failed;
    if (const auto failed = co_await fetch_blobs(c)) co_return *failed;
    connected_once = true;
    attempts = 0;
    {
        const std::lock_guard lock(mutex);
        ready = true;
    }
    begin_play(*c);
    set_status(SourceState::playing);
    co_return co_await receive(c);
}

asio::awaitable<Result<RawMessage>> Client::State::read_raw(ConnectionPtr c) {
    auto raw = co_await c->wire.read(protocol::kMaxMessageBytes);
    if (raw) {
        const std::lock_guard lock(mutex);
        statistics.bytes += raw->wire_bytes;
        if (raw->type == static_cast<std::uint8_t>(protocol::MessageType::blob)) statistics.blob_bytes += raw->wire_bytes;
    }
    co_return raw;
}

asio::awaitable<Result<protocol::Message>> Client::State::read(ConnectionPtr c) {
    const auto raw = co_await read_raw(c);
    if (!raw) co_return raw.error();
    auto message = protocol::parse_body(raw->type, raw->body);
    if (message) note_pong(*message);
    co_return message;
}

void Client::State::note_pong(const protocol::Message& message) {
    const auto* pong = std::get_if<protocol::Pong>(&message);
    if (!pong) return;
    const std::lock_guard lock(mutex);
    statistics.round_trip = double(clock_us() - pong->token) / 1e6;
}

asio::awaitable<std::optional<Lost>> Client::State::handshake(ConnectionPtr c) {
    c->send(protocol::Hello{protocol::kVersion, options.software});
    c->send(protocol::Open{url.name});
    auto hello = co_await read(c);
    // A server of another version, or no mien server at all, stays what it is however often we ask.
    if (!hello) co_return Lost{lost(*c, hello.error()).reason, hello.error().code != ErrorCode::unavailable};
    if (!std::holds_alternative<protocol::Hello>(*hello)) co_return unexpected(*hello, "HELLO");
    auto first = co_await read(c);
    if (!first) co_return Lost{lost(*c, first.error()).reason, first.error().code != ErrorCode::unavailable};
    if (!std::holds_alternative<protocol::StreamHeader>(*first)) co_return unexpected(*first, "HEADER");
    auto second = co_await read(c);
    if (!second) co_return Lost{lost(*c, second.error()).reason, second.error().code != ErrorCode::unavailable};
    if (!std::holds_alternative<protocol::Catalogue>(*second)) co_return unexpected(*second, "CATALOGUE");

    Bytes now = protocol::encode(*first);
    const Bytes rest = protocol::encode(*second);
    now.insert(now.end(), rest.begin(), rest.end());
    if (!identity.empty() && identity != now)
        co_return Lost{fmt::format("the stream '{}' has become another one on the server; open it again", url.name), true};
    if (identity.empty()) {
        identity = std::move(now);
        const std::lock_guard lock(mutex);
        header = std::get<protocol::StreamHeader>(std::move(*first));
        catalogue = std::get<protocol::Catalogue>(std::move(*second));
    }
    co_return std::nullopt;
}

asio::awaitable<std::optional<Lost>> Client::State::fetch_blobs(ConnectionPtr c) {
    protocol::Want missing;
    for (const protocol::BlobInfo& info : catalogue.blobs) {
        if (blobs.contains(info.hash)) continue;
        std::optional<Bytes> kept = options.cache ? options.cache->find(info.hash) : std::nullopt;
        if (!kept) {
            missing.hashes.push_back(info.hash);
            continue;
        }
        const std::lock_guard lock(mutex);
        blobs[info.hash] = std::move(*kept);
        ++statistics.blobs_from_cache;
    }
    if (missing.hashes.empty()) co_return std::nullopt;
    c->send(missing);
    for (std::size_t b = 0; b < missing.hashes.size();) {
        auto message = co_await read(c);
        if (!message) co_return Lost{lost(*c, message.error()).reason, message.error().code != ErrorCode::unavailable};
        if (std::holds_alternative<protocol::Pong>(*message)) continue;
        auto* blob = std::get_if<protocol::StaticBlob>(&*message);
        if (!blob || blob->hash != missing.hashes[b]) co_return unexpected(*message, "the static blob it was asked for");
        if (options.cache) options.cache->store(blob->hash, blob->bytes);
        const std::lock_guard lock(mutex);
        blobs[blob->hash] = std::move(blob->bytes);
        ++statistics.blobs_fetched;
        ++b;
    }
    co_return std::nullopt;
}

void Client::State::begin_play(Connection& c) {
    {
        const std::lock_guard lock(mutex);
        sent = wish;
        if (last_group) sent.seek = last_start;
    }
    c.send(protocol::Play{sent.generation, microseconds(sent.seek), thousandths(sent.rate)});
    if (sent.paused) c.send(protocol::Pause{true});
    if (~sent.slots != 0) c.send(protocol::Select{sent.slots});
    c.streaming = true;
}

asio::awaitable<Lost> Client::State::receive(ConnectionPtr c) {
    for (;;) {
        const auto raw = co_await read_raw(c);
        if (!raw) co_return lost(*c, raw.error());
        auto message = protocol::parse_body(raw->type, raw->body);
        if (!message) {
            // The bytes came over TCP, so the damage is in the stored file: the next group is sound again.
            if (raw->type != static_cast<std::uint8_t>(protocol::MessageType::group))
                co_return Lost{"the server sent nonsense: " + message.error().message, false};
            const std::lock_guard lock(mutex);
            ++statistics.damaged_groups;
        } else if (auto* group = std::get_if<protocol::Group>(&*message)) {
            take_group(std::move(*group), raw->wire_bytes);
        } else if (const auto* playing = std::get_if<protocol::Playing>(&*message)) {
            serving = playing->generation;
        } else if (std::holds_alternative<protocol::End>(*message)) {
            const std::lock_guard lock(mutex);
            if (serving == wish.generation && !end_queued) {
                end_queued = true;
                queue.push_back({{wish.generation, {}}, 0});
                changed.notify_all();
            }
        } else if (std::holds_alternative<protocol::Pong>(*message)) {
            note_pong(*message);
        } else {
            co_return unexpected(*message, "what belongs to a playing stream");
        }
        // A full queue is not read further: TCP then holds the server back, and our memory stays bounded.
        for (;;) {
            {
                const std::lock_guard lock(mutex);
                if (queued <= options.queue_bytes) break;
            }
            if (c->closed || stopping) co_return Lost{c->reason, false};
            c->holding = true;
            std::error_code ignored;
            space.expires_at(Clock::time_point::max());
            co_await space.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
            c->holding = false;
            c->wire.hear();
        }
    }
}

double Client::State::start_of(const protocol::Group& group) const {
    for (const protocol::Track& track : header.tracks)
        for (const protocol::Rung& rung : track.rungs)
            if (rung.slot == group.slot) return double(group.first_time) * track.time_base.value();
    return 0;
}

bool Client::State::visual(std::uint8_t slot) const {
    for (const protocol::Track& track : header.tracks)
        for (const protocol::Rung& rung : track.rungs)
            if (rung.slot == slot) return track.kind != protocol::TrackKind::sound;
    return false;
}

void Client::State::take_group(protocol::Group group, std::uint64_t bytes) {
    const std::lock_guard lock(mutex);
    if (serving != wish.generation) {
        ++statistics.stale_groups;
        return;
    }
    const std::uint64_t bit = std::uint64_t(1) << group.slot;
    if (last_group && (group.group < *last_group || (group.group == *last_group && (last_slots & bit)))) return;
    const double start = start_of(group);
    if (last_group != group.group) {
        last_group = group.group;
        last_slots = 0;
        last_start = start;
    }
    last_slots |= bit;
    // Sound brings its pre-roll and so starts earlier than its group.
    if (visual(group.slot)) last_start = std::max(last_start, start);
    queued += bytes;
    queue.push_back({{wish.generation, std::move(group)}, bytes});
    changed.notify_all();
}

// ---- sending ----

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

/// Changes the wishes under the lock and wakes the io thread to send them.
template <class Change>
void Client::State::tell(Change change) {
    {
        const std::lock_guard lock(mutex);
        change();
    }
    asio::post(io, [this] {
        if (connection) connection->bell.cancel();
        if (!stopping) space.cancel();
        if (waiting_for_seek) pause_timer.cancel();
    });
}

// ---- what the player calls ----

Client::Client(Url url, SourceOptions options) : state_(std::make_unique<State>(std::move(url), std::move(options))) {
    State& state = *state_;
    state.wish.seek = state.options.start;
    state.wish.rate = state.options.rate;
    asio::co_spawn(state.io, state.run(), asio::detached);
    state.thread = std::thread([&state] {
        try {
            state.io.run();
        } catch (const std::exception& e) {  // out of memory, for instance
            state.set_status(SourceState::failed, e.what());
        }
    });
}

Client::~Client() {
    State& state = *state_;
    asio::post(state.io, [&state] { state.stop(); });
    state.thread.join();
}

Result<void> Client::wait_ready(std::chrono::milliseconds timeout) {
    State& state = *state_;
    std::unique_lock lock(state.mutex);
    state.changed.wait_for(lock, timeout, [&] { return state.ready || state.status.state == SourceState::failed; });
    if (state.ready) return {};
    if (state.status.state == SourceState::failed) return Error{ErrorCode::unavailable, state.status.reason};
    return Error{ErrorCode::unavailable, state.status.reason.empty()
                                             ? fmt::format("{} did not answer in time", to_string(state.url))
                                             : state.status.reason};
}

const protocol::StreamHeader& Client::header() const { return state_->header; }
const protocol::Catalogue& Client::catalogue() const { return state_->catalogue; }

const Bytes* Client::blob(const Hash& hash) const {
    const std::lock_guard lock(state_->mutex);
    const auto found = state_->blobs.find(hash);
    return found == state_->blobs.end() ? nullptr : &found->second;
}

std::optional<Arrival> Client::next(std::chrono::milliseconds timeout) {
    State& state = *state_;
    std::optional<Arrival> arrival;
    {
        std::unique_lock lock(state.mutex);
        if (!state.changed.wait_for(lock, timeout, [&] { return !state.queue.empty(); })) return {};
        arrival = std::move(state.queue.front().arrival);
        state.queued -= state.queue.front().bytes;
        state.queue.pop_front();
        if (arrival->group) ++state.statistics.groups;
    }
    if (!arrival->group) state.set_status(SourceState::ended);
    asio::post(state.io, [&state] {
        if (!state.stopping) state.space.cancel();
    });
    return arrival;
}

std::uint32_t Client::seek(double seconds) {
    State& state = *state_;
    std::uint32_t generation = 0;
    bool again = false;
    state.tell([&] {
        generation = ++state.wish.generation;
        state.wish.seek = seconds;
        for (const State::Waiting& waiting : state.queue) state.statistics.stale_groups += waiting.arrival.group.has_value();
        state.queue.clear();
        state.queued = 0;
        state.end_queued = false;
        state.last_group.reset();
        again = state.status.state == SourceState::ended;
    });
    if (again) state.set_status(SourceState::playing);
    return generation;
}

void Client::pause(bool paused) {
    state_->tell([&] { state_->wish.paused = paused; });
}
void Client::set_rate(double rate) {
    state_->tell([&] { state_->wish.rate = rate; });
}
void Client::select(std::uint64_t slots) {
    state_->tell([&] { state_->wish.slots = slots; });
}

SourceStatus Client::status() const {
    const std::lock_guard lock(state_->mutex);
    return state_->status;
}

SourceStatistics Client::statistics() const {
    const std::lock_guard lock(state_->mutex);
    return state_->statistics;
}

// ---- what a server offers ----

namespace {

asio::awaitable<void> ask_for_list(Url url, std::shared_ptr<Connection> c, Result<std::vector<protocol::StreamEntry>>& answer) {
    const auto give_up = [&](const std::string& why) { answer = Error{ErrorCode::unavailable, why}; };
    std::error_code error;
    tcp::resolver resolver(c->wire.socket().get_executor());
    const std::string port = std::to_string(url.port);
    const auto endpoints =
        co_await resolver.async_resolve(url.host, port, asio::redirect_error(asio::use_awaitable, error));
    if (error) co_return give_up(fmt::format("the host {} is not known: {}", url.host, error.message()));
    co_await asio::async_connect(c->wire.socket(), endpoints, asio::redirect_error(asio::use_awaitable, error));
    if (error) co_return give_up(fmt::format("cannot connect to {} port {}: {}", url.host, url.port, error.message()));
    Bytes questions = protocol::encode(protocol::Hello{protocol::kVersion, "mien"});
    const Bytes list_please = protocol::encode(protocol::ListStreams{});
    questions.insert(questions.end(), list_please.begin(), list_please.end());
    const auto sent = co_await c->wire.write(questions);
    if (!sent) co_return give_up(sent.error().message);
    for (;;) {
        const auto raw = co_await c->wire.read(protocol::kMaxMessageBytes);
        if (!raw) co_return give_up(raw.error().message);
        auto message = protocol::parse_body(raw->type, raw->body);
        if (!message) co_return give_up(message.error().message);
        if (std::holds_alternative<protocol::Hello>(*message)) continue;
        if (auto* list = std::get_if<protocol::StreamList>(&*message)) {
            answer = std::move(list->streams);
            co_return;
        }
        co_return give_up(unexpected(*message, "its list of streams").reason);
    }
}

}  // namespace

Result<std::vector<protocol::StreamEntry>> list_streams(const Url& url, std::chrono::milliseconds timeout) {
    Result<std::vector<protocol::StreamEntry>> answer =
        Error{ErrorCode::unavailable, fmt::format("{} did not answer in time", to_string(url))};
    asio::io_context io(1);
    const auto c = std::make_shared<Connection>(tcp::socket(io));
    asio::co_spawn(io, ask_for_list(url, c, answer), asio::detached);
    io.run_for(timeout);
    return answer;
}

}  // namespace mien::net
