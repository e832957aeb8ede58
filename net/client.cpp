#include "net/client.hpp"

#include <fmt/format.h>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/post.hpp>

#include "net/client_state.hpp"

namespace mien::net {

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

std::uint64_t Client::wait_model(std::uint64_t bytes, std::chrono::milliseconds timeout) const {
    std::unique_lock lock(state_->mutex);
    state_->changed.wait_for(lock, timeout, [&] { return state_->statistics.model_bytes > bytes; });
    return state_->statistics.model_bytes;
}

std::optional<Arrival> Client::next(std::chrono::milliseconds timeout) {
    State& state = *state_;
    std::optional<Arrival> arrival;
    bool resumed = false;
    {
        std::unique_lock lock(state.mutex);
        if (!state.changed.wait_for(lock, timeout, [&] { return !state.queue.empty(); })) return {};
        arrival = std::move(state.queue.front().arrival);
        state.queued -= state.queue.front().bytes;
        state.queue.pop_front();
        if (arrival->group) ++state.statistics.groups;
        if (arrival->object) ++state.statistics.objects;
        resumed = arrival->object && state.status.state == SourceState::ended;
    }
    if (arrival->is_end()) state.set_status(SourceState::ended);
    if (resumed) state.set_status(SourceState::playing);
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
        for (const State::Waiting& waiting : state.queue) state.statistics.stale_groups += !waiting.arrival.is_end();
        state.queue.clear();
        state.queued = 0;
        state.end_queued = false;
        state.last_group.reset();
        state.had.clear();
        state.motion_until = state.texture_until = state.statistics.until = 0;
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

bool Client::live() const { return state_->header.frames == 0; }

SourceStatus Client::status() const {
    const std::lock_guard lock(state_->mutex);
    return state_->status;
}

SourceStatistics Client::statistics() const {
    const double now = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
    const std::lock_guard lock(state_->mutex);
    SourceStatistics statistics = state_->statistics;
    if (now - state_->line_at > LineMeter::kWindow) statistics.line.reset();
    return statistics;
}

}  // namespace mien::net
