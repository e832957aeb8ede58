#pragma once

#include "player/play_frame.hpp"
#include "player/stream_model.hpp"
#include "render/face_renderer.hpp"

namespace mien::player {

/// The received face on the GPU. Belongs to the current OpenGL context.
class FaceView {
public:
    explicit FaceView(const StreamModel& stream);

    void show(const PlayFrame& frame);
    void refine(std::shared_ptr<const render::DetailPictures> pictures) { renderer_.refine(std::move(pictures)); }
    bool refining() const { return renderer_.refining(); }
    void draw(const render::Camera& camera, const render::Look& look, render::Target& target) {
        renderer_.draw(camera, look, target);
    }
    /// A camera that shows the whole head as the first frame shown held it.
    render::OrbitCamera framing(float aspect, render::View view) const;
    bool has_frame() const { return has_frame_; }

private:
    render::FaceRenderer renderer_;
    Eigen::AlignedBox3f neutral_box_, box_;
    bool has_frame_ = false;
};

/// The box, its middle carried along by a rigid motion.
Eigen::AlignedBox3f moved(const Eigen::AlignedBox3f& box, const RigidPose& pose);

}  // namespace mien::player
