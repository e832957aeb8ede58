#include "protocol/messages.hpp"

#include <gtest/gtest.h>

#include "sample_stream.hpp"

/// Every message against literal bytes, one comment per field. docs/format.md and docs/protocol.md describe the same.
namespace mien::protocol {
namespace {

using namespace sample;

Hash counting_hash(int first) {
    Hash hash;
    for (int i = 0; i < 32; ++i) hash.bytes[std::size_t(i)] = static_cast<std::uint8_t>(first + i);
    return hash;
}

Bytes join(std::initializer_list<Bytes> parts) {
    Bytes all;
    for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}
Bytes counting(int first) {
    Bytes bytes;
    for (int i = 0; i < 32; ++i) bytes.push_back(static_cast<std::byte>(first + i));
    return bytes;
}

/// `message` is exactly `bytes`, `bytes` are exactly `message`, and no prefix or extension of them is anything.
void expect_bytes(const Message& message, const Bytes& bytes) {
    EXPECT_EQ(encode(message), bytes);
    const auto parsed = parse_message(bytes);
    ASSERT_TRUE(parsed.ok()) << parsed.error().message;
    EXPECT_EQ(parsed->index(), message.index());
    EXPECT_EQ(encode(*parsed), bytes);
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        // A fresh exact-size copy, so the address sanitizer sees a read one byte past the end.
        const Bytes cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(n));
        const auto result = parse_message(cut);
        ASSERT_FALSE(result.ok()) << "accepted a prefix of " << n << " bytes";
        EXPECT_EQ(result.error().code, ErrorCode::truncated) << n << ": " << result.error().message;
    }
    Bytes longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_EQ(parse_message(longer).error().code, ErrorCode::trailing_bytes);
}

TEST(Messages, Header) {
    StreamHeader header;
    header.name = "demo";
    header.frame_rate = {30000, 1001};
    header.frames = 150;
    header.group_frames = 30;
    header.unit = Unit::cm;
    header.model = counting_hash(0x20);
    header.tracks.push_back(
        {TrackKind::motion, "face", {1001, 30000}, MotionInfo{MotionKind::vertices, 9000, true, false, true},
         {{.slot = 0, .codec = "motion", .bits_per_second = 9000, .basis = counting_hash(0x20)},
          {.slot = 5, .refines = 0, .codec = "motion", .priority = 9}}});
    header.tracks.push_back({TrackKind::texture, "skin", {1001, 30000}, TextureInfo{1024, 512, YuvView::Matrix::bt709, true},
                             {{.slot = 1, .codec = "h264", .bits_per_second = 250000, .priority = 1,
                               .codec_config = literal({1, 0x42, 0xe0})},
                              {.slot = 6, .codec = "h264", .bits_per_second = 60000, .priority = 3, .size = protocol::Rung::Size{512, 256}}}});
    header.tracks.push_back({TrackKind::sound, "", {1, 48000}, SoundInfo{48000, 2, 312, 960, 240240},
                             {{.slot = 2, .codec = "opus", .priority = 2}}});
    expect_bytes(header, join({literal({
        0x01,                          // type HEADER
        0xcf, 0x01,                    // length 207
        'm', 'i', 'e', 'n',            // magic
        0x04,                          // version 4
        0xc6, 0xc1, 0x4b, 0x3c,        // CRC-32C of all that follows
        0x04, 'd', 'e', 'm', 'o',      // name
        0xb0, 0xea, 0x01, 0xe9, 0x07,  // frame rate 30000 / 1001
        0x96, 0x01,                    // 150 frames
        0x1e,                          // 30 frames a group
        0x01,                          // unit cm
    }), counting(0x20), literal({      // model
        0x03,                          // three tracks
        0x01,                          // track 0: motion
        0x04, 'f', 'a', 'c', 'e',      // name
        0xe9, 0x07, 0xb0, 0xea, 0x01,  // time base 1001 / 30000
        0x01,                          // of vertices
        0xa8, 0x46,                    // 9000
        0x05,                          // with pose and presence
        0x02,                          // two rungs
        0x00,                          // slot 0
        0x02,                          // has a basis
    }), counting(0x20), literal({      // basis
        0x06, 'm', 'o', 't', 'i', 'o', 'n',  // codec
        0xa8, 0x46,                    // 9000 bit/s
        0x00,                          // priority 0
        0x00,                          // no codec configuration
        0x05,                          // slot 5
        0x01,                          // refines
        0x00,                          // slot 0
        0x06, 'm', 'o', 't', 'i', 'o', 'n',  // codec
        0x00,                          // bit/s not known
        0x09,                          // priority 9
        0x00,                          // no codec configuration
        0x02,                          // track 1: texture
        0x04, 's', 'k', 'i', 'n',      // name
        0xe9, 0x07, 0xb0, 0xea, 0x01,  // time base 1001 / 30000
        0x80, 0x08, 0x80, 0x04,        // 1024 x 512 texels
        0x00, 0x01,                    // BT.709, full range
        0x02,                          // two rungs
        0x01, 0x00,                    // slot 1, stands alone
        0x04, 'h', '2', '6', '4',      // codec
        0x90, 0xa1, 0x0f,              // 250 000 bit/s
        0x01,                          // priority 1
        0x03, 0x01, 0x42, 0xe0,        // three bytes of codec configuration
        0x06, 0x04,                    // slot 6, has a size
        0x80, 0x04, 0x80, 0x02,        // 512 x 256 texels
        0x04, 'h', '2', '6', '4',      // codec
        0xe0, 0xd4, 0x03,              // 60 000 bit/s
        0x03,                          // priority 3
        0x00,                          // no codec configuration
        0x03,                          // track 2: sound
        0x00,                          // no name
        0x01, 0x80, 0xf7, 0x02,        // time base 1 / 48000
        0x80, 0xf7, 0x02,              // 48 000 Hz
        0x02,                          // two channels
        0xb8, 0x02,                    // 312 samples of pre-roll
        0xc0, 0x07,                    // 960 samples a packet
        0xf0, 0xd4, 0x0e,              // 240 240 samples
        0x01,                          // one rung
        0x02, 0x00,                    // slot 2, stands alone
        0x04, 'o', 'p', 'u', 's',      // codec
        0x00, 0x02, 0x00,              // bit/s not known, priority 2, no codec configuration
    })}));
}

