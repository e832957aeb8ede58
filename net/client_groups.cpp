#include <algorithm>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>

#include "net/client_state.hpp"

/// What a playing stream brings: groups are queued for next(), each once, and bounded.
namespace mien::net {

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

}  // namespace mien::net
