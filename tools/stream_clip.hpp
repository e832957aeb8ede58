#pragma once

#include <string>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "protocol/texture_rungs.hpp"
#include "tools/stored_stream.hpp"

namespace mien::tools {

/// A stretch of a track that could not be decoded.
struct Loss {
    protocol::TrackKind track;
    std::int64_t first = 0, end = 0;   ///< frames; for sound samples
    std::string why;
    enum class Kind { lost, coarser, whole, cut } kind = Kind::lost;   ///< coarser: only a finer rung of motion is missing; whole: nothing is left of the texture; cut: it ends before the motion
};
using Losses = std::vector<Loss>;

/// One sentence: what is lost, and what stands there instead.
std::string describe(const Loss& loss, const protocol::StreamHeader& header);

/// `bare` leaves the texture out.
enum class Keep { textured, bare };

/// Which rungs to decode, 0 the coarsest: of motion all up to this one, of texture this one.
struct Rungs {
    std::size_t motion = StoredStream::kAllRungs;
    std::size_t texture = protocol::kFinestRung;
};

/// Everything a stream gives back, in the shape of the clip that was encoded: its vertices, markers or weights, head pose,
/// gaze, texture (decoded as it is read) and sound.
///
/// Without `losses`, groups that cannot be decoded are an error. With it they are noted there (those of the texture as it is
/// read) and the rest keeps its time: lost frames repeat the one before, at the start the one after, and lost sound is silent.
/// A stream that has been cut gives the frames of motion that it still holds; its texture may end a group before them. Then it has
/// fewer frames, or with `losses` its last picture stands for the rest.
Result<Clip> decode_stream(const StoredStream& stream, const Progress& progress = {}, Keep keep = Keep::textured,
                           std::shared_ptr<Losses> losses = nullptr, Rungs rungs = {});

}  // namespace mien::tools
