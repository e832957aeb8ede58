#include <fmt/format.h>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <cassert>
#include <utility>

#include "net/client_state.hpp"

/// From a socket to a stream that plays: HELLO and OPEN, HEADER and CATALOGUE, the static blobs that are not here yet.
namespace mien::net {

asio::awaitable<Lost> Client::State::connect_and_play() {
    connection = std::make_shared<Connection>(asio::ip::tcp::socket(io));
    const ConnectionPtr c = connection;
    asio::co_spawn(io, watch(c), asio::detached);

    if (const auto failed = co_await connect(c, url)) co_return *failed;
    c->wire.on_bytes = [this](std::size_t bytes) { note_bytes(bytes); };
    meter.interrupted();
    asio::co_spawn(io, write(c), asio::detached);

    if (const auto failed = co_await handshake(c)) co_return *failed;
    if (const auto failed = co_await fetch_blobs(c)) co_return *failed;
    if (!connected_once && options.slots) {
        const std::uint64_t slots = options.slots(header, statistics.line);
        const std::lock_guard lock(mutex);
        wish.slots = slots;
    }
    attempts = 0;
    {
        const std::lock_guard lock(mutex);
        ready = true;
        statistics.reconnects += std::exchange(connected_once, true);
    }
    begin_play(*c);
    if (!over()) set_status(SourceState::playing);
    co_return co_await receive(c);
}

asio::awaitable<std::optional<Lost>> Client::State::handshake(ConnectionPtr c) {
    c->send(protocol::Hello{protocol::kWireVersion, options.software});
    c->send(protocol::Open{url.name});
    auto hello = co_await read(c);
    if (const auto foreign = not_a_server(*c, url, hello)) co_return foreign;
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
        order = protocol::fetch_order(catalogue);
        statistics.model_size = protocol::total_bytes(catalogue);
    }
    co_return std::nullopt;
}

asio::awaitable<std::optional<Lost>> Client::State::fetch_blobs(ConnectionPtr c) {
    const std::size_t begins_with = order.within(options.start_bytes);
    protocol::Want missing;
    for (std::size_t b = 0; b < order.blobs.size(); ++b) {
        const Hash& hash = order.blobs[b].hash;
        if (blobs.contains(hash)) continue;
        if (std::optional<Bytes> kept = options.cache ? options.cache->find(hash) : std::nullopt) {
            keep(hash, std::move(*kept), &SourceStatistics::blobs_from_cache);
        } else if (b < begins_with) {
            missing.hashes.push_back(hash);
        }
    }
    if (missing.hashes.empty()) co_return std::nullopt;
    c->send(missing);
    for (std::size_t b = 0; b < missing.hashes.size();) {
        auto message = co_await read(c);
        if (!message) co_return Lost{lost(*c, message.error()).reason, message.error().code != ErrorCode::unavailable};
        if (std::holds_alternative<protocol::Pong>(*message)) continue;
        auto* blob = std::get_if<protocol::StaticBlob>(&*message);
        if (!blob || blob->hash != missing.hashes[b]) co_return unexpected(*message, "the static blob it was asked for");
        take_fetched(std::move(*blob));
        ++b;
    }
    co_return std::nullopt;
}

void Client::State::take_fetched(protocol::StaticBlob blob) {
    if (options.cache) options.cache->store(blob.hash, blob.bytes);
    keep(blob.hash, std::move(blob.bytes), &SourceStatistics::blobs_fetched);
}

void Client::State::keep(const Hash& hash, Bytes bytes, std::uint64_t SourceStatistics::* count) {
    const std::lock_guard lock(mutex);
    assert(!blobs.contains(hash));   // what blob() has given out stays as it is
    ++(statistics.*count);
    statistics.model_bytes += bytes.size();
    blobs[hash] = std::move(bytes);
    changed.notify_all();
}

}  // namespace mien::net
