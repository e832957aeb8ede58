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
        const auto type = static_cast<protocol::MessageType>(raw->type);
        if (type == protocol::MessageType::blob || type == protocol::MessageType::blob_part) statistics.blob_bytes += raw->wire_bytes;
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

void Client::State::note_bytes(std::size_t bytes) {
    const double now = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
    meter.arrived(now, bytes);
    const std::lock_guard lock(mutex);
    statistics.line = meter.bits_per_second(now);
    line_at = now;
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
        if (part_due && raw->type == static_cast<std::uint8_t>(protocol::MessageType::blob_part)) {
            take_part(*c, std::move(message));
        } else if (!message) {
            // The bytes came over TCP, so the damage is in the stored file: the next group is sound again.
            if (raw->type != static_cast<std::uint8_t>(protocol::MessageType::group))
                co_return Lost{"the server sent nonsense: " + message.error().message, false};
            const std::lock_guard lock(mutex);
            ++statistics.damaged_groups;
        } else if (auto* group = std::get_if<protocol::Group>(&*message)) {
            take_group(std::move(*group), raw->wire_bytes);
        } else if (const auto* playing = std::get_if<protocol::Playing>(&*message)) {
            start_live(*playing);
        } else if (std::holds_alternative<protocol::End>(*message)) {
            const std::lock_guard lock(mutex);
            if (serving == wish.generation && !end_queued) {
                end_queued = true;
                queue.push_back({{wish.generation, {}}, 0});
                changed.notify_all();
            }
        } else if (const auto* start = std::get_if<protocol::GroupStart>(&*message)) {
            if (!take_live(*start)) co_return Lost{"the server sent an impossible group", true};
        } else if (auto* object = std::get_if<protocol::LiveBytes>(&*message)) {
            if (!take_live(std::move(*object), raw->wire_bytes)) co_return Lost{"the server sent an object without a group", true};
        } else if (std::holds_alternative<protocol::Pong>(*message)) {
            note_pong(*message);
        } else if (const auto* failure = std::get_if<protocol::Failure>(&*message);
                   failure && part_due && (failure->code == protocol::FailureCode::damaged || failure->code == protocol::FailureCode::no_such_blob)) {
            // The groups are as sound as before, but this connection is over.
            stop_refining("the server says: " + failure->text);
            co_return Lost{"the server says: " + failure->text, false};
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
            meter.interrupted();
            std::error_code ignored;
            space.expires_at(Clock::time_point::max());
            co_await space.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
            c->holding = false;
            c->wire.hear();
        }
    }
}

void Client::State::start_live(const protocol::Playing& playing) {
    serving = playing.generation;
    live_slots.clear();
    const std::lock_guard lock(mutex);
    if (playing.generation == wish.generation) end_queued = false;
    // One server never goes back: this one has been started since, and counts anew.
    if (std::ranges::any_of(had, [&](const auto& slot) { return playing.group < slot.second.group; })) had.clear();
}

bool Client::State::take_live(const protocol::GroupStart& start) {
    const auto before = live_slots.find(start.slot);
    if (before != live_slots.end() && start.group < before->second.group.group) return false;
    live_slots[start.slot] = {start, 0};
    return true;
}

bool Client::State::take_live(protocol::LiveBytes bytes, std::uint64_t wire_bytes) {
    const auto found = live_slots.find(bytes.slot);
    if (found == live_slots.end()) return false;
    LiveSlot& slot = found->second;
    const std::uint32_t index = slot.next++;
    std::int64_t ticks = slot.group.frames;
    for (const protocol::Track& track : header.tracks)
        if (const auto* sound = std::get_if<protocol::SoundInfo>(&track.info))
            for (const protocol::Rung& rung : track.rungs)
                if (rung.slot == bytes.slot) ticks *= sound->packet_samples;
    protocol::LiveObject object{.slot = bytes.slot, .group = slot.group.group, .first_time = slot.group.first_time + ticks * index, .index = index,
                                .object = {slot.group.frames, std::move(bytes.bytes)}};
    const Hash first = index == 0 ? sha256(object.object.bytes) : Hash{};
    const std::lock_guard lock(mutex);
    if (serving != wish.generation) {
        ++statistics.stale_groups;
        return true;
    }
    if (index == 0) {
        // The number of what we have, but another object: likewise.
        const auto before = had.find(object.slot);
        if (before != had.end() && before->second.group == object.group && before->second.first != first) had.clear();
        had[object.slot].first = first;
    }
    Had& next = had[object.slot];
    if (std::pair(object.group, object.index) < std::pair(next.group, next.index)) return true;
    next.group = object.group;
    next.index = object.index + 1;
    queued += wire_bytes;
    queue.push_back({{wish.generation, {}, std::move(object)}, wire_bytes});
    changed.notify_all();
    return true;
}

const protocol::Track* Client::State::track_of(std::uint8_t slot) const {
    for (const protocol::Track& track : header.tracks)
        for (const protocol::Rung& rung : track.rungs)
            if (rung.slot == slot) return &track;
    return nullptr;
}

void Client::State::take_group(protocol::Group group, std::uint64_t bytes) {
    const std::lock_guard lock(mutex);
    if (serving != wish.generation) {
        ++statistics.stale_groups;
        return;
    }
    const std::uint64_t bit = std::uint64_t(1) << group.slot;
    if (last_group && (group.group < *last_group || (group.group == *last_group && (last_slots & bit)))) return;
    const protocol::Track* track = track_of(group.slot);
    const double start = track ? double(group.first_time) * track->time_base.value() : 0;
    if (last_group != group.group) {
        last_group = group.group;
        last_slots = 0;
        last_start = start;
    }
    last_slots |= bit;
    // Sound brings its pre-roll and so starts earlier than its group.
    if (track && track->kind != protocol::TrackKind::sound) {
        last_start = std::max(last_start, start);
        std::uint64_t ticks = 0;
        for (const protocol::Object& object : group.objects) ticks += object.frames;
        const bool texture = track->kind == protocol::TrackKind::texture;
        (texture ? texture_until : motion_until) = start + double(ticks) * track->time_base.value();
        statistics.until = texture_until > 0 ? std::min(texture_until, motion_until) : motion_until;
    }
    queued += bytes;
    queue.push_back({{wish.generation, std::move(group)}, bytes});
    changed.notify_all();
}

}  // namespace mien::net
