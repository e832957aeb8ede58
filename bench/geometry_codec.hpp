#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/clip.hpp"
#include "core/hash.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

/// What every geometry codec of the bench is asked for, ours and the baselines alike.
namespace mien::bench {

/// The motion of a clip as rows of floats: F frames of N points of D numbers (3, or 1 for weights).
struct GeometryInput {
    GeometryInput(const Clip& clip, protocol::MotionKind kind);

    const Clip& clip;
    protocol::MotionKind kind;
    std::int64_t frames = 0, points = 0;
    int dimension = 3;
    std::span<const Triangle> triangles;  ///< vertices only
    std::vector<float> held;              ///< F x N x D: missing markers hold their last place, so that baselines code numbers

    std::int64_t numbers() const { return points * dimension; }  ///< of one frame
    const float* truth(std::int64_t frame) const;                ///< NaN: missing
    const float* frame(std::int64_t f) const { return held.data() + f * numbers(); }
    /// Grid step whose rounding error has this RMS 3-D (1-D for weights) length: D times step^2 / 12.
    double step(double rms) const;
};

/// A clip as one codec stores it, ready to be decoded from the first frame on.
class GeometryStream {
public:
    virtual ~GeometryStream() = default;
    /// Bytes of everything that a decoder needs, by what they are for; framing around packets and what design shows apart
    /// (connectivity, texture coordinates) not counted.
    std::vector<std::pair<std::string, std::uint64_t>> parts;
    std::vector<std::pair<std::string, std::uint64_t>> apart;  ///< shown beside, not counted
    std::int64_t frames_together = 1;                          ///< frames that only decode together

    std::uint64_t bytes() const;
    /// Decoding begins again at frame 0. Not timed.
    virtual Result<void> start() = 0;
    /// The next frame as N x D floats.
    virtual Result<void> decode(std::int64_t frame, std::span<float> out) = 0;
};

enum class Mode { live, file };  ///< one self-contained packet per frame without delay; or look-ahead

class GeometryCodec {
public:
    virtual ~GeometryCodec() = default;
    std::string name, what, library;  ///< library: name and version of what does the work
    Mode mode = Mode::live;
    bool lossless = false;  ///< one row, whatever error is asked
    bool ours = false;
    /// Why this codec does not take such input; empty: it does.
    virtual std::string refuses(const GeometryInput& input) const;
    virtual Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double rms) const = 0;
};

struct GeometryCodecs {
    std::vector<std::unique_ptr<GeometryCodec>> codecs;
    std::vector<std::pair<std::string, std::string>> absent;  ///< codecs not in this build, and why
};
/// All that this build has, ours first.
GeometryCodecs geometry_codecs();

// One file per family adds to the list.
void add_mien(GeometryCodecs& list);
void add_raw(GeometryCodecs& list);
void add_compressed_deltas(GeometryCodecs& list);
void add_draco(GeometryCodecs& list);
void add_meshoptimizer(GeometryCodecs& list);

/// Bytes that Draco needs for the triangles alone; 0 when this build has no Draco or it refuses the mesh. keep_order: vertices
/// and triangles come back in their order (sequential coding), else in one of Draco's own (edgebreaker).
std::uint64_t draco_connectivity_bytes(const Mesh& mesh, bool keep_order);

}  // namespace mien::bench
