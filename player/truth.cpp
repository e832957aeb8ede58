#include "player/truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "io/clip_folder.hpp"

namespace mien::player {

Result<std::unique_ptr<TruthView>> TruthView::open(const std::filesystem::path& path, const model::FaceModel& received) {
    MIEN_TRY(loaded, io::load_clip(path));
    std::unique_ptr<TruthView> truth(new TruthView(std::move(loaded.clip)));
    const Clip& clip = truth->clip_;
    model::FaceModel model;
    if (clip.vertices || (clip.weights && !clip.blendshapes.empty())) {
        if (!clip.neutral) return Error{ErrorCode::missing, fmt::format("{} has no neutral mesh to draw", path.string())};
        model.neutral = *clip.neutral;
    } else if (clip.markers) {
        const auto* points = std::get_if<model::PointBase>(&received.base);
        if (!points || points->markers.rows() != clip.markers->points)
            return Error{ErrorCode::mismatch, fmt::format("{} has markers only, and the stream shows another number of points",
                                                          path.string())};
        model.base = *points;
    } else {
        return Error{ErrorCode::missing, fmt::format("{} has nothing that could be drawn", path.string())};
    }
    truth->renderer_ = std::make_unique<render::FaceRenderer>(model);
    return truth;
}

Points TruthView::positions(std::int64_t frame) const {
    if (clip_.vertices) return clip_.vertices->frame(frame);
    if (!clip_.weights) return clip_.markers->frame(frame);
    Points points = clip_.neutral->positions;
    const float* weights = clip_.weights->frame(frame);
    for (std::size_t i = 0; i < clip_.blendshapes.size(); ++i) points += weights[i] * clip_.blendshapes[i].offsets;
    if (!clip_.head_pose.empty()) apply_pose(clip_.head_pose[std::size_t(frame)], points);
    return points;
}

Result<Image> TruthView::picture(std::int64_t frame) {
    const auto read = [this](std::int64_t at) { return clip_.texture->read(at); };
    std::optional<Result<Image>> found;
    if (reading_.valid()) {   // one reader at a time
        Result<Image> picture = reading_.get();
        if (ahead_ == frame) found = std::move(picture);
    }
    if (!found) found = read(frame);
    ahead_ = frame + 1;
    if (found->ok() && ahead_ < clip_.texture->frames()) reading_ = std::async(std::launch::async, read, ahead_);
    return std::move(*found);
}

Result<void> TruthView::show(std::int64_t frame) {
    const RigidPose pose = clip_.head_pose.empty() ? RigidPose{} : clip_.head_pose[std::size_t(frame)];
    renderer_->set_positions(positions(frame), pose);
    if (!clip_.texture || static_texture_) return {};
    const std::int64_t last = clip_.texture->frames() - 1;
    MIEN_TRY(shown, picture(std::min(frame, last)));
    renderer_->set_texture(shown);
    static_texture_ = last == 0;
    return {};
}

}  // namespace mien::player
