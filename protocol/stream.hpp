#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/clip.hpp"
#include "core/hash.hpp"
#include "core/rational.hpp"

/// What a stream consists of, as values. docs/format.md gives the bytes of each.
namespace mien::protocol {

enum class TrackKind : std::uint8_t { motion = 1, texture = 2, sound = 3 };
enum class MotionKind : std::uint8_t { vertices = 1, markers = 2, weights = 3 };

/// One quality of one track. `slot` is its number in the whole stream; groups and objects name it by that.
struct Rung {
    struct Size {
        std::uint32_t width = 0, height = 0;
        bool operator==(const Size&) const = default;
    };
    std::uint8_t slot = 0;                   ///< < kMaxSlots, unique in the stream
    std::optional<std::uint8_t> refines;     ///< slot of the rung it refines; none: it stands alone
    std::string codec;                       ///< "motion"; "mpeg4" "h264" "hevc" "av1"; "opus" "aac"
    std::uint32_t bits_per_second = 0;       ///< average; 0: not known
    std::uint8_t priority = 0;               ///< 0 is dropped last
    std::optional<Hash> basis;               ///< motion: the motion basis blob it starts with
    std::optional<Size> size;                ///< texture: texels as shown, where they are not the track's
    Bytes codec_config;                      ///< texture, sound: out-of-band codec headers (FFmpeg's extradata)
};

struct MotionInfo {
    MotionKind kind = MotionKind::vertices;
    std::uint32_t count = 0;                 ///< vertices, markers or weights
    bool has_pose = false;
    bool has_gaze = false;
    bool has_presence = false;               ///< some markers are missing in some frames
};
struct TextureInfo {
    std::uint32_t width = 0, height = 0;     ///< texels as shown; the codec may pad
    YuvView::Matrix matrix = YuvView::Matrix::bt709;
    bool full_range = false;
};
struct SoundInfo {
    std::uint32_t sample_rate = 48000;
    std::uint8_t channels = 1;
    std::uint32_t preroll = 0;               ///< samples a decoder has to swallow before its output is right
    std::uint32_t packet_samples = 960;      ///< samples per packet
    std::uint64_t samples = 0;               ///< samples per channel as shown; 0: live
};

struct Track {
    TrackKind kind = TrackKind::motion;
    std::string name;
    Rational time_base{1, 30};               ///< seconds per tick; visual tracks: one tick is one frame
    std::variant<MotionInfo, TextureInfo, SoundInfo> info;
    std::vector<Rung> rungs;                 ///< at least one
};

/// The rungs that build on each other, from the first that stands alone up: each refines the one before it.
std::vector<const Rung*> rung_ladder(const Track& track);

struct StreamHeader {
    std::string name;
    Rational frame_rate{30, 1};              ///< of the visual tracks
    std::uint64_t frames = 0;                ///< 0: live, not known yet
    std::uint32_t group_frames = 30;         ///< nominal frames of a group; 0: the whole clip is one group
    Unit unit = Unit::mm;                    ///< the clip's own, for writing it back
    Hash model;                              ///< of the model manifest blob
    std::vector<Track> tracks;
};

/// What a static blob holds. Blobs are immutable and named by the SHA-256 of their unpacked bytes.
enum class BlobKind : std::uint8_t {
    manifest = 1,      ///< face model manifest: layers, each naming its blobs
    shape = 2,         ///< neutral positions and parts
    connectivity = 3,  ///< triangles
    texcoords = 4,     ///< texture coordinates and their triangles
    motion_basis = 5,
    blend = 6,         ///< markers -> mesh blend coefficients, marker sites
    blendshapes = 7,   ///< targets of a weight-driven mesh
    texture = 8,       ///< a static picture (JPEG or PNG bytes)
    eyes = 9,          ///< eyeballs that gaze turns
    contact = 10,      ///< lips or lids that are held apart
    shell = 11,        ///< what holds a thin shell: marker sites, fixed vertices
    marker_domain = 12,  ///< marker triangles, axes and factors: what drives polynomial maps
    texel_mask = 13,   ///< the texels a map covers
    detail_map = 14,   ///< the first stage of a polynomial map
    refinement = 15,   ///< a further stage of a polynomial map
    driving_markers = 16,  ///< markers that drive a thin shell in the place of those of its shell blob
    lid = 17,          ///< how far an upper lid goes, and the eyeball it slides over
};

struct BlobInfo {
    Hash hash;
    BlobKind kind = BlobKind::manifest;
    std::uint64_t size = 0;                  ///< unpacked bytes
};

/// One layer of the model and the blobs it needs, first to last.
enum class LayerKind : std::uint8_t {
    shape = 1,         ///< the neutral mesh: shape, connectivity, texcoords
    vertex_basis = 2,  ///< base shape: motion is vertex offsets
    blend = 3,         ///< base shape: motion is marker offsets, blended (Guenter et al. 1998, section 4)
    blendshapes = 4,   ///< base shape: motion is weights
    points = 5,        ///< base shape: the markers themselves, no mesh known
    eyes = 6,          ///< eyeballs turned by gaze
    static_albedo = 7,
    video_albedo = 8,  ///< albedo is the stream's texture track
    contact = 9,       ///< lips or lids that are held apart, where the base shape does not; one layer for each slit
    thin_shell = 10,   ///< base shape: motion is marker offsets, a linear thin shell over them (Ma et al. 2008, section 4)
    marker_domain = 11,  ///< what the maps below are polynomials of
    medium = 12,       ///< displacement of the base shape: mask, map, refinements in order
    fine = 13,         ///< displacement along the normal: likewise
    albedo_map = 14,   ///< polynomial albedo: likewise
    lid = 15,          ///< an upper lid that markers move: it goes further than they, over the eyeball; one layer an eye
};
struct Layer {
    LayerKind kind = LayerKind::shape;
    std::vector<Hash> blobs;
};
/// The model manifest. Its own hash names the model.
struct Manifest {
    std::string actor;
    std::vector<Layer> layers;
};

/// The static blobs of a stream, in the order in which they are worth fetching; those without which it does not play are fetch_order()'s to find.
struct Catalogue {
    std::vector<BlobInfo> blobs;
};
struct StaticBlob {
    Hash hash;
    BlobKind kind = BlobKind::manifest;
    Bytes bytes;                             ///< unpacked; zstd on the wire and in files when that is smaller
};

/// One coded unit: one frame, one sound packet, or as many frames as `frames` says.
struct Object {
    std::uint32_t frames = 1;                ///< frames (visual) or packets (sound) that it holds
    Bytes bytes;
};
/// All objects of one group of one rung, in decoding order: what a file stores and a server of recordings sends.
struct Group {
    std::uint8_t slot = 0;
    std::uint32_t group = 0;                 ///< number; groups of all rungs with one number belong together
    std::int64_t first_time = 0;             ///< ticks of the track's time base, of the first object
    std::vector<Object> objects;
};
/// A single object of a live stream; `first_time` is its own.
struct LiveObject {
    std::uint8_t slot = 0;
    std::uint32_t group = 0;
    std::int64_t first_time = 0;
    std::uint32_t index = 0;                 ///< of the object in its group; 0 starts the group
    Object object;
};

/// Where a group lies in a file.
struct IndexEntry {
    std::uint8_t slot = 0;
    std::uint32_t group = 0;
    std::int64_t first_time = 0;
    std::uint32_t objects = 0;
    std::uint64_t offset = 0;                ///< bytes from the start of the file to the GROUP message
    std::uint64_t size = 0;                  ///< bytes of the whole message
};

}  // namespace mien::protocol
