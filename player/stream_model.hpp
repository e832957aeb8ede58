#pragma once

#include <optional>

#include "core/result.hpp"
#include "decoder/av_sound.hpp"
#include "decoder/av_texture.hpp"
#include "decoder/motion_decoder.hpp"
#include "model/face_model.hpp"
#include "net/source.hpp"
#include "protocol/texture_rungs.hpp"

namespace mien::player {

/// Which rung of a texture to play.
struct TextureChoice {
    std::optional<std::size_t> rung;        ///< number, 0 the coarsest
    std::optional<double> kbps;             ///< else the finest of at most this rate; neither: the finest
};

/// What a stream announces, made ready to decode and draw: the model, and a decoder for one rung of each track.
struct StreamModel {
    model::FaceModel model;                 ///< with static_albedo filled in when the model has one
    model::LinearMotion composed;           ///< model::compose's
    decoder::MotionDecoder motion;
    std::optional<decoder::TextureDecoder> texture;
    std::optional<decoder::SoundDecoder> sound;
    std::vector<std::uint8_t> motion_slots;  ///< of the rungs that are used, the one that stands alone first
    std::uint8_t texture_slot = 0, sound_slot = 0;
    Rational frame_rate;
    std::int64_t frames = 0;                ///< 0: live, or a recording that was broken off
    bool live = false;                      ///< comes while it is made; then its motion alone is shown
    int texture_width = 0, texture_height = 0;
    int sample_rate = 48000;

    std::uint64_t slots() const;            ///< bit s: slot s is used
    double seconds() const { return double(frames) / frame_rate.value(); }
};

/// From a source that is ready. with_sound: whether to decode its sound. motion_rungs: how many rungs of its motion to use, at most.
Result<StreamModel> open_stream_model(const net::StreamSource& source, bool with_sound, std::size_t motion_rungs = 64,
                                      const TextureChoice& texture = {});

}  // namespace mien::player
