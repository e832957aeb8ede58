#pragma once

#include <filesystem>
#include <memory>

#include "core/image.hpp"
#include "core/rational.hpp"
#include "core/result.hpp"

namespace mien::media {

/// Writes pictures as FFV1 in Matroska: RGB, every bit kept, each frame a key frame.
class LosslessVideoWriter {
public:
    /// `unavailable` when the file cannot be written or FFmpeg lacks FFV1.
    static Result<LosslessVideoWriter> open(const std::filesystem::path& path, int width, int height,
                                            Rational frame_rate);
    LosslessVideoWriter(LosslessVideoWriter&&) noexcept;
    LosslessVideoWriter& operator=(LosslessVideoWriter&&) noexcept;
    ~LosslessVideoWriter();

    /// The next frame: RGB, of the size given.
    Result<void> write(const Image& picture);
    /// Writes what is under way and closes the file; without it the file is not whole.
    Result<void> finish();

private:
    struct State;
    explicit LosslessVideoWriter(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::media
