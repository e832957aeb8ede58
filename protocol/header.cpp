#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "protocol/bodies.hpp"

namespace mien::protocol {

namespace {

constexpr std::uint8_t kRefines = 1, kBasis = 2, kSize = 4;
constexpr std::uint8_t kPose = 1, kGaze = 2, kPresence = 4;

void write(ByteWriter& out, const MotionInfo& info) {
    out.u8(static_cast<std::uint8_t>(info.kind));
    out.varint(info.count);
    out.u8(static_cast<std::uint8_t>((info.has_pose ? kPose : 0) | (info.has_gaze ? kGaze : 0) |
                                     (info.has_presence ? kPresence : 0)));
}
void write(ByteWriter& out, const TextureInfo& info) {
    out.varint(info.width);
    out.varint(info.height);
    out.u8(static_cast<std::uint8_t>(info.matrix));
    out.u8(info.full_range);
}
void write(ByteWriter& out, const SoundInfo& info) {
    out.varint(info.sample_rate);
    out.u8(info.channels);
    out.varint(info.preroll);
    out.varint(info.packet_samples);
    out.varint(info.samples);
}
void write(ByteWriter& out, const Rung& rung) {
    out.u8(rung.slot);
    out.u8(static_cast<std::uint8_t>((rung.refines ? kRefines : 0) | (rung.basis ? kBasis : 0) |
                                     (rung.size ? kSize : 0)));
    if (rung.refines) out.u8(*rung.refines);
    if (rung.basis) out.hash(*rung.basis);
    if (rung.size) {
        out.varint(rung.size->width);
        out.varint(rung.size->height);
    }
    out.text(rung.codec);
    out.varint(rung.bits_per_second);
    out.u8(rung.priority);
    out.varint(rung.codec_config.size());
    out.bytes(rung.codec_config);
}

/// A varint of at most `limit`, as 32 bits.
std::uint32_t bounded(ByteReader& in, std::uint64_t limit) {
    const std::uint64_t value = in.varint();
    if (value > limit) in.fail();
    return in.ok() ? static_cast<std::uint32_t>(value) : 0;
}

Result<MotionInfo> read_motion(ByteReader& in) {
    MotionInfo info;
    const std::uint8_t kind = in.u8();
    if (in.ok() && (kind < 1 || kind > 3)) return damaged(fmt::format("motion of kind {} is unknown", kind));
    info.kind = static_cast<MotionKind>(kind);
    info.count = bounded(in, info.kind == MotionKind::vertices  ? kMaxVertices
                             : info.kind == MotionKind::markers ? kMaxMarkers
                                                                : kMaxWeights);
    const std::uint8_t flags = in.u8();
    if (flags > 7) return damaged(fmt::format("motion flags 0x{:02x} are unknown", flags));
    info.has_pose = flags & kPose;
    info.has_gaze = flags & kGaze;
    info.has_presence = flags & kPresence;
    return info;
}

Result<TextureInfo> read_texture(ByteReader& in) {
    TextureInfo info;
    info.width = bounded(in, kMaxTextureSide);
    info.height = bounded(in, kMaxTextureSide);
    const std::uint8_t matrix = in.u8(), range = in.u8();
    if (in.ok() && (info.width == 0 || info.height == 0)) return damaged("a texture without texels");
    if (matrix > 1 || range > 1) return damaged("a texture's matrix or range is unknown");
    info.matrix = static_cast<YuvView::Matrix>(matrix);
    info.full_range = range == 1;
    return info;
}

Result<SoundInfo> read_sound(ByteReader& in) {
    SoundInfo info;
    info.sample_rate = bounded(in, kMaxSampleRate);
    info.channels = in.u8();
    info.preroll = bounded(in, 0xffffffffu);
    info.packet_samples = bounded(in, 0xffffffffu);
    info.samples = in.varint();
    if (!in.ok()) return info;
    if (info.sample_rate == 0 || info.channels == 0 || info.channels > kMaxChannels || info.packet_samples == 0 ||
        info.samples > std::uint64_t(kMaxTicks))
        return damaged("sound with an impossible rate, channel count or length");
    return info;
}

Rung read_rung(ByteReader& in) {
    Rung rung;
    rung.slot = in.u8();
    const std::uint8_t flags = in.u8();
    if (flags > (kRefines | kBasis | kSize)) in.fail();
    if (flags & kRefines) rung.refines = in.u8();
    if (flags & kBasis) rung.basis = in.hash();
    if (flags & kSize) {
        const std::uint32_t width = bounded(in, kMaxTextureSide), height = bounded(in, kMaxTextureSide);
        if (width == 0 || height == 0) in.fail();
        rung.size = {width, height};
    }
    rung.codec = in.text(kMaxCodecName);
    rung.bits_per_second = bounded(in, 0xffffffffu);
    rung.priority = in.u8();
    const ByteView config = in.bytes(bounded(in, kMaxCodecConfig));
    rung.codec_config.assign(config.begin(), config.end());
    return rung;
}

Result<Track> read_track(ByteReader& in, std::uint64_t& slots) {
    Track track;
    const std::uint8_t kind = in.u8();
    if (in.ok() && (kind < 1 || kind > 3)) return damaged(fmt::format("a track of kind {} is unknown", kind));
    track.kind = static_cast<TrackKind>(kind);
    track.name = in.text(kMaxName);
    track.time_base = read_rational(in);
    if (in.ok()) {
        if (track.kind == TrackKind::motion) {
            MIEN_TRY(info, read_motion(in));
            track.info = info;
        } else if (track.kind == TrackKind::texture) {
            MIEN_TRY(info, read_texture(in));
            track.info = info;
        } else {
            MIEN_TRY(info, read_sound(in));
            track.info = info;
        }
    }
    const std::uint8_t rungs = in.u8();
    if (in.ok() && (rungs == 0 || rungs > kMaxSlots)) return damaged(fmt::format("a track with {} rungs", rungs));
    std::uint64_t own = 0;
    for (int r = 0; r < rungs && in.ok(); ++r) {
        Rung rung = read_rung(in);
        if (!in.ok()) break;
        if (rung.slot >= kMaxSlots || (slots >> rung.slot & 1))
            return damaged(fmt::format("slot {} is out of range or taken twice", rung.slot));
        // A rung refines one that the track named before it, so chains end.
        if (rung.refines && (*rung.refines >= kMaxSlots || !(own >> *rung.refines & 1)))
            return damaged(fmt::format("slot {} refines slot {}, which its track has not named", rung.slot, *rung.refines));
        if (rung.size && track.kind != TrackKind::texture)
            return damaged(fmt::format("slot {} is no texture but has a size in texels", rung.slot));
        own |= std::uint64_t(1) << rung.slot;
        slots |= std::uint64_t(1) << rung.slot;
        track.rungs.push_back(std::move(rung));
    }
    return track;
}

}  // namespace

void write_body(ByteWriter& out, const StreamHeader& header) {
    assert(header.tracks.size() <= kMaxTracks && header.name.size() <= kMaxName);
    out.bytes(std::as_bytes(std::span(kMagic)));
    out.varint(kVersion);
    ByteWriter rest;
    rest.text(header.name);
    write_rational(rest, header.frame_rate);
    rest.varint(header.frames);
    rest.varint(header.group_frames);
    rest.u8(static_cast<std::uint8_t>(header.unit));
    rest.hash(header.model);
    rest.u8(static_cast<std::uint8_t>(header.tracks.size()));
    for (const Track& track : header.tracks) {
        assert(!track.rungs.empty() && track.name.size() <= kMaxName);
        rest.u8(static_cast<std::uint8_t>(track.kind));
        rest.text(track.name);
        write_rational(rest, track.time_base);
        std::visit([&](const auto& info) { write(rest, info); }, track.info);
        rest.u8(static_cast<std::uint8_t>(track.rungs.size()));
        for (const Rung& rung : track.rungs) write(rest, rung);
    }
    write_checked(out, rest.view());
}

Result<StreamHeader> read_header(ByteView body) {
    ByteReader in(body);
    const ByteView magic = in.bytes(kMagic.size());
    if (!in.ok() || !std::ranges::equal(magic, std::as_bytes(std::span(kMagic))))
        return Error{ErrorCode::bad_magic, "this is not a mien stream"};
    const std::uint64_t version = in.varint();
    if (in.ok() && version != kVersion)
        return Error{ErrorCode::unsupported_version,
                     fmt::format("the stream has format version {}, this program reads version {}", version, kVersion)};
    if (!read_checked(in, body)) return damaged("its checksum does not match");

    StreamHeader header;
    header.name = in.text(kMaxName);
    header.frame_rate = read_rational(in);
    header.frames = in.varint();
    header.group_frames = bounded(in, 0xffffffffu);
    const std::uint8_t unit = in.u8();
    header.model = in.hash();
    const std::uint8_t tracks = in.u8();
    if (in.ok() && (unit > 2 || header.frames > std::uint64_t(kMaxTicks))) return damaged("its unit or length is impossible");
    if (in.ok() && tracks > kMaxTracks) return damaged(fmt::format("{} tracks", tracks));
    header.unit = static_cast<Unit>(unit);
    std::uint64_t slots = 0;
    for (int t = 0; t < tracks && in.ok(); ++t) {
        MIEN_TRY(track, read_track(in, slots));
        header.tracks.push_back(std::move(track));
    }
    MIEN_CHECK(check_end(in));
    return header;
}

}  // namespace mien::protocol