TEST(Messages, HeaderRefusesSizesThatMeanNothing) {
    StreamHeader header;
    header.tracks.push_back({TrackKind::texture, "skin", {1, 30}, TextureInfo{64, 64, YuvView::Matrix::bt709, false}, {{.slot = 1, .codec = "h264"}}});
    for (const Rung::Size size : {Rung::Size{0, 64}, Rung::Size{64, 0}, Rung::Size{8193, 64}, Rung::Size{64, 8193}}) {
        header.tracks[0].rungs[0].size = size;
        EXPECT_FALSE(parse_message(encode(header)).ok()) << size.width << " x " << size.height;
    }
    header.tracks[0].rungs[0].size = {8192, 1};
    EXPECT_TRUE(parse_message(encode(header)).ok());
    header.tracks[0].kind = TrackKind::motion;
    header.tracks[0].info = MotionInfo{MotionKind::vertices, 3, false, false, false};
    EXPECT_FALSE(parse_message(encode(header)).ok());
}

TEST(Messages, Catalogue) {
    expect_bytes(Catalogue{{{counting_hash(0x20), BlobKind::shape, 300}, {counting_hash(0x40), BlobKind::motion_basis, 0}}},
                 join({literal({
        0x02,                    // type CATALOGUE
        0x4a,                    // length 74
        0x79, 0xd9, 0xd8, 0xab,  // CRC-32C of all that follows
        0x02,                    // two static blobs
    }), counting(0x20), literal({
        0x02,                    // shape
        0xac, 0x02,              // 300 bytes
    }), counting(0x40), literal({
        0x05,                    // motion basis
        0x00,                    // empty
    })}));
}

