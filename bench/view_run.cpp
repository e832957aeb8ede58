#include "bench/view_run.hpp"

#include "render/still.hpp"

namespace mien::bench {
namespace {

constexpr int kWidth = 480, kHeight = 540;
constexpr std::array<render::View, 3> kViews{render::View::front, render::View::left, render::View::right};

struct TruePicture {
    Image picture;
    std::vector<std::uint8_t> face;  ///< pixels that the mesh covers
};

}  // namespace

struct ViewComparison::State {
    explicit State(const Clip& clip_) : clip(clip_), still(*clip.neutral) {}

    Image draw(render::View view, const render::Look& look = {}) {
        const auto box = render::bounding_box(clip.neutral->positions);
        return still.picture(render::frame_box(box, float(kWidth) / kHeight, view).camera(), kWidth, kHeight, look,
                             render::Smoothing::none);
    }

    const Clip& clip;
    render::StillRenderer still;
    std::vector<std::int64_t> frames;
    std::vector<TruePicture> truth;  ///< by frame, then view
};

ViewComparison::ViewComparison(std::unique_ptr<State> state) : state_(std::move(state)) {}
ViewComparison::~ViewComparison() = default;
const std::vector<std::int64_t>& ViewComparison::frames() const {
    return state_->frames;
}

Result<std::unique_ptr<ViewComparison>> ViewComparison::create(const Clip& clip, std::int64_t pictures) {
    auto state = std::make_unique<State>(clip);
    State& s = *state;
    const std::int64_t count = std::min(pictures, clip.frame_count());
    for (std::int64_t i = 0; i < count; ++i) s.frames.push_back((2 * i + 1) * clip.frame_count() / (2 * count));
    render::Look silhouette;
    silhouette.lit = silhouette.texture = silhouette.shadows = silhouette.backdrop = false;
    for (const std::int64_t frame : s.frames) {
        MIEN_TRY(texture, clip.texture->read(frame));
        s.still.set_texture(texture);
        s.still.set_positions(clip.vertices->frame(frame));
        for (const render::View view : kViews) {
            TruePicture truth;
            truth.picture = s.draw(view);
            const Image shape = s.draw(view, silhouette);
            for (std::size_t i = 0; i < std::size_t(kWidth) * kHeight; ++i)
                truth.face.push_back(shape.pixels[3 * i] + shape.pixels[3 * i + 1] + shape.pixels[3 * i + 2] > 0);
            s.truth.push_back(std::move(truth));
        }
    }
    return std::unique_ptr<ViewComparison>(new ViewComparison(std::move(state)));
}

Result<std::vector<Points>> ViewComparison::sample(GeometryStream& stream) const {
    MIEN_CHECK(stream.start());
    std::vector<Points> sampled;
    Points positions(state_->clip.vertices->points, 3);
    for (std::int64_t f = 0; sampled.size() < state_->frames.size(); ++f) {
        MIEN_CHECK(stream.decode(f, {positions.data(), std::size_t(positions.size())}));
        if (f == state_->frames[sampled.size()]) sampled.push_back(positions);
    }
    return sampled;
}

PictureScore ViewComparison::compare(const std::vector<Points>& positions, const std::vector<Image>& textures) {
    PictureScore score;
    std::size_t number = 0;
    for (std::size_t i = 0; i < state_->frames.size(); ++i) {
        state_->still.set_texture(textures[i]);
        state_->still.set_positions(positions[i]);
        for (const render::View view : kViews) {
            const TruePicture& truth = state_->truth[number++];
            score.add(truth.picture, state_->draw(view), truth.face);
        }
    }
    return score;
}

}  // namespace mien::bench
