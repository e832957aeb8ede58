#pragma once

#include <filesystem>
#include <future>
#include <memory>

#include "core/clip.hpp"
#include "core/result.hpp"
#include "model/face_model.hpp"
#include "render/face_renderer.hpp"

namespace mien::player {

/// The performance as it was before coding, drawn by the same renderer: explicit positions and the clip's own texture.
/// Belongs to the current OpenGL context.
class TruthView {
public:
    /// `received`: the stream's model; a clip of markers alone borrows its triangulation.
    static Result<std::unique_ptr<TruthView>> open(const std::filesystem::path& clip, const model::FaceModel& received);

    std::int64_t frames() const { return clip_.frame_count(); }
    Rational frame_rate() const { return clip_.frame_rate; }
    Result<void> show(std::int64_t frame);
    void draw(const render::Camera& camera, const render::Look& look, render::Target& target) {
        renderer_->draw(camera, look, target);
    }

private:
    explicit TruthView(Clip clip) : clip_(std::move(clip)) {}
    Points positions(std::int64_t frame) const;
    /// The texture's picture of a frame. The one after it is read meanwhile, as it is likely to be asked for next.
    Result<Image> picture(std::int64_t frame);

    Clip clip_;
    std::unique_ptr<render::FaceRenderer> renderer_;
    bool static_texture_ = false;
    std::int64_t ahead_ = -1;                 ///< the picture that is being read
    std::future<Result<Image>> reading_;      ///< the last member: it uses the clip
};

}  // namespace mien::player
