#include "player/stream_model.hpp"

#include <fmt/format.h>

#include "decoder/model_decoder.hpp"

namespace mien::player {
namespace {

const protocol::Track* first_track(const protocol::StreamHeader& header, protocol::TrackKind kind) {
    for (const protocol::Track& track : header.tracks)
        if (track.kind == kind && !track.rungs.empty()) return &track;
    return nullptr;
}

/// The first rung that stands alone; every track has one.
const protocol::Rung& base_rung(const protocol::Track& track) {
    for (const protocol::Rung& rung : track.rungs)
        if (!rung.refines) return rung;
    return track.rungs.front();
}

}  // namespace

std::uint64_t StreamModel::slots() const {
    std::uint64_t bits = 0;
    for (const std::uint8_t slot : motion_slots) bits |= std::uint64_t(1) << slot;
    if (texture) bits |= std::uint64_t(1) << texture_slot;
    if (sound) bits |= std::uint64_t(1) << sound_slot;
    return bits;
}

Result<StreamModel> open_stream_model(const net::StreamSource& source, bool with_sound, std::size_t motion_rungs,
                                      const TextureChoice& choice) {
    const protocol::StreamHeader& header = source.header();
    const auto find = [&](const Hash& hash) { return source.blob(hash); };
    MIEN_TRY(face, decoder::decode_model(header.model, find));

    const protocol::Track* motion_track = first_track(header, protocol::TrackKind::motion);
    if (!motion_track) return Error{ErrorCode::missing, "the stream has no motion track"};
    const auto& info = std::get<protocol::MotionInfo>(motion_track->info);
    if (!decoder::fits(face, info))
        return Error{ErrorCode::mismatch, "the stream's motion does not fit its face model"};
    std::vector<ByteView> bases;
    std::vector<std::uint8_t> motion_slots;
    for (const protocol::Rung* rung : protocol::rung_ladder(*motion_track)) {
        if (bases.size() == (source.live() ? 1 : motion_rungs)) break;
        const Bytes* basis = rung->basis ? source.blob(*rung->basis) : nullptr;
        if (!basis) return Error{ErrorCode::missing, "the stream brings no motion basis"};
        bases.push_back(*basis);
        motion_slots.push_back(rung->slot);
    }
    MIEN_TRY(motion, decoder::MotionDecoder::create(info, bases, face.neutral.triangles, face.neutral.mirror));

    StreamModel stream{std::move(face), {}, std::move(motion), {}, {}, std::move(motion_slots)};
    stream.composed = model::compose(stream.model, stream.motion.basis());
    stream.frame_rate = header.frame_rate;
    stream.frames = std::int64_t(header.frames);
    stream.live = source.live();
    if (const auto* track = stream.live ? nullptr : first_track(header, protocol::TrackKind::texture)) {
        const std::size_t wanted = choice.rung   ? *choice.rung
                                   : choice.kbps ? protocol::texture_rung_within(*track, *choice.kbps * 1000)
                                                 : protocol::kFinestRung;
        const protocol::Rung& rung = protocol::texture_rung(*track, wanted);
        MIEN_TRY(texture, decoder::TextureDecoder::create(*track, rung));
        const protocol::Rung::Size size = protocol::texture_size(*track, rung);
        stream.texture.emplace(std::move(texture));
        stream.texture_slot = rung.slot;
        stream.texture_width = int(size.width);
        stream.texture_height = int(size.height);
    } else {
        for (const protocol::BlobInfo& blob : source.catalogue().blobs) {
            if (blob.kind != protocol::BlobKind::texture) continue;
            const Bytes* bytes = source.blob(blob.hash);
            if (!bytes) return Error{ErrorCode::missing, "the model's texture did not come"};
            MIEN_TRY(picture, decoder::decode_picture(*bytes));
            stream.model.static_albedo = std::move(picture);
            break;
        }
    }
    if (const auto* track = with_sound && !stream.live ? first_track(header, protocol::TrackKind::sound) : nullptr) {
        MIEN_TRY(sound, decoder::SoundDecoder::create(*track, base_rung(*track)));
        stream.sound.emplace(std::move(sound));
        stream.sound_slot = base_rung(*track).slot;
        stream.sample_rate = int(std::get<protocol::SoundInfo>(track->info).sample_rate);
    }
    return stream;
}

}  // namespace mien::player
