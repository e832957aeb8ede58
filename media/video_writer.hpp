#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/image.hpp"

namespace mien::media {

/// Writes pictures, and sound beside them, into a video file. What the file system refuses throws
/// EnvironmentError. The file appears under its name only when finish() has returned; before that it is
/// in the making beside it (core/unfinished.hpp).
class VideoWriter {
public:
    struct Movie {
        std::optional<Sound> sound;  ///< AAC, 160 kbit/s
        bool sound_later = false;    ///< of `sound` only rate and channels count: set_sound() brings it
        double crf = 18;             ///< x264's; lower is better
        std::string speed = "veryfast";
    };
    /// MP4 with H.264 (4:2:0, BT.709, limited range) that any player plays. Odd sizes get one more row or
    /// column.
    static VideoWriter movie(const std::filesystem::path& path, int width, int height, Rational frame_rate,
                             Movie options);
    static VideoWriter movie(const std::filesystem::path& path, int width, int height, Rational frame_rate) {
        return movie(path, width, height, frame_rate, Movie{});
    }
    /// Matroska with lossless H.264 in RGB: every pixel comes back as it was. Skin changes little from picture to
    /// picture, which codecs that know no motion cannot use: FFV1 makes files four times as large that take eight
    /// times as long to read.
    static VideoWriter lossless(const std::filesystem::path& path, int width, int height,
                                Rational frame_rate);

    VideoWriter(VideoWriter&&) noexcept;
    VideoWriter& operator=(VideoWriter&&) noexcept;
    ~VideoWriter();  ///< without finish(), nothing is left

    /// The next picture: of the size above, 1, 3 or 4 channels (alpha is ignored).
    void write(const Image& picture);
    /// All of the sound, if it was to come later; before finish().
    void set_sound(const Sound& sound);
    void finish();

private:
    struct State;
    explicit VideoWriter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::media
