#include "render/detail_pictures.hpp"

#include <algorithm>
#include <cmath>

namespace mien::render {
namespace {

using Level = DetailPictures::Level;

constexpr int kSmallest = 16;      // texels a side of the coarsest level
constexpr int kFeather = 12;       // texels over which the map gives way to what is around it
constexpr std::size_t kLevels = 3;

FloatMap linear(const Image& picture, int width, int height) {
    FloatMap map(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            // Bilinear, in the middle of each texel.
            const float px = std::max(0.0f, (float(x) + 0.5f) * float(picture.width) / float(width) - 0.5f);
            const float py = std::max(0.0f, (float(y) + 0.5f) * float(picture.height) / float(height) - 0.5f);
            const int x0 = int(px), y0 = int(py), x1 = std::min(x0 + 1, picture.width - 1), y1 = std::min(y0 + 1, picture.height - 1);
            const float fx = px - float(x0), fy = py - float(y0);
            for (int c = 0; c < 3; ++c) {
                const auto at = [&](int i, int j) { return srgb_to_linear(float(picture.at(i, j)[picture.channels > 2 ? c : 0]) / 255); };
                map.at(x, y)[c] = (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x1, y0)) + fy * ((1 - fx) * at(x0, y1) + fx * at(x1, y1));
            }
        }
    return map;
}

/// Fills the texels with weight 0 (the last of 4 channels) from ever coarser means of those that have colour.
void spread_out(FloatMap& map) {
    if (map.width < 2 || map.height < 2) return;
    FloatMap coarse((map.width + 1) / 2, (map.height + 1) / 2, 4);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            for (int c = 0; c < 4; ++c) coarse.at(x / 2, y / 2)[c] += map.at(x, y)[3] * (c < 3 ? map.at(x, y)[c] : 1);
    for (std::size_t i = 0; i < coarse.values.size(); i += 4) {
        const float weight = coarse.values[i + 3];
        if (weight <= 0) continue;
        for (std::size_t c = 0; c < 3; ++c) coarse.values[i + c] /= weight;
        coarse.values[i + 3] = 1;
    }
    spread_out(coarse);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (map.at(x, y)[3] <= 0) std::copy_n(coarse.at(x / 2, y / 2), 3, map.at(x, y));
}

/// How many texels deep inside the domain each texel lies, at most kFeather: two passes of a chessboard distance.
std::vector<int> depths(const std::vector<std::uint8_t>& inside, int width, int height) {
    std::vector<int> depth(inside.size());
    const auto relax = [&](int x, int y, int dx, int dy) {
        int& here = depth[std::size_t(y) * std::size_t(width) + std::size_t(x)];
        const int i = x + dx, j = y + dy;
        here = std::min(here, 1 + (i < 0 || j < 0 || i >= width || j >= height ? 0 : depth[std::size_t(j) * std::size_t(width) + std::size_t(i)]));
    };
    for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = inside[i] ? kFeather : 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (const auto& [dx, dy] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}) relax(x, y, dx, dy);
    for (int y = height; y-- > 0;)
        for (int x = width; x-- > 0;)
            for (const auto& [dx, dy] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) relax(x, y, dx, dy);
    return depth;
}

/// Half the size each way: means of the coefficients and of what is around; one of the four texels lends its place.
Level halved(const Level& full) {
    Level half(full.width / 2, full.height / 2, int(full.coefficients.size()));
    for (int y = 0; y < half.height; ++y)
        for (int x = 0; x < half.width; ++x) {
            const std::size_t to = std::size_t(y) * std::size_t(half.width) + std::size_t(x);
            int count = 0;
            float share = 0;
            for (int k = 0; k < 4; ++k) {
                const std::size_t from = std::size_t(2 * y + k / 2) * std::size_t(full.width) + std::size_t(2 * x + k % 2);
                share += full.domain[from][3] / 4;
                for (std::size_t c = 0; c < 3; ++c) half.still[to][c] += full.still[from][c] / 4;
                if (full.domain[from][2] < 0) continue;
                if (count++ == 0) half.domain[to] = full.domain[from];
                for (std::size_t term = 0; term < full.coefficients.size(); ++term)
                    for (std::size_t c = 0; c < 4; ++c) half.coefficients[term][to][c] += full.coefficients[term][from][c];
            }
            if (count == 0) continue;
            half.domain[to][3] = share;
            for (auto& plane : half.coefficients)
                for (float& value : plane[to]) value /= float(count);
        }
    return half;
}

}  // namespace