TEST(Messages, BlobAsItIs) {
    const StaticBlob blob{sha256(bytes_of("abc")), BlobKind::texture, bytes_of("abc")};
    const Bytes bytes = literal({
        0x03,  // type BLOB
        0x26,  // length 38
        0xba, 0x78, 0x16, 0xbf, 0x8f, 0x01, 0xcf, 0xea, 0x41, 0x41, 0x40, 0xde, 0x5d, 0xae, 0x22, 0x23,  // SHA-256 of "abc"
        0xb0, 0x03, 0x61, 0xa3, 0x96, 0x17, 0x7a, 0x9c, 0xb4, 0x10, 0xff, 0x61, 0xf2, 0x00, 0x15, 0xad,
        0x08,           // texture
        0x00,           // not packed
        0x03,           // 3 bytes
        'a', 'b', 'c',
    });
    expect_bytes(blob, bytes);
    Bytes wrong = bytes;
    wrong.back() = std::byte{'d'};
    EXPECT_EQ(parse_message(wrong).error().code, ErrorCode::damaged);
}

TEST(Messages, BlobPacked) {
    const Bytes zeros(1000);
    const StaticBlob blob = make_blob(BlobKind::shape, zeros);
    const Bytes bytes = encode(blob);
    EXPECT_LT(bytes.size(), 70u);
    EXPECT_EQ(bytes[35], std::byte{1}) << "packed with zstd";
    const auto parsed = parse_message(bytes);
    ASSERT_TRUE(parsed.ok()) << parsed.error().message;
    EXPECT_EQ(std::get<StaticBlob>(*parsed).bytes, zeros);
    // An announced size that the packed bytes do not have is refused before anything is allocated for it.
    Bytes bomb = bytes;
    bomb[36] = std::byte{0xe9};
    EXPECT_EQ(parse_message(bomb).error().code, ErrorCode::damaged);
}

TEST(Messages, GroupOfOneFrameObjects) {
    expect_bytes(Group{1, 7, -3, {{1, literal({0xaa, 0xbb})}, {1, literal({0xcc})}, {1, literal({0xdd, 0xee, 0xff})}}}, literal({
        0x04,                    // type GROUP
        0x10,                    // length 16
        0xf5, 0x6a, 0x47, 0x74,  // CRC-32C of all that follows
        0x01,                    // one frame each (0 << 6), slot 1
        0x07,                    // group 7
        0x05,                    // from tick -3
        0x03,                    // three objects
        0x04,                    // 2 bytes
        0x01,                    // 1 byte less
                                 // (what remains)
        0xaa, 0xbb, 0xcc, 0xdd, 0xee, 0xff,
    }));
}

TEST(Messages, GroupOfOneLongObject) {
    expect_bytes(Group{0, 300, 9000, {{30, Bytes(5, std::byte{0x11})}}}, literal({
        0x04,                    // type GROUP
        0x11,                    // length 17
        0x9f, 0xba, 0x2e, 0x51,  // CRC-32C of all that follows
        0x40,                    // the same frames each (1 << 6), slot 0
        0xac, 0x02,              // group 300
        0xd0, 0x8c, 0x01,        // from tick 9000
        0x01,                    // one object
        0x1e,                    // of 30 frames
        0x11, 0x11, 0x11, 0x11, 0x11,
    }));
}

TEST(Messages, GroupOfUnevenObjects) {
    expect_bytes(Group{63, 0, 0, {{2, literal({})}, {1, literal({0x22, 0x33, 0x34})}}}, literal({
        0x04,                    // type GROUP
        0x0e,                    // length 14
        0x5f, 0xa8, 0x31, 0x29,  // CRC-32C of all that follows
        0xbf,                    // each its own frames (2 << 6), slot 63
        0x00,                    // group 0
        0x00,                    // from tick 0
        0x02,                    // two objects
        0x02, 0x01,              // of 2 frames and 1 frame
        0x00,                    // 0 bytes
        0x22, 0x33, 0x34,
    }));
}

TEST(Messages, EmptyGroup) {
    const auto parsed = parse_message(encode(Group{2, 1, 48000, {}}));
    ASSERT_TRUE(parsed.ok());
    EXPECT_TRUE(std::get<Group>(*parsed).objects.empty());
}

TEST(Messages, End) {
    expect_bytes(End{150}, literal({
        0x05,        // type END
        0x02,        // length 2
        0x96, 0x01,  // 150 frames
    }));
}

