#include "render/detail_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

#include "embedded_mien_render.hpp"

namespace mien::render {
namespace {

constexpr int kSquare = 16;        // texels a side: what is drawn or left out as a whole

gl::Texture make_picture(GLenum format, int width, int height, GLint filter) {
    gl::Texture texture = gl::make_texture(GL_TEXTURE_2D);
    glTextureStorage2D(texture.id(), 1, format, width, height);
    glTextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, filter);
    glTextureParameteri(texture.id(), GL_TEXTURE_MAG_FILTER, filter);
    glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

}  // namespace

DetailMap::DetailMap(const model::DetailModel& model, const std::vector<DetailPictures::Level>& maps)
    : has_albedo_(model.albedo.texels > 0), has_fine_(model.fine.texels > 0) {
    assert(!maps.empty());
    program_ = gl::make_program(embedded::shaders_detail_map_vert, embedded::shaders_detail_map_frag, fmt::format("#define TERMS {}\n", maps[0].coefficients.size()));
    for (const DetailPictures::Level& map : maps) make_level(map);
    std::size_t all = std::numeric_limits<std::size_t>::max();
    take(maps, all);
}

void DetailMap::make_level(const DetailPictures::Level& map) {
    Level level;
    const int w = level.width = map.width, h = level.height = map.height;
    level.domain = make_picture(GL_RGBA32F, w, h, GL_NEAREST);
    glTextureSubImage2D(level.domain.id(), 0, 0, 0, w, h, GL_RGBA, GL_FLOAT, map.domain.data());

    // What lies outside these squares never changes.
    std::vector<std::array<float, 2>> corners;
    for (int y = 0; y < h; y += kSquare)
        for (int x = 0; x < w; x += kSquare) {
            bool any = false;
            for (int j = y; j < std::min(y + kSquare, h); ++j)
                for (int i = x; i < std::min(x + kSquare, w); ++i) any |= map.domain[std::size_t(j) * std::size_t(w) + std::size_t(i)][2] >= 0;
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

DetailMap::Pictures DetailMap::make_pictures(const DetailPictures::Level& map) {
    Pictures pictures;
    pictures.still = make_picture(GL_RGBA16F, map.width, map.height, GL_NEAREST);
    pictures.coefficients = gl::make_texture(GL_TEXTURE_2D_ARRAY);
    glTextureStorage3D(pictures.coefficients.id(), 1, GL_RGBA32F, map.width, map.height, GLsizei(map.coefficients.size()));
    glTextureParameteri(pictures.coefficients.id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(pictures.coefficients.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    pictures.value = make_picture(GL_RGBA16F, map.width, map.height, GL_LINEAR);
    pictures.target = gl::make_framebuffer();
    glNamedFramebufferTexture(pictures.target.id(), GL_COLOR_ATTACHMENT0, pictures.value.id(), 0);
    return pictures;
}

bool DetailMap::take(const std::vector<DetailPictures::Level>& maps, std::size_t& budget) {
    assert(maps.size() == levels_.size());
    while (taken_.level < maps.size()) {
        const DetailPictures::Level& map = maps[taken_.level];
        const std::size_t terms = map.coefficients.size(), row_bytes = sizeof map.still[0] * std::size_t(map.width);
        assert(map.width == levels_[taken_.level].width && map.height == levels_[taken_.level].height);
        if (budget < row_bytes) return false;
        if (coming_.size() == taken_.level) coming_.push_back(make_pictures(map));
        const Pictures& to = coming_.back();
        const int rows = int(std::min(budget / row_bytes, std::size_t(map.height - taken_.row)));
        const std::size_t from = std::size_t(taken_.row) * std::size_t(map.width);
        if (taken_.picture < terms)
            glTextureSubImage3D(to.coefficients.id(), 0, 0, taken_.row, GLint(taken_.picture), map.width, rows, 1, GL_RGBA, GL_FLOAT, &map.coefficients[taken_.picture][from]);
        else
            glTextureSubImage2D(to.still.id(), 0, 0, taken_.row, map.width, rows, GL_RGBA, GL_FLOAT, &map.still[from]);
        budget -= std::size_t(rows) * row_bytes;
        if ((taken_.row += rows) < map.height) continue;
        taken_.row = 0;
        if (++taken_.picture <= terms) continue;
        // What no square covers keeps this value.
        glCopyImageSubData(to.still.id(), GL_TEXTURE_2D, 0, 0, 0, 0, to.value.id(), GL_TEXTURE_2D, 0, 0, 0, 0, map.width, map.height, 1);
        taken_.picture = 0;
        ++taken_.level;
    }
    for (std::size_t l = 0; l < levels_.size(); ++l) levels_[l].pictures = std::move(coming_[l]);
    coming_.clear();
    taken_ = {};
    return true;
}

void DetailMap::evaluate(const gl::Texture& parameters, float texels_per_pixel) {
    shown_ = 0;
    while (shown_ + 1 < levels_.size() && texels_per_pixel > 1.5f * float(1 << shown_)) ++shown_;
    Level& level = levels_[shown_];
    glBindFramebuffer(GL_FRAMEBUFFER, level.pictures.target.id());
    glViewport(0, 0, level.width, level.height);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glBindTextureUnit(0, level.domain.id());
    glBindTextureUnit(1, parameters.id());
    glBindTextureUnit(2, level.pictures.coefficients.id());
    glBindTextureUnit(3, level.pictures.still.id());
    program_.use();
    glBindVertexArray(level.layout.id());
    glDrawArrays(GL_TRIANGLES, 0, level.corner_count);
    glEnable(GL_DEPTH_TEST);
}

void DetailMap::bind(GLuint unit) const { glBindTextureUnit(unit, levels_[shown_].pictures.value.id()); }

FloatMap DetailMap::read() const {
    const Level& level = levels_.at(shown_);
    FloatMap map(level.width, level.height, 4);
    glGetTextureImage(level.pictures.value.id(), 0, GL_RGBA, GL_FLOAT, GLsizei(sizeof(float) * map.values.size()), map.values.data());
    return map;
}

}  // namespace mien::render
