#include "render/detail_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "embedded_mien_render.hpp"

namespace mien::render {
namespace {

constexpr int kSquare = 16;        // texels a side: what is drawn or left out as a whole
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

void sample_nearest(const gl::Texture& texture) {
    glTextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

}  // namespace

/// A map's texels laid out as pictures.
struct DetailMap::Texels {
    int width = 0, height = 0;
    std::vector<std::array<float, 4>> domain;                     // b1, b2, triangle or -1, share
    std::vector<std::vector<std::array<float, 4>>> coefficients;  // by term

    Texels(int w, int h, int terms)
        : width(w), height(h), domain(std::size_t(w) * std::size_t(h), {0, 0, -1, 0}),
          coefficients(std::size_t(terms), std::vector<std::array<float, 4>>(std::size_t(w) * std::size_t(h))) {}

    /// Half the size each way: means of the coefficients; one of the four texels lends its place.
    Texels halved() const {
        Texels half(width / 2, height / 2, int(coefficients.size()));
        for (int y = 0; y < half.height; ++y)
            for (int x = 0; x < half.width; ++x) {
                const std::size_t to = std::size_t(y) * std::size_t(half.width) + std::size_t(x);
                int count = 0;
                float share = 0;
                for (int k = 0; k < 4; ++k) {
                    const std::size_t from = std::size_t(2 * y + k / 2) * std::size_t(width) + std::size_t(2 * x + k % 2);
                    share += domain[from][3] / 4;
                    if (domain[from][2] < 0) continue;
                    if (count++ == 0) half.domain[to] = domain[from];
                    for (std::size_t term = 0; term < coefficients.size(); ++term)
                        for (std::size_t c = 0; c < 4; ++c) half.coefficients[term][to][c] += coefficients[term][from][c];
                }
                if (count == 0) continue;
                half.domain[to][3] = share;
                for (auto& plane : half.coefficients)
                    for (float& value : plane[to]) value /= float(count);
            }
        return half;
    }
};

DetailMap::DetailMap(const model::DetailLayers& layers, const Image* still) {
    const model::DetailModel& model = layers.model();
    const model::DomainMap& domain = model.fine_domain;
    has_albedo_ = model.albedo.texels > 0;
    has_fine_ = model.fine.texels > 0;
    const int terms = model::term_count(std::max(has_fine_ ? model.fine.order : model::PolynomialOrder::constant, has_albedo_ ? model.albedo.order : model::PolynomialOrder::constant));
    program_ = gl::make_program(embedded::shaders_detail_map_vert, embedded::shaders_detail_map_frag, fmt::format("#define TERMS {}\n", terms));

    Texels texels(domain.width, domain.height, terms);
    std::vector<std::uint8_t> inside(texels.domain.size(), 0);
    for (const std::uint32_t place : domain.place) inside[place] = 1;
    const std::vector<int> depth = depths(inside, domain.width, domain.height);
    for (const auto& run : domain.runs)
        for (std::uint32_t i = run.begin; i < run.end; ++i) {
            const std::size_t place = domain.place[i];
            texels.domain[place] = {domain.b1[i], domain.b2[i], float(run.triangle), has_albedo_ ? float(depth[place]) / kFeather : 0};
            for (int k = 0; k < terms; ++k) {
                auto& to = texels.coefficients[std::size_t(k)][place];
                if (has_albedo_ && k < model::term_count(model.albedo.order))
                    for (int c = 0; c < 3; ++c) to[std::size_t(c)] = model.albedo.plane(c, k)[i];
                if (has_fine_ && k < model::term_count(model.fine.order)) to[3] = model.fine.plane(0, k)[i];
            }
        }
    FloatMap around(domain.width, domain.height, 4);
    if (still) {
        const FloatMap picture = linear(*still, domain.width, domain.height);
        for (std::size_t i = 0; i < inside.size(); ++i) std::copy_n(&picture.values[3 * i], 3, &around.values[4 * i]);
    } else {
        for (std::size_t i = 0; i < inside.size(); ++i)
            if (inside[i]) around.values[4 * i + 3] = 1, std::copy_n(texels.coefficients[0][i].data(), 3, &around.values[4 * i]);
        spread_out(around);
    }
    for (std::size_t l = 0; l < kLevels && texels.width >= kSquare && texels.height >= kSquare; ++l) {
        make_level(texels, around, terms);
        texels = texels.halved();
        FloatMap half(around.width / 2, around.height / 2, 4);
        for (int y = 0; y < half.height; ++y)
            for (int x = 0; x < half.width; ++x)
                for (int c = 0; c < 4; ++c)
                    half.at(x, y)[c] = (around.at(2 * x, 2 * y)[c] + around.at(2 * x + 1, 2 * y)[c] + around.at(2 * x, 2 * y + 1)[c] + around.at(2 * x + 1, 2 * y + 1)[c]) / 4;
        around = std::move(half);
    }
}

void DetailMap::make_level(const Texels& texels, const FloatMap& still, int terms) {
    Level level;
    const int w = level.width = texels.width, h = level.height = texels.height;
    level.domain = gl::make_texture(GL_TEXTURE_2D);
    glTextureStorage2D(level.domain.id(), 1, GL_RGBA32F, w, h);
    glTextureSubImage2D(level.domain.id(), 0, 0, 0, w, h, GL_RGBA, GL_FLOAT, texels.domain.data());
    level.still = gl::make_texture(GL_TEXTURE_2D);
    glTextureStorage2D(level.still.id(), 1, GL_RGBA16F, w, h);
    glTextureSubImage2D(level.still.id(), 0, 0, 0, w, h, GL_RGBA, GL_FLOAT, still.values.data());
    level.coefficients = gl::make_texture(GL_TEXTURE_2D_ARRAY);
    glTextureStorage3D(level.coefficients.id(), 1, GL_RGBA32F, w, h, terms);
    for (int k = 0; k < terms; ++k) glTextureSubImage3D(level.coefficients.id(), 0, 0, 0, k, w, h, 1, GL_RGBA, GL_FLOAT, texels.coefficients[std::size_t(k)].data());
    for (const gl::Texture* texture : {&level.domain, &level.still, &level.coefficients}) sample_nearest(*texture);

    level.value = gl::make_texture(GL_TEXTURE_2D);
    glTextureStorage2D(level.value.id(), 1, GL_RGBA16F, w, h);
    glTextureParameteri(level.value.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(level.value.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(level.value.id(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(level.value.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    std::vector<std::array<float, 4>> start(texels.domain.size());
    for (std::size_t i = 0; i < start.size(); ++i) start[i] = {still.values[4 * i], still.values[4 * i + 1], still.values[4 * i + 2], 0};
    glTextureSubImage2D(level.value.id(), 0, 0, 0, w, h, GL_RGBA, GL_FLOAT, start.data());
    level.target = gl::make_framebuffer();
    glNamedFramebufferTexture(level.target.id(), GL_COLOR_ATTACHMENT0, level.value.id(), 0);

    // What lies outside these squares never changes.
    std::vector<std::array<float, 2>> corners;
    for (int y = 0; y < h; y += kSquare)
        for (int x = 0; x < w; x += kSquare) {
            bool any = false;
            for (int j = y; j < std::min(y + kSquare, h); ++j)
                for (int i = x; i < std::min(x + kSquare, w); ++i) any |= texels.domain[std::size_t(j) * std::size_t(w) + std::size_t(i)][2] >= 0;
            if (!any) continue;
            const float x0 = float(x) / float(w), x1 = float(std::min(x + kSquare, w)) / float(w), y0 = float(y) / float(h), y1 = float(std::min(y + kSquare, h)) / float(h);
            for (const auto& [px, py] : {std::pair{x0, y0}, {x1, y0}, {x1, y1}, {x0, y0}, {x1, y1}, {x0, y1}}) corners.push_back({px, py});
        }
    level.corner_count = GLsizei(corners.size());
    level.squares = gl::make_buffer(sizeof corners[0] * corners.size(), corners.data());
    level.layout = gl::make_vertex_array();
    glVertexArrayVertexBuffer(level.layout.id(), 0, level.squares.id(), 0, sizeof corners[0]);
    glVertexArrayAttribFormat(level.layout.id(), 0, 2, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(level.layout.id(), 0, 0);
    glEnableVertexArrayAttrib(level.layout.id(), 0);
    levels_.push_back(std::move(level));
}

void DetailMap::evaluate(const gl::Buffer& parameters, float texels_per_pixel) {
    shown_ = 0;
    while (shown_ + 1 < levels_.size() && texels_per_pixel > 1.5f * float(1 << shown_)) ++shown_;
    if (levels_.empty()) return;
    Level& level = levels_[shown_];
    if (parameters_buffer_ != parameters.id()) {
        parameters_ = gl::make_texture(GL_TEXTURE_BUFFER);
        glTextureBuffer(parameters_.id(), GL_RGBA32F, parameters.id());
        parameters_buffer_ = parameters.id();
    }
    glBindFramebuffer(GL_FRAMEBUFFER, level.target.id());
    glViewport(0, 0, level.width, level.height);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glBindTextureUnit(0, level.domain.id());
    glBindTextureUnit(1, parameters_.id());
    glBindTextureUnit(2, level.coefficients.id());
    glBindTextureUnit(3, level.still.id());
    program_.use();
    glBindVertexArray(level.layout.id());
    glDrawArrays(GL_TRIANGLES, 0, level.corner_count);
    glEnable(GL_DEPTH_TEST);
}

void DetailMap::bind(GLuint unit) const {
    if (!levels_.empty()) glBindTextureUnit(unit, levels_[shown_].value.id());
}

FloatMap DetailMap::read() const {
    const Level& level = levels_.at(shown_);
    FloatMap map(level.width, level.height, 4);
    glGetTextureImage(level.value.id(), 0, GL_RGBA, GL_FLOAT, GLsizei(sizeof(float) * map.values.size()), map.values.data());
    return map;
}

}  // namespace mien::render