DetailPictures::Level::Level(int w, int h, int terms)
    : width(w), height(h), domain(std::size_t(w) * std::size_t(h), {0, 0, -1, 0}), still(domain.size()),
      coefficients(std::size_t(terms), std::vector<Texel>(domain.size())) {}

std::vector<Level> map_pictures(const model::DetailModel& model, const Image* still) {
    const model::DomainMap& domain = model.fine_domain;
    const bool has_albedo = model.albedo.texels > 0, has_fine = model.fine.texels > 0;
    const auto order_of = [](const model::PolynomialMap& map) { return map.texels > 0 ? map.order : model::PolynomialOrder::constant; };
    const int terms = model::term_count(std::max(order_of(model.fine), order_of(model.albedo)));

    Level full(domain.width, domain.height, terms);
    std::vector<std::uint8_t> inside(full.domain.size(), 0);
    for (const std::uint32_t place : domain.place) inside[place] = 1;
    const std::vector<int> depth = depths(inside, domain.width, domain.height);
    for (const auto& run : domain.runs)
        for (std::uint32_t i = run.begin; i < run.end; ++i) {
            const std::size_t place = domain.place[i];
            full.domain[place] = {domain.b1[i], domain.b2[i], float(run.triangle), has_albedo ? float(depth[place]) / kFeather : 0};
            for (int k = 0; k < terms; ++k) {
                auto& to = full.coefficients[std::size_t(k)][place];
                if (has_albedo && k < model::term_count(model.albedo.order))
                    for (int c = 0; c < 3; ++c) to[std::size_t(c)] = model.albedo.plane(c, k)[i];
                if (has_fine && k < model::term_count(model.fine.order)) to[3] = model.fine.plane(0, k)[i];
            }
        }
    FloatMap around(domain.width, domain.height, 4);
    if (still) {
        const FloatMap picture = linear(*still, domain.width, domain.height);
        for (std::size_t i = 0; i < inside.size(); ++i) std::copy_n(&picture.values[3 * i], 3, &around.values[4 * i]);
    } else {
        for (std::size_t i = 0; i < inside.size(); ++i)
            if (inside[i]) around.values[4 * i + 3] = 1, std::copy_n(full.coefficients[0][i].data(), 3, &around.values[4 * i]);
        spread_out(around);
    }
    for (std::size_t i = 0; i < inside.size(); ++i) std::copy_n(&around.values[4 * i], 3, full.still[i].data());

    std::vector<Level> levels;
    levels.push_back(std::move(full));
    while (levels.size() < kLevels && std::min(levels.back().width, levels.back().height) / 2 >= kSmallest) levels.push_back(halved(levels.back()));
    return levels;
}

std::vector<float> medium_coefficients(const model::DetailModel& model, const model::MediumSurface& surface) {
    const model::PolynomialMap& map = model.medium;
    std::vector<float> coefficients;
    if (map.texels == 0) return coefficients;
    for (std::uint32_t v = 0; v < model.neutral.vertex_count(); ++v) {
        const model::DomainSampler::Sample& sample = surface.sample(v);
        for (int k = 0; k < sample.count; ++k)
            for (int term = 0; term < model::term_count(map.order); ++term)
                for (int c = 0; c < map.channels; ++c) coefficients.push_back(map.plane(c, term)[sample.texel[k]]);
    }
    return coefficients;
}

}  // namespace mien::render
