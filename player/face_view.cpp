#include "player/face_view.hpp"

namespace mien::player {

FaceView::FaceView(const StreamModel& stream)
    : renderer_(stream.model, stream.composed),
      neutral_box_(render::bounding_box(model::neutral_points(stream.model))), box_(neutral_box_) {
    if (stream.model.static_albedo) renderer_.set_texture(*stream.model.static_albedo);
}

void FaceView::show(const PlayFrame& frame) {
    renderer_.set_motion(frame.motion);
    if (frame.texture) renderer_.set_texture(frame.texture->picture);
    if (!has_frame_) box_ = moved(neutral_box_, frame.motion.pose);
    has_frame_ = true;
}

render::OrbitCamera FaceView::framing(float aspect, render::View view) const {
    return render::frame_box(box_, aspect, view);
}

Eigen::AlignedBox3f moved(const Eigen::AlignedBox3f& box, const RigidPose& pose) {
    // Only its middle: a turned head would make the box, and so the picture, larger.
    const Vec3 shift = pose.apply(box.center()) - box.center();
    return {box.min() + shift, box.max() + shift};
}

}  // namespace mien::player