TEST(Messages, Index) {
    const protocol::Index index{
        {{0, 0, 0, 1, 100, 50}, {2, 0, -312, 50, 150, 60}, {0, 1, 30, 1, 210, 300}, {2, 1, 47688, 50, 515, 70}}};
    expect_bytes(index, literal({
        0x06,                    // type INDEX
        0x21,                    // length 33
        0x2b, 0xf5, 0x7c, 0x2b,  // CRC-32C of all that follows
        0x04,                    // four entries
        0x00,                    // slot 0
        0x00,                    // the same group
        0x00,                    // at the expected time, 0
        0x02,                    // one object more than the slot's last entry
        0x64,                    // 100 bytes behind the last entry's end
        0x32,                    // 50 bytes
        0x02,                    // slot 2
        0x00,                    // the same group
        0xef, 0x04,              // 312 ticks before the expected time
        0x64,                    // 50 objects more
        0x00,                    // right behind
        0x3c,                    // 60 bytes
        0x00,                    // slot 0
        0x02,                    // the next group
        0x3c,                    // 30 ticks after the expected time
        0x00,                    // as many objects
        0x00,                    // right behind
        0xac, 0x02,              // 300 bytes
        0x02,                    // slot 2
        0x00,                    // the same group
        0xf0, 0xf2, 0x05,        // expected at 2 * -312 - 0, so 48312 ticks later
        0x00,                    // as many objects
        0x05,                    // 5 bytes lie between
        0x46,                    // 70 bytes
    }));
}

TEST(Messages, Trailer) {
    expect_bytes(Trailer{0x123456}, literal({
        0x07,                                            // type TRAILER
        0x10,                                            // length 16
        0x56, 0x34, 0x12, 0x00, 0x00, 0x00, 0x00, 0x00,  // offset of INDEX
        0x18, 0x24, 0x5b, 0xbe,                          // CRC-32C of the offset
        'm', 'i', 'e', 'n',                              // magic
    }));
    EXPECT_EQ(encode(Trailer{}).size(), kTrailerBytes);
}

TEST(Messages, GroupStartAndLiveObjects) {
    expect_bytes(GroupStart{3, 300, -1, 1}, literal({
        0x08,        // type GROUP START
        0x05,        // length 5
        0x03,        // slot 3
        0xac, 0x02,  // group 300
        0x01,        // from tick -1
        0x01,        // one frame an object
    }));
    expect_bytes(LiveBytes{3, literal({0xaa, 0xbb, 0xcc})}, literal({
        0x43,  // type LIVE OBJECT of slot 3
        0x03,  // length 3
        0xaa, 0xbb, 0xcc,
    }));
    // The budget of live framing: at most four bytes an object.
    for (const std::size_t size : {0u, 127u, 16383u, 16384u, 2097151u})
        EXPECT_LE(encode(LiveBytes{63, Bytes(size)}).size(), size + 4) << size;
}

TEST(Messages, PublishAndItsAnswer) {
    expect_bytes(Publish{"me"}, literal({
        0x2f,           // type PUBLISH
        0x03,           // length 3
        0x02, 'm', 'e',
    }));
    expect_bytes(Publishing{300, 9000}, literal({
        0x30,        // type PUBLISHING
        0x04,        // length 4
        0xac, 0x02,  // from group 300
        0xa8, 0x46,  // from frame 9000
    }));
    EXPECT_FALSE(parse_message(literal({0x30, 0x06, 0x81, 0x80, 0x80, 0x10, 0x00, 0x00})).ok()) << "a group above 2^24";
    expect_bytes(Failure{FailureCode::name_taken, "x"}, literal({
        0x2d,       // type FAILURE
        0x03,       // length 3
        0x0a,       // the name is taken
        0x01, 'x',
    }));
}

TEST(Messages, HelloAndBye) {
    expect_bytes(Hello{kWireVersion, "mp"}, literal({
        0x20,                // type HELLO
        0x08,                // length 8
        'm', 'i', 'e', 'n',  // magic
        0x05,                // version 5
        0x02, 'm', 'p',      // software
    }));
    expect_bytes(Bye{}, literal({
        0x2e,  // type BYE
        0x00,  // length 0
    }));
}

TEST(Messages, Streams) {
    expect_bytes(ListStreams{}, literal({
        0x21,  // type LIST
        0x00,  // length 0
    }));
    expect_bytes(StreamList{{{"a", {30, 1}, 300, false}, {"b", {60, 1}, 0, true}}}, literal({
        0x22,        // type STREAMS
        0x0e,        // length 14
        0x02,        // two streams
        0x01, 'a',   // name
        0x1e, 0x01,  // 30 frames/s
        0xac, 0x02,  // 300 frames
        0x00,        // recorded
        0x01, 'b',   // name
        0x3c, 0x01,  // 60 frames/s
        0x00,        // length not known
        0x01,        // live
    }));
}

