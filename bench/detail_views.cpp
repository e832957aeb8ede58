#include "bench/detail_views.hpp"

#include <cmath>

#include "render/context.hpp"
#include "render/face_renderer.hpp"

namespace mien::bench {
namespace {

constexpr int kWidth = 640, kHeight = 720;
constexpr std::array<render::View, 3> kViews{render::View::front, render::View::left, render::View::right};
constexpr std::array<const char*, 6> kRows{"truth", "base", "medium", "medium + fine", "all", "still"};

/// Values of the three layers that one picture shows.
using Shown = std::array<const std::vector<float>*, 3>;

/// A model that stands still with these values at its texels: maps of order 0.
model::FaceModel frozen(const model::FaceModel& face, const Shown& shown) {
    model::DetailModel detail = face.detail->model();
    const std::array<model::PolynomialMap*, 3> maps{&detail.medium, &detail.fine, &detail.albedo};
    for (std::size_t layer = 0; layer < 3; ++layer) {
        model::PolynomialMap& map = *maps[layer];
        if (map.texels == 0) continue;
        map = model::PolynomialMap(map.channels, model::PolynomialOrder::constant, map.texels);
        if (!shown[layer]->empty()) map.planes = *shown[layer];
    }
    model::FaceModel model = face;
    model.base = model::VertexBase{};
    model.detail = std::make_shared<model::DetailLayers>(std::move(detail));
    return model;
}

std::vector<std::uint8_t> covered(const Image& silhouette) {
    std::vector<std::uint8_t> face;
    for (std::size_t i = 0; i < std::size_t(kWidth) * kHeight; ++i)
        face.push_back(silhouette.pixels[3 * i] + silhouette.pixels[3 * i + 1] + silhouette.pixels[3 * i + 2] > 0);
    return face;
}

void paste(const Image& from, Image& to, int x0, int y0) {
    for (int y = 0; y < from.height; ++y)
        std::copy_n(from.pixels.begin() + std::ptrdiff_t(y) * from.width * 3, from.width * 3, to.pixels.begin() + (std::ptrdiff_t(y0 + y) * to.width + x0) * 3);
}

}  // namespace

Result<DetailViews> view_detail(const model::FaceModel& face, const analysis::ModelOnClip& pair, std::int64_t frames, std::int64_t pictures, const Progress& progress) {
    render::OffscreenContext context;
    render::Target target(kWidth, kHeight, render::Smoothing::none);
    const auto box = render::bounding_box(face.neutral.positions);
    render::Look silhouette;
    silhouette.lit = silhouette.texture = silhouette.shadows = silhouette.backdrop = false;

    DetailViews out;
    for (std::size_t row = 1; row < kRows.size(); ++row) out.rows.push_back({kRows[row], {}});
    const std::int64_t count = std::min(pictures, frames);
    float farthest = -1;
    for (std::int64_t i = 0; i < count; ++i) {
        const std::int64_t number = (2 * i + 1) * frames / (2 * count);
        out.frames.push_back(number);
        MIEN_TRY(frame, pair.frame(number));
        for (analysis::LayerValues& layer : frame.layers)
            for (std::size_t k = 0; k < layer.truth.size(); ++k)
                if (!std::isfinite(layer.truth[k])) layer.truth[k] = layer.model[k];
        const std::vector<float> none;
        const auto& [medium, fine, albedo] = frame.layers;
        const std::array<Shown, kRows.size()> shown{{{&medium.truth, &fine.truth, &albedo.truth},
                                                     {&none, &none, &albedo.still},
                                                     {&medium.model, &none, &albedo.still},
                                                     {&medium.model, &fine.model, &albedo.still},
                                                     {&medium.model, &fine.model, &albedo.model},
                                                     {&medium.still, &fine.still, &albedo.still}}};
        const Points offsets = frame.base - face.neutral.positions;
        const model::LinearMotion composed{offsets.reshaped<Eigen::RowMajor>(), Eigen::MatrixXf(offsets.size(), 0), false, {}};
        std::array<Image, kViews.size()> truth;
        std::array<std::vector<std::uint8_t>, kViews.size()> counted;
        const float way = offsets.norm();
        const bool on_sheet = way > farthest;
        if (on_sheet) out.sheet = Image(kWidth * int(kRows.size()), 2 * kHeight, 3);
        farthest = std::max(farthest, way);
        for (std::size_t row = 0; row < kRows.size(); ++row) {
            const model::FaceModel model = frozen(face, shown[row]);
            render::FaceRenderer renderer(model, composed);
            renderer.set_motion({});
            for (std::size_t v = 0; v < kViews.size(); ++v) {
                const render::Camera camera = render::frame_box(box, float(kWidth) / kHeight, kViews[v]).camera();
                const auto draw = [&](const render::Look& look) {
                    renderer.draw(camera, look, target);
                    return target.read();
                };
                const Image picture = draw({});
                if (row == 0) {
                    counted[v] = covered(draw(silhouette));
                    truth[v] = picture;
                } else {
                    out.rows[row - 1].score.add(truth[v], picture, counted[v]);
                }
                if (on_sheet && v < 2) paste(picture, out.sheet, int(row) * kWidth, int(v) * kHeight);
            }
        }
        if (progress) progress("drawing", i + 1, count);
    }
    return out;
}

}  // namespace mien::bench
