#include "player/session.hpp"

#include <fmt/format.h>

#include <chrono>

#include "core/environment_error.hpp"
#include "net/blob_cache.hpp"
#include "net/url.hpp"

namespace mien::player {

void Session::collect(Statistics& statistics) const {
    statistics.source = source->statistics();
    statistics.dropped = decode->dropped();
    statistics.damaged_groups = decode->damaged_groups();
    statistics.damage = decode->damage().stretches();
    statistics.motion_bytes = motion_bytes();
    statistics.texture_bytes = texture_bytes();
    if (stream->sound) statistics.sound_bytes = decode->bytes_of(stream->sound_slot);
}

std::string Session::unrefined() const {
    const std::string undecoded = refiner ? refiner->trouble() : std::string();
    return undecoded.empty() ? source->statistics().unrefined : undecoded;
}

std::uint64_t Session::motion_bytes() const {
    std::uint64_t bytes = 0;
    for (const std::uint8_t slot : stream->motion_slots) bytes += decode->bytes_of(slot);
    return bytes;
}

std::uint64_t Session::texture_bytes() const {
    std::uint64_t bytes = 0;
    for (const StreamModel::TextureRung& rung : stream->texture_rungs) bytes += decode->bytes_of(rung.slot);
    return bytes;
}

namespace {

/// What was asked of the texture and is not to be had, one sentence; empty: it is.
std::string other_rung(const StreamModel& stream, const TextureChoice& asked) {
    const std::size_t rungs = stream.texture_rungs.size();
    if (!asked.rung && !asked.kbps) return {};
    if (rungs == 0) return "the stream has no rungs of texture to choose from";
    const StreamModel::TextureRung& rung = stream.texture_rungs[stream.first_texture_rung];
    if (asked.rung && *asked.rung >= rungs) return fmt::format("the stream has no rung {} of texture: its finest, {}, is played", *asked.rung, rungs - 1);
    if (asked.kbps && rung.bits_per_second > 1000 * *asked.kbps)
        return fmt::format("no rung of texture takes as little as {:g} kbit/s: the coarsest, of {:.0f}, is played", *asked.kbps, rung.bits_per_second / 1000);
    return {};
}

}  // namespace

Result<Session> open_session(const std::string& input, SessionOptions options) {
    using namespace std::chrono_literals;
    Session session;
    // A file gives what it has at once.
    session.start = options.source.start;
    session.networked = net::looks_like_url(input);
    session.adapts = options.texture.automatic && session.networked;
    if (!session.adapts) options.texture.automatic = false;
    // The source's thread chooses before anything is sent, and before wait_ready() lets us go on and go by it.
    const auto chosen = std::make_shared<std::optional<std::size_t>>();
    options.source.slots = [chosen, sound = options.sound, first = options.sound_first, motion_rungs = options.motion_rungs, texture = options.texture](
                               const protocol::StreamHeader& header, std::optional<double> line) {
        const bool live = header.frames == 0;
        const FirstChoice choice = first_choice(header, live, sound, motion_rungs, texture, line);
        *chosen = choice.texture_rung;
        return first && !live && choice.sound_slot ? std::uint64_t(1) << *choice.sound_slot : choice.slots;
    };
    MIEN_TRY(source, net::open_source(input, options.source));
    session.source = std::move(source);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.wait);
    for (;;) {
        auto ready = session.source->wait_ready(200ms);
        if (ready.ok()) break;
        const net::SourceStatus status = session.source->status();
        if (status.state == net::SourceState::failed || ready.error().code != ErrorCode::unavailable) return ready.error();
        if (options.give_up && options.give_up()) return Error{ErrorCode::unavailable, "stopped"};
        if (std::chrono::steady_clock::now() > deadline)
            return Error{ErrorCode::unavailable, fmt::format("{} did not answer within {:.0f} s{}{}", input, options.wait,
                                                             status.reason.empty() ? "" : ": ", status.reason)};
    }
    const TextureChoice asked = options.texture;
    if (*chosen) options.texture = {.rung = *chosen};
    MIEN_TRY(stream, open_stream_model(*session.source, options.sound, options.motion_rungs, options.texture, options.source.refine));
    session.stream = std::make_unique<StreamModel>(std::move(stream));
    if (options.source.refine && session.stream->growing)
        session.refiner = std::make_unique<Refiner>(*session.source, *session.stream, std::move(session.stream->growing));
    session.stream->growing.reset();
    const bool sound_only = options.sound_first && session.stream->sound && !session.stream->live;
    session.decode = std::make_unique<DecodeThread>(
        *session.source, *session.stream,
        options.sound_sink ? options.sound_sink(*session.stream) : DecodeThread::SoundSink{}, options.delay);
    session.decode->select(sound_only ? std::uint64_t(1) << session.stream->sound_slot : session.stream->slots());
    if (const std::string other = other_rung(*session.stream, asked); !other.empty()) fmt::print(stderr, "mien-play: {}\n", other);
    if (const std::string why = session.source->statistics().incomplete; !why.empty()) fmt::print(stderr, "mien-play: {}: {}\n", input, why);
    return session;
}

std::shared_ptr<net::BlobCache> open_cache(const Options& options) {
    if (!options.cache) return nullptr;
    try {
        return std::make_shared<net::DiskBlobCache>(*options.cache);
    } catch (const EnvironmentError& error) {
        fmt::print(stderr, "mien-play: {}; playing without a cache\n", error.what());
        return nullptr;
    }
}

}  // namespace mien::player
