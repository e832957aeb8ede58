#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/result.hpp"
#include "decoder/av_sound.hpp"
#include "decoder/av_texture.hpp"
#include "decoder/detail_decoder.hpp"
#include "decoder/motion_decoder.hpp"
#include "model/face_model.hpp"
#include "net/source.hpp"
#include "protocol/texture_rungs.hpp"

namespace mien::player {

/// Which rung of a texture to play.
struct TextureChoice {
    std::optional<std::size_t> rung = {};   ///< number, 0 the coarsest
    std::optional<double> kbps = {};        ///< else the finest of at most this rate
    bool automatic = false;                 ///< else what the line takes, as far as that is known; none of these: the finest
};

/// What a stream announces, made ready to decode and draw: the model, and a decoder for one rung of each track.
struct StreamModel {
    model::FaceModel model;                 ///< with static_albedo filled in when the model has one, and the stages of its detail that were there
    model::LinearMotion composed;           ///< model::compose's
    decoder::MotionDecoder motion;
    std::optional<decoder::TextureDecoder> texture;   ///< of one rung; use_texture_rung() changes it
    std::optional<decoder::SoundDecoder> sound;
    std::vector<std::uint8_t> motion_slots;  ///< of the rungs that are used, the one that stands alone first
    struct TextureRung {
        std::uint8_t slot = 0;
        int width = 0, height = 0;
        double bits_per_second = 0;         ///< 0: not known
    };
    std::vector<TextureRung> texture_rungs = {};  ///< that stand alone, the coarsest first; empty: no texture track
    std::size_t first_texture_rung = 0;      ///< the one that was chosen when the stream was opened
    double other_bits_per_second = 0;        ///< of the motion and sound that are used
    std::uint8_t sound_slot = 0;
    Rational frame_rate = {};
    std::int64_t frames = 0;                ///< 0: live, or a recording that was broken off
    bool live = false;                      ///< comes while it is made; then its motion and sound alone are played
    int sample_rate = 48000, channels = 1;   ///< of the sound
    std::int64_t samples = 0;               ///< of the sound, per channel; 0: not known

    std::uint64_t slots(std::size_t texture_rung) const;      ///< bit s: slot s is used, with this rung of the texture
    std::uint64_t slots() const { return slots(first_texture_rung); }
    std::optional<std::size_t> texture_rung_of(std::uint8_t slot) const;
    /// Makes `texture` that of another rung. Only the thread that decodes may call this.
    Result<void> use_texture_rung(std::size_t rung);
    double seconds() const { return double(frames) / frame_rate.value(); }

    std::unique_ptr<decoder::DetailDecoder> growing = {};   ///< takes the stages of the detail that come later; null: none will
    protocol::Track texture_track = {};     ///< what decoders of its rungs are made from
    std::size_t texture_in_use = 0;         ///< rung of `texture`
};

/// What to ask a source for before anything but its header is here, and the rung of texture that is among it (0 when there is no texture).
/// `line`: bit/s, where it is known. Live streams: their motion and sound alone.
struct FirstChoice {
    std::uint64_t slots = 0;
    std::size_t texture_rung = 0;
    std::optional<std::uint8_t> sound_slot;
};
FirstChoice first_choice(const protocol::StreamHeader& header, bool live, bool with_sound, std::size_t motion_rungs, const TextureChoice& texture,
                         std::optional<double> line);

/// From a source that is ready. with_sound: whether to decode its sound. motion_rungs: how many rungs of its motion to use, at most. refining: somebody takes
/// refinements of the model from now on (and tells what is wrong with them), so a damaged one that is here already is left to them.
Result<StreamModel> open_stream_model(const net::StreamSource& source, bool with_sound, std::size_t motion_rungs = 64,
                                      const TextureChoice& texture = {}, bool refining = false);

}  // namespace mien::player
