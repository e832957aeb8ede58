#pragma once

#include <optional>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"
#include "encoder/model_encoder.hpp"
#include "encoder/motion_encoder.hpp"
#include "encoder/sound_encoder.hpp"
#include "encoder/texture_encoder.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

struct StreamOptions {
    std::string name;                        ///< of the stream; empty: the clip's
    MotionOptions motion;
    std::optional<TextureOptions> texture = TextureOptions{};  ///< none: no texture track and no static texture
    std::optional<SoundOptions> sound = SoundOptions{};        ///< none: no sound track
    /// A trained model with its blobs, instead of one made from the clip: motion is then that of its markers. The clip's must be as many.
    std::optional<EncodedModel> model;
    std::optional<double> group_seconds = 1.0;                 ///< none: the whole clip is one group
};

/// A whole stream, ready to be written: protocol::StreamFileWriter takes header, blobs and groups as they are.
struct EncodedStream {
    protocol::StreamHeader header;
    std::vector<protocol::StaticBlob> blobs;
    std::vector<protocol::Group> groups;     ///< by group, then slot
    double motion_rms = 0, motion_peak = 0;  ///< measured, mm or weight units
    std::vector<std::string> warnings;       ///< what was asked and is not met, for the user to read
};

/// clip -> objects: the model first, then motion against the model as decoders will have it, then texture and sound.
/// options.*.group_frames, frame rate and frame count are filled in here. Tracks that the clip does not have are left out.
Result<EncodedStream> encode_stream(const Clip& clip, const StreamOptions& options, const Progress& progress = {});

/// Frames of a group of about `seconds`: the nearest whole number, at least one.
std::int64_t group_frames(Rational frame_rate, double seconds);

}  // namespace mien::encoder
