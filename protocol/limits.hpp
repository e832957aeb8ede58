#pragma once

#include <cstddef>
#include <cstdint>

/// Every bound on what comes from outside, with its reason. Nothing is allocated for a length above its bound.
namespace mien::protocol {

inline constexpr std::size_t kMaxName = 256;                    // bytes of UTF-8: longer than any file name people type
inline constexpr std::size_t kMaxTracks = 16;                   // motion, texture and sound, each for a few faces or languages
inline constexpr std::size_t kMaxSlots = 64;                    // (track, rung) pairs of a stream: they fit in six bits of a message type
inline constexpr std::size_t kMaxBlobs = 4096;                  // static blobs of one stream: model layers, refinements, motion bases
inline constexpr std::size_t kMaxBlobBytes = 256u << 20;        // unpacked static blob: 40 float maps of 1024 x 1024 are 168 MB
inline constexpr std::size_t kMaxObjectBytes = 64u << 20;       // one coded unit: a lossless 4096 x 4096 frame is below 50 MB
inline constexpr std::size_t kMaxMessageBytes = kMaxBlobBytes + 4096;  // one message: a static blob or a group of objects
inline constexpr std::size_t kMaxPartBytes = 1u << 15;          // of a static blob that comes in parts: what is due waits 2.6 s for one at 100 kbit/s
inline constexpr std::size_t kMaxControlBytes = 1u << 18;       // a message to a server: WANT with kMaxBlobs hashes has 128 KiB
inline constexpr std::size_t kMaxText = 1024;                   // bytes of UTF-8: a sentence or two for a person
inline constexpr std::size_t kMaxCodecName = 32;                // bytes; "hevc", "mpeg4", ...
inline constexpr std::size_t kMaxCodecConfig = 1u << 20;        // bytes of a codec's own headers; H.264's are below 200
inline constexpr std::size_t kMaxLayers = 256;                  // of a model manifest
inline constexpr std::size_t kMaxStreams = 4096;                // that one server lists
inline constexpr std::uint32_t kMaxObjectFrames = 1u << 24;     // frames in one coded unit: a whole take of three days at 60 Hz
inline constexpr std::uint32_t kMaxSampleRate = 768000;         // Hz; the fastest converters sold
inline constexpr std::uint32_t kMaxChannels = 8;                // of sound: 7.1
inline constexpr std::uint32_t kMaxRate = 1000000;              // play rate in thousandths: a thousand times real time
inline constexpr std::size_t kMaxGroupObjects = 1u << 20;       // objects of one group: an hour of sound packets is 180 000
inline constexpr std::size_t kMaxGroups = 1u << 24;             // groups of one stream: half a year at 1 s
inline constexpr std::uint32_t kMaxVertices = 1u << 22;         // film heads have below one million
inline constexpr std::uint32_t kMaxTriangles = 1u << 23;
inline constexpr std::uint32_t kMaxMarkers = 1u << 16;
inline constexpr std::uint32_t kMaxWeights = 4096;              // film rigs have about one thousand blendshapes
inline constexpr std::uint32_t kMaxComponents = 4096;           // of a motion basis
inline constexpr std::uint32_t kMaxTextureSide = 8192;          // texels; the largest side libavcodec's profiles all take
inline constexpr std::int64_t kMaxTicks = std::int64_t(1) << 52; // a time in ticks: exact in a double

}  // namespace mien::protocol
