#pragma once

#include <asio/io_context.hpp>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "net/client.hpp"
#include "net/connection.hpp"
#include "net/line_meter.hpp"
#include "protocol/fetch_order.hpp"

/// What a client is made of: its wishes, its connection, what has arrived. Internal to this room.
namespace mien::net {

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
    LineMeter meter;
    std::optional<std::uint32_t> serving;  ///< generation that the server now answers
    protocol::FetchOrder order;            ///< of the catalogue's blobs
    /// A refinement that comes in parts, so that no group waits for more than one of them; what has come of it outlives a connection.
    struct Refining {
        Hash hash;
        std::uint64_t total = 0;           ///< bytes of its BLOB message, once a part has come
        Bytes message;                     ///< the first of them
        bool resumed = false;              ///< they came over several connections
    };
    std::optional<Refining> refining;
    bool part_due = false;                 ///< a part of `refining` was asked for on this connection and has not come: never more than one

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
    mutable std::condition_variable changed;
    Wish wish;
    SourceStatus status;
    SourceStatistics statistics;
    double line_at = 0;              ///< steady seconds: when statistics.line was measured
    bool ready = false;
    protocol::StreamHeader header;
    protocol::Catalogue catalogue;
    std::map<Hash, Bytes> blobs;     ///< only the io thread adds to it, and none is taken away
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
    double motion_until = 0, texture_until = 0;   ///< seconds: ends of the newest groups
    /// A slot of a live stream: what the next LIVE OBJECT is, on this connection.
    struct LiveSlot {
        protocol::GroupStart group;
        std::uint32_t next = 0;
    };
    std::map<std::uint8_t, LiveSlot> live_slots;   ///< of this PLAYING
    /// Of a slot of a live stream, the next object that next() has not had: what comes again after a reconnect is dropped.
    struct Had {
        std::uint32_t group = 0, index = 0;
        Hash first;                  ///< of the group's object 0
    };
    std::map<std::uint8_t, Had> had;

    asio::awaitable<void> run();
    asio::awaitable<Lost> connect_and_play();
    asio::awaitable<std::optional<Lost>> handshake(ConnectionPtr c);
    asio::awaitable<std::optional<Lost>> fetch_blobs(ConnectionPtr c);
    void take_fetched(protocol::StaticBlob blob);
    void keep(const Hash& hash, Bytes bytes, std::uint64_t SourceStatistics::* count);
    const Hash* missing_refinement() const;   ///< the next one that is wanted; null: none
    void ask_for_part(Connection& c);
    void take_part(Connection& c, Result<protocol::Message> message);
    void refine_anew(Connection& c, std::string why);
    void stop_refining(std::string why);
    asio::awaitable<Lost> receive(ConnectionPtr c);
    asio::awaitable<void> write(ConnectionPtr c);
    asio::awaitable<void> watch(ConnectionPtr c);
    asio::awaitable<Result<RawMessage>> read_raw(ConnectionPtr c);
    asio::awaitable<Result<protocol::Message>> read(ConnectionPtr c);
    void note_bytes(std::size_t bytes);
    void note_pong(const protocol::Message& message);
    void begin_play(Connection& c);
    void send_wishes(Connection& c);
    void take_group(protocol::Group group, std::uint64_t bytes);
    void start_live(const protocol::Playing& playing);
    bool take_live(const protocol::GroupStart& start);
    bool take_live(protocol::LiveBytes object, std::uint64_t bytes);
    void set_status(SourceState state, std::string reason = {});
    void stop();
    template <class Change>
    void tell(Change change);

    Lost lost(const Connection& c, const Error& why) const { return {c.closed ? c.reason : why.message, false}; }
    bool ended() const {
        const std::lock_guard lock(mutex);
        return end_queued;
    }
    bool over() const {                  ///< and next() has said so
        const std::lock_guard lock(mutex);
        return status.state == SourceState::ended;
    }
    const protocol::Track* track_of(std::uint8_t slot) const;
};

}  // namespace mien::net