TEST(Messages, OpenAndWant) {
    expect_bytes(Open{"take"}, literal({
        0x23,                      // type OPEN
        0x05,                      // length 5
        0x04, 't', 'a', 'k', 'e',  // name
    }));
    expect_bytes(Want{{counting_hash(0x20), counting_hash(0x40)}}, join({literal({
        0x24,  // type WANT
        0x41,  // length 65
        0x02,  // two static blobs
    }), counting(0x20), counting(0x40)}));
    expect_bytes(WantPart{counting_hash(0x20), 200, 300}, join({literal({
        0x31,  // type WANT PART
        0x24,  // length 36
    }), counting(0x20), literal({
        0xc8, 0x01,  // from byte 200
        0xac, 0x02,  // 300 bytes
    })}));
    expect_bytes(BlobPart{500, literal({1, 2, 3})}, literal({
        0x09,        // type BLOB PART
        0x05,        // length 5
        0xf4, 0x03,  // of 500 bytes
        1, 2, 3,     // the part
    }));
    EXPECT_EQ(parse_message(literal({0x09, 0x02, 0xf4, 0x03})).error().code, ErrorCode::damaged) << "an empty part";
    EXPECT_EQ(parse_message(literal({0x09, 0x03, 0x01, 0x02, 0x03})).error().code, ErrorCode::damaged) << "more than the whole";
    EXPECT_EQ(parse_message(literal({0x09, 0x06, 0xff, 0xff, 0xff, 0xff, 0x01, 0x00})).error().code, ErrorCode::limit_exceeded);
    const auto want_part = [](std::initializer_list<int> rest) { return parse_message(join({literal({0x31, int(32 + rest.size())}), counting(0), literal(rest)})).ok(); };
    EXPECT_TRUE(want_part({0x00, 0x80, 0x80, 0x02}));
    EXPECT_FALSE(want_part({0x00, 0x00})) << "no byte at all";
    EXPECT_FALSE(want_part({0x00, 0x81, 0x80, 0x02})) << "more than a part";
    EXPECT_FALSE(want_part({0xff, 0xff, 0xff, 0xff, 0x01, 0x01})) << "behind the end of any message";
}

TEST(Messages, PlayPlayingPauseSeekRateSelect) {
    expect_bytes(Play{1, 1500000, 1000}, literal({
        0x25,              // type PLAY
        0x06,              // length 6
        0x01,              // generation 1
        0xe0, 0xc6, 0x5b,  // from 1.5 s
        0xe8, 0x07,        // at rate 1
    }));
    expect_bytes(Playing{200, 3}, literal({
        0x26,        // type PLAYING
        0x03,        // length 3
        0xc8, 0x01,  // generation 200
        0x03,        // from group 3
    }));
    expect_bytes(Pause{true}, literal({
        0x27,  // type PAUSE
        0x01,  // length 1
        0x01,  // stop
    }));
    expect_bytes(Seek{2, 0}, literal({
        0x28,  // type SEEK
        0x02,  // length 2
        0x02,  // generation 2
        0x00,  // to the start
    }));
    expect_bytes(SetRate{0}, literal({
        0x29,  // type RATE
        0x01,  // length 1
        0x00,  // unpaced
    }));
    expect_bytes(Select{5}, literal({
        0x2a,                                            // type SELECT
        0x08,                                            // length 8
        0x05, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // slots 0 and 2
    }));
}

TEST(Messages, PingPongFailure) {
    expect_bytes(Ping{0x0102}, literal({
        0x2b,                                            // type PING
        0x08,                                            // length 8
        0x02, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // token
    }));
    expect_bytes(Pong{0x0102, 9}, literal({
        0x2c,                                            // type PONG
        0x10,                                            // length 16
        0x02, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // token
        0x09, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // clock
    }));
    expect_bytes(Failure{FailureCode::busy, "full"}, literal({
        0x2d,                      // type FAILURE
        0x06,                      // length 6
        0x06,                      // busy
        0x04, 'f', 'u', 'l', 'l',  // text
    }));
    // A text that is too long is cut between characters.
    const auto parsed = parse_message(encode(Failure{FailureCode::busy, std::string(kMaxText - 1, 'x') + "é"}));
    ASSERT_TRUE(parsed.ok());
    EXPECT_EQ(std::get<Failure>(*parsed).text, std::string(kMaxText - 1, 'x'));
}

