#pragma once

#include <cstdint>

/// Bounds on what files may ask for, each with its reason. Nothing is allocated for a count above its bound.
namespace mien::io {

inline constexpr std::uint64_t kMaxFileBytes = std::uint64_t(2) << 30;  // a text or mesh file read at once; a 4 M vertex OBJ is 0.5 GB
inline constexpr std::int64_t kMaxVertices = 1 << 22;                   // film heads have below one million
inline constexpr std::int64_t kMaxTriangles = 1 << 23;
inline constexpr std::int64_t kMaxMarkers = 1 << 16;
inline constexpr std::int64_t kMaxWeights = 4096;                       // film rigs have about one thousand blendshapes
inline constexpr std::int64_t kMaxFrames = 1 << 24;                     // three days at 60 Hz
inline constexpr std::int64_t kMaxValues = std::int64_t(1) << 33;       // floats of one array: 32 GiB, more than fits beside a clip
inline constexpr int kMaxImageSide = 8192;                              // texels; film faces have 8192, and a small file may ask for it: 256 MiB
inline constexpr std::int64_t kMaxSoundSamples = std::int64_t(1) << 31; // 6 hours of stereo at 48 kHz

}  // namespace mien::io
