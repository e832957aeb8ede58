#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/clip.hpp"
#include "core/hash.hpp"
#include "core/result.hpp"

/// What a detail model has beside its maps, as bytes. docs/format-detail.md gives them.
namespace mien::coding {

inline constexpr std::uint32_t kMaxDetailMarkers = 4096;  // facial capture has some hundreds

/// What holds a thin shell.
struct Shell {
    std::vector<Site> sites;           ///< weights add up to 1; rounded to 1/4096
    std::vector<std::uint32_t> fixed;  ///< ascending vertices
};
Bytes encode_shell(const Shell& shell);
/// V: vertices of the mesh.
Result<Shell> decode_shell(ByteView bytes, std::uint32_t V);

/// Markers that drive a thin shell in the place of those of its Shell.
struct DrivingMarkers {
    std::vector<Site> sites;           ///< rounded as those of a Shell
    Points rest_offsets;               ///< M x 3 mm, of the markers at rest from their sites; rounded to kRestStep
};
inline constexpr float kRestStep = 1.0f / 64;
inline constexpr float kMaxRestOffset = 100;   ///< mm
Bytes encode_driving_markers(const DrivingMarkers& markers);
/// V: vertices of the mesh.
Result<DrivingMarkers> decode_driving_markers(ByteView bytes, std::uint32_t V);

/// What turns markers into a domain.
struct MarkerDomain {
    static constexpr int kAxes = 10;   ///< Q and R of a marker, five numbers each
    static constexpr int kMaxTerms = 10;
    float reach = 0;                   ///< mm
    std::vector<Triangle> triangles;   ///< over the markers
    std::vector<std::array<float, kAxes>> axes;  ///< M; rounded to 2^-12 of the power of two above the largest of a marker
    std::vector<float> extents;        ///< M, or none; more than 0, rounded up to kExtentStep
    int terms = 1;                     ///< of the factors
    std::vector<float> factors;        ///< M lower triangles by rows; rounded to kFactorStep, diagonals at least that
};
inline constexpr float kFactorStep = 1.0f / 64;
inline constexpr float kExtentStep = 1.0f / 16, kMaxExtent = 4096;
Bytes encode_marker_domain(const MarkerDomain& domain);
/// M: markers of the shell.
Result<MarkerDomain> decode_marker_domain(ByteView bytes, std::uint32_t M);

/// How the planes of a polynomial map were coded.
struct MapHead {
    int channels = 1;                  ///< 1 or 3
    int order = 2;                     ///< 0 .. 3
    float step = 1;                    ///< of the last stage
    int stages = 1;                    ///< 1 .. kMaxStages
    std::array<std::int16_t, 9> rotation{};  ///< by rows, 1 = 2^14: coded channels from the map's; of three channels
};
inline constexpr int kMaxStages = 16;
/// One stage: where values lie in their interval, in 1/128 of it beyond |value|, for 1 and for more; and the coded planes.
struct MapStage {
    std::array<std::int8_t, 2> lift{};
    Bytes coded;
};
Bytes encode_map(const MapHead& head, const MapStage& first);
struct CodedMap {
    MapHead head;
    MapStage first;
};
Result<CodedMap> decode_map(ByteView bytes);
/// stage: 1 .. stages - 1.
Bytes encode_refinement(int stage, const MapStage& refinement);
Result<MapStage> decode_refinement(ByteView bytes, int stage);

}  // namespace mien::coding