TEST(Messages, Manifest) {
    const Manifest manifest{"ada", {{LayerKind::shape, {counting_hash(0x20), counting_hash(0x40)}}, {LayerKind::points, {}}}};
    const Bytes bytes = join({literal({
        0x04,                 // version 4
        0x03, 'a', 'd', 'a',  // actor
        0x02,                 // two layers
        0x01,                 // shape
        0x02,                 // of two blobs
    }), counting(0x20), counting(0x40), literal({
        0x05,                 // points
        0x00,                 // of none
    })});
    EXPECT_EQ(encode_manifest(manifest), bytes);
    const auto parsed = parse_manifest(bytes);
    ASSERT_TRUE(parsed.ok()) << parsed.error().message;
    EXPECT_EQ(encode_manifest(*parsed), bytes);
    for (std::size_t n = 0; n < bytes.size(); ++n)
        EXPECT_FALSE(parse_manifest(Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(n))).ok()) << n;
    Bytes longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_EQ(parse_manifest(longer).error().code, ErrorCode::trailing_bytes);
    Bytes newer = bytes;
    newer[0] = std::byte{kVersion + 1};
    EXPECT_EQ(parse_manifest(newer).error().code, ErrorCode::unsupported_version);
}

TEST(Messages, OtherVersionsAreRefusedByName) {
    Bytes hello = encode(Hello{kWireVersion, "x"});
    hello[6] = std::byte{77};
    const auto parsed = parse_message(hello);
    ASSERT_FALSE(parsed.ok());
    EXPECT_EQ(parsed.error().code, ErrorCode::unsupported_version);
    EXPECT_NE(parsed.error().message.find("77"), std::string::npos) << parsed.error().message;
}

