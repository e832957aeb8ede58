#pragma once

#include <cstring>
#include <random>
#include <string_view>

#include "protocol/stream_file.hpp"

/// A small stream with motion, texture and sound, and files in memory.
namespace mien::protocol::sample {

inline Bytes bytes_of(std::string_view text) {
    const auto view = std::as_bytes(std::span(text));
    return {view.begin(), view.end()};
}
inline Bytes literal(std::initializer_list<int> values) {
    Bytes bytes;
    for (const int v : values) bytes.push_back(static_cast<std::byte>(v));
    return bytes;
}
inline Bytes noise(std::size_t size, std::uint32_t seed) {
    std::mt19937 random(seed);
    Bytes bytes(size);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random());
    return bytes;
}
inline StaticBlob make_blob(BlobKind kind, Bytes bytes) { return {sha256(bytes), kind, std::move(bytes)}; }

struct Stream {
    StreamHeader header;
    std::vector<StaticBlob> blobs;
    std::vector<Group> groups;   ///< in file order
};

/// `seconds` groups of one second at 30 frames/s: a motion object a group, a texture object a frame, 50 sound packets.
/// `texture_bytes`: of each texture object.
inline Stream make_stream(int seconds, std::size_t texture_bytes = 40, std::uint32_t seed = 1) {
    Stream stream;
    const StaticBlob shape = make_blob(BlobKind::shape, noise(60, seed));
    const StaticBlob triangles = make_blob(BlobKind::connectivity, Bytes(300, std::byte{7}));
    const StaticBlob basis = make_blob(BlobKind::motion_basis, noise(90, seed + 1));
    const Manifest manifest{"ada", {{LayerKind::shape, {shape.hash, triangles.hash}}, {LayerKind::vertex_basis, {}}}};
    const StaticBlob first = make_blob(BlobKind::manifest, encode_manifest(manifest));
    stream.blobs = {first, shape, triangles, basis};

    StreamHeader& header = stream.header;
    header.name = "sample";
    header.frames = std::uint64_t(seconds) * 30;
    header.model = first.hash;
    header.tracks.push_back({TrackKind::motion, "face", {1, 30}, MotionInfo{MotionKind::vertices, 5, true, false, false},
                             {{.slot = 0, .codec = "motion", .bits_per_second = 9000, .basis = basis.hash}}});
    header.tracks.push_back({TrackKind::texture, "skin", {1, 30}, TextureInfo{64, 32, YuvView::Matrix::bt709, false},
                             {{.slot = 1, .codec = "h264", .priority = 1, .codec_config = bytes_of("avcC")}}});
    header.tracks.push_back({TrackKind::sound, "voice", {1, 48000}, SoundInfo{48000, 1, 3840, 960, std::uint64_t(seconds) * 48000},
                             {{.slot = 2, .codec = "opus", .codec_config = bytes_of("OpusHead")}}});
    std::mt19937 random(seed);
    for (int g = 0; g < seconds; ++g) {
        const auto number = static_cast<std::uint32_t>(g);
        stream.groups.push_back({0, number, g * 30, {{30, noise(200 + random() % 40, random())}}});
        Group texture{1, number, g * 30, {}};
        for (int f = 0; f < 30; ++f)
            texture.objects.push_back({1, noise(texture_bytes * (f == 0 ? 4 : 1) + random() % 9, random())});
        stream.groups.push_back(texture);
        Group sound{2, number, g * 48000 - (g ? 3840 : 0), {}};
        for (int p = 0; p < 50; ++p) sound.objects.push_back({1, noise(90 + random() % 30, random())});
        stream.groups.push_back(sound);
    }
    return stream;
}

/// A stream of a few hundred bytes that still has every part.
inline Stream make_tiny_stream() {
    Stream stream = make_stream(2);
    for (Group& group : stream.groups) {
        if (group.slot != 0) group.objects.resize(3);
        for (Object& object : group.objects) object.bytes.resize(9);
    }
    return stream;
}

inline Bytes file_of(const Stream& stream) {
    Bytes file;
    StreamFileWriter writer([&](ByteView bytes) { file.insert(file.end(), bytes.begin(), bytes.end()); }, stream.header,
                            stream.blobs);
    for (const Group& group : stream.groups) writer.add(group);
    writer.finish();
    return file;
}

/// Reads a file in memory, which must outlive the reader.
inline Result<StreamFileReader> open_bytes(const Bytes& file) {
    return StreamFileReader::open(
        [&file](std::uint64_t offset, std::span<std::byte> into) -> Result<std::size_t> {
            const std::size_t size = offset < file.size() ? std::min<std::size_t>(into.size(), file.size() - offset) : 0;
            if (size) std::memcpy(into.data(), file.data() + offset, size);
            return size;
        },
        file.size());
}

inline bool same(const Group& a, const Group& b) {
    return a.slot == b.slot && a.group == b.group && a.first_time == b.first_time &&
           std::ranges::equal(a.objects, b.objects,
                              [](const Object& x, const Object& y) { return x.frames == y.frames && x.bytes == y.bytes; });
}

}  // namespace mien::protocol::sample
