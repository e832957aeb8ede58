#include "player/stream_model.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "decoder/model_decoder.hpp"

namespace mien::player {
namespace {

using protocol::TrackKind;

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

std::uint64_t bit(std::uint8_t slot) { return std::uint64_t(1) << slot; }

constexpr double kFirstPart = 0.6;   // of what the line took of the model: what a stream begins with may fill of it

/// Rungs of a texture track that stand alone.
std::size_t rung_count(const protocol::Track& track) {
    return std::size_t(std::ranges::count_if(track.rungs, [](const protocol::Rung& rung) { return !rung.refines; }));
}

std::size_t first_rung(const protocol::Track& track, const TextureChoice& choice, double other_bits, std::optional<double> line) {
    const std::size_t count = rung_count(track);
    std::size_t wanted = protocol::kFinestRung;
    if (choice.rung) wanted = *choice.rung;
    else if (choice.kbps) wanted = protocol::texture_rung_within(track, *choice.kbps * 1000);
    else if (choice.automatic) wanted = line ? protocol::texture_rung_within(track, kFirstPart * *line - other_bits) : (count - 1) / 2;
    return std::min(wanted, count - 1);
}

/// Bits per second of the slots in `slots`, as far as the header tells.
double bits_of(const protocol::StreamHeader& header, std::uint64_t slots) {
    double bits = 0;
    for (const protocol::Track& track : header.tracks)
        for (const protocol::Rung& rung : track.rungs)
            if (slots & bit(rung.slot)) bits += rung.bits_per_second;
    return bits;
}

Result<model::FaceModel> decode_face(const net::StreamSource& source, bool refining, std::unique_ptr<decoder::DetailDecoder>& growing) {
    const Hash& manifest = source.header().model;
    auto face = decoder::decode_model(manifest, [&](const Hash& hash) { return source.blob(hash); }, &growing);
    if (face.ok() || !refining) return face;
    const auto& blobs = source.catalogue().blobs;
    const auto unrefined = [&](const Hash& hash) -> const Bytes* {
        const auto info = std::ranges::find(blobs, hash, &protocol::BlobInfo::hash);
        return info != blobs.end() && info->kind == protocol::BlobKind::refinement ? nullptr : source.blob(hash);
    };
    auto coarse = decoder::decode_model(manifest, unrefined, &growing);
    return coarse.ok() ? std::move(coarse) : std::move(face);
}

}  // namespace

FirstChoice first_choice(const protocol::StreamHeader& header, bool live, bool with_sound, std::size_t motion_rungs, const TextureChoice& texture,
                         std::optional<double> line) {
    FirstChoice choice;
    if (const auto* track = first_track(header, TrackKind::motion)) {
        const auto ladder = protocol::rung_ladder(*track);
        for (std::size_t r = 0; r < ladder.size() && r < (live ? 1 : motion_rungs); ++r) choice.slots |= bit(ladder[r]->slot);
    }
    if (const auto* track = with_sound ? first_track(header, TrackKind::sound) : nullptr) {
        choice.sound_slot = base_rung(*track).slot;
        choice.slots |= bit(*choice.sound_slot);
    }
    if (live) return choice;
    if (const auto* track = first_track(header, TrackKind::texture)) {
        choice.texture_rung = first_rung(*track, texture, bits_of(header, choice.slots), line);
        choice.slots |= bit(protocol::texture_rung(*track, choice.texture_rung).slot);
    }
    return choice;
}

std::uint64_t StreamModel::slots(std::size_t texture_rung) const {
    std::uint64_t bits = 0;
    for (const std::uint8_t slot : motion_slots) bits |= bit(slot);
    if (!texture_rungs.empty()) bits |= bit(texture_rungs[texture_rung].slot);
    if (sound) bits |= bit(sound_slot);
    return bits;
}

std::optional<std::size_t> StreamModel::texture_rung_of(std::uint8_t slot) const {
    const auto found = std::ranges::find(texture_rungs, slot, &TextureRung::slot);
    if (found == texture_rungs.end()) return std::nullopt;
    return std::size_t(found - texture_rungs.begin());
}

Result<void> StreamModel::use_texture_rung(std::size_t rung) {
    if (texture && rung == texture_in_use) return {};
    MIEN_TRY(decoder, decoder::TextureDecoder::create(texture_track, protocol::texture_rung(texture_track, rung)));
    texture.emplace(std::move(decoder));
    texture_in_use = rung;
    return {};
}

Result<StreamModel> open_stream_model(const net::StreamSource& source, bool with_sound, std::size_t motion_rungs,
                                      const TextureChoice& choice, bool refining) {
    const protocol::StreamHeader& header = source.header();
    std::unique_ptr<decoder::DetailDecoder> growing;
    MIEN_TRY(face, decode_face(source, refining, growing));

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

    StreamModel stream{.model = std::move(face), .composed = {}, .motion = std::move(motion), .texture = {}, .sound = {}, .motion_slots = std::move(motion_slots)};
    stream.growing = std::move(growing);
    stream.composed = model::compose(stream.model, stream.motion.basis());
    stream.frame_rate = header.frame_rate;
    stream.frames = std::int64_t(header.frames);
    stream.live = source.live();
    if (const auto* track = stream.live ? nullptr : first_track(header, protocol::TrackKind::texture)) {
        stream.texture_track = *track;
        for (std::size_t r = 0; r < rung_count(*track); ++r) {
            const protocol::Rung& rung = protocol::texture_rung(*track, r);
            const protocol::Rung::Size size = protocol::texture_size(*track, rung);
            stream.texture_rungs.push_back({rung.slot, int(size.width), int(size.height), double(rung.bits_per_second)});
        }
        stream.first_texture_rung = first_rung(*track, choice, 0, {});
        MIEN_CHECK(stream.use_texture_rung(stream.first_texture_rung));
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
    if (const auto* track = with_sound ? first_track(header, protocol::TrackKind::sound) : nullptr) {
        MIEN_TRY(sound, decoder::SoundDecoder::create(*track, base_rung(*track)));
        stream.sound.emplace(std::move(sound));
        stream.sound_slot = base_rung(*track).slot;
        stream.sample_rate = int(std::get<protocol::SoundInfo>(track->info).sample_rate);
        stream.channels = std::get<protocol::SoundInfo>(track->info).channels;
        stream.samples = std::int64_t(std::get<protocol::SoundInfo>(track->info).samples);
    }
    std::uint64_t others = stream.slots();
    if (!stream.texture_rungs.empty()) others &= ~bit(stream.texture_rungs[stream.first_texture_rung].slot);
    stream.other_bits_per_second = bits_of(header, others);
    return stream;
}

}  // namespace mien::player