TEST(Messages, LengthsAreBoundedBeforeAnythingIsAllocated) {
    // A GROUP that announces the longest possible body and 2^20 objects, and has neither.
    EXPECT_EQ(parse_head(literal({0x04, 0x80, 0xa0, 0x80, 0x80, 0x01})).ok(), true);
    EXPECT_EQ(parse_head(literal({0x04, 0x81, 0xa0, 0x80, 0x80, 0x01})).error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(parse_head(literal({0x04, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01})).error().code, ErrorCode::damaged);
    EXPECT_EQ(parse_head(literal({0x24, 0x81, 0x80, 0x10}), kMaxControlBytes).error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(parse_head(literal({0x00, 0x00})).error().code, ErrorCode::damaged);
    EXPECT_EQ(parse_head(literal({0x80, 0x00})).error().code, ErrorCode::damaged);
    EXPECT_EQ(parse_head(literal({0x04, 0x80, 0x00})).error().code, ErrorCode::damaged) << "not the shortest form";
    for (const Bytes& open : {literal({}), literal({0x04}), literal({0x04, 0x80}), literal({0x04, 0x80, 0x80, 0x80, 0x80})})
        EXPECT_EQ(parse_head(open).error().code, ErrorCode::truncated) << open.size();
}

TEST(Messages, EveryByteOfEveryKindMayBeWrong) {
    const Stream stream = make_tiny_stream();
    std::vector<Bytes> messages = {encode(stream.header), encode(Catalogue{{{counting_hash(1), BlobKind::eyes, 7}}}),
                                   encode(protocol::Index{{{0, 0, 0, 1, 100, 50}, {1, 0, 3, 2, 150, 9}}}), encode(Trailer{77}),
                                   encode(GroupStart{1, 2, 3, 4}), encode(Hello{kWireVersion, "abc"}),
                                   encode(StreamList{{{"a", {30, 1}, 300, false}}}), encode(Want{{counting_hash(3)}}), encode(WantPart{counting_hash(4), 5, 6}), encode(BlobPart{9, literal({7, 8})}),
                                   encode(Play{1, 2, 3}), encode(Failure{FailureCode::protocol, "why"}), encode(End{4}), encode(LiveBytes{5, literal({1, 2})}),
                                   encode(ListStreams{}), encode(Open{"take"}), encode(Playing{1, 2}), encode(Pause{false}), encode(Seek{3, 4}), encode(SetRate{500}),
                                   encode(Select{5}), encode(Ping{6}), encode(Pong{7, 8}), encode(Bye{}), encode(Publish{"me"}), encode(Publishing{300, 9000})};
    for (const StaticBlob& blob : stream.blobs) messages.push_back(encode(blob));
    for (const Group& group : stream.groups) messages.push_back(encode(group));
    std::vector<bool> kinds(std::variant_size_v<Message>);
    for (const Bytes& message : messages) {
        const auto whole = parse_message(message);
        ASSERT_TRUE(whole.ok()) << whole.error().message;
        kinds[whole->index()] = true;
        for (std::size_t i = 0; i < message.size(); ++i) {
            for (const int value : {0x00, 0xff, std::to_integer<int>(message[i]) ^ 1}) {
                Bytes damaged = message;
                damaged[i] = static_cast<std::byte>(value);
                const auto parsed = parse_message(damaged);
                // What is accepted is a message in its only form.
                if (parsed && !std::holds_alternative<StaticBlob>(*parsed)) {
                    EXPECT_EQ(encode(*parsed), damaged);
                }
            }
        }
    }
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) EXPECT_TRUE(kinds[kind]) << "no message of kind " << kind << " was tried";
}

TEST(Messages, RandomGroupsComeBack) {
    std::mt19937 random(42);
    const auto up_to = [&](std::uint64_t most) { return std::uniform_int_distribution<std::uint64_t>(0, most)(random); };
    for (int round = 0; round < 300; ++round) {
        Group group{static_cast<std::uint8_t>(up_to(63)), static_cast<std::uint32_t>(up_to(kMaxGroups)),
                    std::int64_t(up_to(2 * std::uint64_t(kMaxTicks))) - kMaxTicks, {}};
        const bool uneven = up_to(1);
        const auto frames = static_cast<std::uint32_t>(1 + up_to(3));
        for (std::uint64_t o = up_to(20); o > 0; --o)
            group.objects.push_back({uneven ? static_cast<std::uint32_t>(1 + up_to(kMaxObjectFrames - 1)) : frames,
                                     noise(up_to(1) ? up_to(20) : up_to(3000), random())});
        const Bytes bytes = encode(group);
        const auto parsed = parse_message(bytes);
        ASSERT_TRUE(parsed.ok()) << parsed.error().message;
        EXPECT_TRUE(same(std::get<Group>(*parsed), group));
        std::uint64_t payload = 0;
        for (const Object& object : group.objects) payload += object.bytes.size();
        EXPECT_EQ(group_framing(group) + payload, bytes.size());
    }
}

TEST(Messages, RandomIndexesComeBack) {
    std::mt19937_64 random(7);
    for (int round = 0; round < 200; ++round) {
        protocol::Index index;
        std::uint64_t at = random() % 5000;
        for (int e = int(random() % 40); e > 0; --e) {
            IndexEntry entry{static_cast<std::uint8_t>(random() % kMaxSlots), static_cast<std::uint32_t>(random() % (kMaxGroups + 1)),
                             std::int64_t(random() % (2 * std::uint64_t(kMaxTicks) + 1)) - kMaxTicks,
                             static_cast<std::uint32_t>(random() % (kMaxGroupObjects + 1)), at + random() % 100, random() % 100000};
            at = entry.offset + entry.size;
            index.entries.push_back(entry);
        }
        const Bytes bytes = encode(index);
        const auto parsed = parse_message(bytes);
        ASSERT_TRUE(parsed.ok()) << parsed.error().message;
        EXPECT_EQ(encode(*parsed), bytes);
        const auto& back = std::get<protocol::Index>(*parsed).entries;
        ASSERT_EQ(back.size(), index.entries.size());
        for (std::size_t e = 0; e < back.size(); ++e) {
            EXPECT_EQ(back[e].first_time, index.entries[e].first_time);
            EXPECT_EQ(back[e].offset, index.entries[e].offset);
            EXPECT_EQ(back[e].objects, index.entries[e].objects);
        }
    }
}

}  // namespace
}  // namespace mien::protocol
