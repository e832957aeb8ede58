#include "vectors.hpp"

namespace mien::vectors {

using namespace protocol;
using namespace protocol::sample;

namespace {

std::size_t objects_of(const Stream& stream) {
    std::size_t objects = 0;
    for (const Group& group : stream.groups) objects += group.objects.size();
    return objects;
}

/// Offset of the n-th message of a type.
std::size_t offset_of(const Bytes& file, MessageType type, int n = 0) {
    std::size_t at = 0;
    for (;;) {
        const auto head = parse_head(ByteView(file).subspan(at));
        if (head->type == static_cast<std::uint8_t>(type) && n-- == 0) return at;
        at += head->total();
    }
}

Bytes cut(const Bytes& file, std::size_t size) { return {file.begin(), file.begin() + std::ptrdiff_t(size)}; }
Bytes flip(Bytes file, std::size_t at) {
    file[at] ^= std::byte{0x10};
    return file;
}

/// The same stream with blobs that do not pack: zstd promises what it decodes, not what it writes, so that no vector that is
/// made again byte for byte may hold its output.
Stream raw(Stream stream) {
    stream.blobs[2] = make_blob(BlobKind::connectivity, noise(80, 11));
    const Manifest manifest{"ada", {{LayerKind::shape, {stream.blobs[1].hash, stream.blobs[2].hash}}, {LayerKind::vertex_basis, {}}}};
    stream.blobs[0] = make_blob(BlobKind::manifest, encode_manifest(manifest));
    stream.header.model = stream.blobs[0].hash;
    return stream;
}

/// Sound alone, with objects that hold different numbers of packets and a group of none.
Stream make_sound_stream() {
    Stream stream = raw(make_stream(1));
    stream.header.tracks = {stream.header.tracks[2]};
    stream.header.name = "sound";
    stream.groups = {{2, 0, 0, {{2, noise(10, 1)}, {1, noise(3, 2)}, {5, {}}}}, {2, 1, 48000, {}}, {2, 2, 96000, {{4, noise(7, 3)}}}};
    return stream;
}

/// Two rungs of motion, the second refining the first, at a rate that is no whole number, in metres.
Stream make_rungs_stream() {
    Stream stream = raw(make_tiny_stream());
    StreamHeader& header = stream.header;
    header.name = "rungs \xc3\xa9";
    header.frame_rate = {30000, 1001};
    header.unit = Unit::m;
    header.tracks.resize(1);
    header.tracks[0].time_base = {1001, 30000};
    header.tracks[0].rungs.push_back({.slot = 63, .refines = 0, .codec = "motion", .bits_per_second = 400000, .priority = 255});
    stream.groups = {{0, 0, 0, {{30, noise(20, 4)}}},
                     {63, 0, 0, {{10, noise(30, 5)}, {10, noise(400, 6)}, {10, noise(1, 7)}}},
                     {0, 1, 30, {{30, noise(21, 8)}}},
                     {63, 1, 30, {{15, noise(130, 9)}, {15, noise(2, 10)}}}};
    return stream;
}

/// A viewer's whole conversation, both directions after each other: one message of each kind.
Bytes make_conversation() {
    const Stream stream = raw(make_tiny_stream());
    Bytes all;
    const auto say = [&](const Message& message) {
        const Bytes bytes = encode(message);
        all.insert(all.end(), bytes.begin(), bytes.end());
    };
    say(Hello{kWireVersion, "mien-play"});
    say(ListStreams{});
    say(Open{"sample"});
    say(Want{{stream.blobs[0].hash, stream.blobs[2].hash}});
    say(Play{1, 1500000, 1000});
    say(Ping{123456789});
    say(Pause{true});
    say(Seek{2, 0});
    say(SetRate{0});
    say(Select{0b011});
    say(Pause{false});
    say(Bye{});
    say(Hello{kWireVersion, "mien-serve"});
    say(StreamList{{{"sample", {30, 1}, 60, false}, {"studio", {60000, 1001}, 0, true}}});
    say(stream.header);
    say(Catalogue{{{stream.blobs[0].hash, stream.blobs[0].kind, stream.blobs[0].bytes.size()}}});
    say(stream.blobs[0]);
    say(Playing{1, 1});
    say(stream.groups[3]);
    say(Pong{123456789, 42});
    say(End{60});
    say(GroupStart{1, 9, 270, 1});
    say(LiveBytes{1, noise(17, 12)});
    say(LiveBytes{63, {}});
    say(Failure{FailureCode::shutting_down, "good night"});
    say(Publish{"studio"});
    say(Publishing{10, 300});
    say(WantPart{stream.blobs[0].hash, 20, 30});
    say(BlobPart{120, noise(30, 13)});
    return all;
}

}  // namespace

std::vector<Vector> make_vectors() {
    const Stream packed = make_tiny_stream(), tiny = raw(packed), sound = make_sound_stream(), rungs = make_rungs_stream();
    const Bytes good = file_of(tiny);
    const std::size_t all = objects_of(tiny);
    const std::size_t first = offset_of(good, MessageType::group), index = offset_of(good, MessageType::index);
    Bytes older = good;
    older[parse_head(good)->size + 4] = std::byte{1};
    Bytes foreign = good;
    foreign[parse_head(good)->size] = std::byte{'l'};
    // Group 1 of slot 1 is the fifth; cut inside its second object.
    const std::size_t fifth = offset_of(good, MessageType::group, 4), sixth = offset_of(good, MessageType::group, 5);
    return {
        {.file = "sample.mien", .bytes = good, .shows = "motion, texture and sound; two groups", .objects = all, .stream = tiny},
        {.file = "packed.mien", .bytes = file_of(packed), .shows = "the same with a zstd blob; only read, since another zstd may write other bytes", .made_again = false, .objects = all, .stream = packed},
        {.file = "sound.mien", .bytes = file_of(sound), .shows = "sound alone; objects of different frame counts; an empty group", .objects = 4, .stream = sound},
        {.file = "rungs.mien", .bytes = file_of(rungs), .shows = "a rung that refines another; 30000/1001; slot 63; long and short objects", .objects = objects_of(rungs), .stream = rungs},
        {.file = "no_index.mien", .bytes = cut(good, offset_of(good, MessageType::end)), .shows = "ends behind the last group", .complete = false, .objects = all},
        {.file = "cut_group.mien", .bytes = cut(good, sixth - 12), .shows = "ends inside the second object of group 1, slot 1", .complete = false, .objects = 1 + 3 + 3 + 1 + 1},
        {.file = "bad_index.mien", .bytes = flip(good, index + 9), .shows = "a damaged index: it is rebuilt", .complete = false, .objects = all},
        {.file = "bad_trailer.mien", .bytes = flip(good, good.size() - 1), .shows = "a damaged trailer: the index is rebuilt", .complete = false, .objects = all},
        {.file = "bad_object.mien", .bytes = flip(good, fifth - 1), .shows = "a damaged object: its group is lost, nothing else", .objects = all - 1, .lost_groups = 1},
        {.file = "bad_length.mien", .bytes = flip(good, fifth + 1), .shows = "a damaged length of group 1, slot 1", .objects = all - 3, .lost_groups = 1},
        {.file = "bad_length_no_index.mien", .bytes = flip(cut(good, offset_of(good, MessageType::end)), fifth + 1), .shows = "the same in a file without index: the scan finds the next group", .complete = false, .objects = all - 3},
        {.file = "bad_header.mien", .bytes = flip(good, 20), .shows = "a damaged header", .refused = ErrorCode::damaged},
        {.file = "bad_catalogue.mien", .bytes = flip(good, offset_of(good, MessageType::catalogue) + 20), .shows = "a damaged catalogue", .refused = ErrorCode::damaged},
        {.file = "bad_manifest.mien", .bytes = flip(good, offset_of(good, MessageType::blob, 1) - 1), .shows = "a damaged model manifest", .refused = ErrorCode::damaged},
        {.file = "cut_blob.mien", .bytes = cut(good, first - 1), .shows = "ends inside the last static blob", .refused = ErrorCode::truncated},
        {.file = "version_1.mien", .bytes = older, .shows = "another version", .refused = ErrorCode::unsupported_version},
        {.file = "foreign.mien", .bytes = foreign, .shows = "not ours", .refused = ErrorCode::bad_magic},
        {.file = "conversation.wire", .bytes = make_conversation(), .shows = "one message of each kind that crosses the wire", .refused = ErrorCode::bad_magic},
    };
}

}  // namespace mien::vectors
