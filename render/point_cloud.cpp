#include "render/point_cloud.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>

#include "embedded_mien_render.hpp"

namespace mien::render {
namespace {

std::vector<std::uint32_t> edges_of(const std::vector<Triangle>& triangles) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const Triangle& t : triangles)
        for (int i = 0; i < 3; ++i) edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
    std::vector<std::uint32_t> indices;
    for (const auto& [a, b] : edges) indices.insert(indices.end(), {a, b});
    return indices;
}

/// A seventh of the median edge: dense clouds get small balls.
float ball_radius(const Points& markers, const std::vector<std::uint32_t>& edges) {
    std::vector<float> lengths;
    for (std::size_t i = 0; i + 1 < edges.size(); i += 2)
        lengths.push_back((markers.row(edges[i]) - markers.row(edges[i + 1])).norm());
    if (lengths.empty()) return std::max(0.5f, bounding_box(markers).diagonal().norm() / 120);
    std::nth_element(lengths.begin(), lengths.begin() + lengths.size() / 2, lengths.end());
    return std::max(0.2f, lengths[lengths.size() / 2] / 7);
}

}  // namespace

PointCloud::PointCloud(const model::PointBase& base) : count_(int(base.markers.rows())) {
    const std::vector<std::uint32_t> edges = edges_of(base.triangulation);
    radius_ = ball_radius(base.markers, edges);
    line_indices_ = GLsizei(edges.size());
    edges_ = gl::make_buffer(sizeof(std::uint32_t) * edges.size(), edges.data());
    presence_ = gl::make_buffer(sizeof(std::uint32_t) * std::size_t(count_));
    set_presence({});
    points_layout_ = gl::make_vertex_array();
    lines_layout_ = gl::make_vertex_array();
    glVertexArrayVertexBuffer(lines_layout_.id(), 0, edges_.id(), 0, sizeof(std::uint32_t));
    glVertexArrayAttribIFormat(lines_layout_.id(), 0, 1, GL_UNSIGNED_INT, 0);
    glVertexArrayAttribBinding(lines_layout_.id(), 0, 0);
    glEnableVertexArrayAttrib(lines_layout_.id(), 0);
    point_ = gl::make_program(embedded::shaders_point_vert, embedded::shaders_point_frag);
    line_ = gl::make_program(embedded::shaders_line_vert, embedded::shaders_line_frag);
}

void PointCloud::set_presence(const std::vector<std::uint8_t>& presence) {
    assert(presence.empty() || int(presence.size()) == count_);
    std::vector<std::uint32_t> wide(std::size_t(count_), 1);
    std::copy(presence.begin(), presence.end(), wide.begin());
    glNamedBufferSubData(presence_.id(), 0, GLsizeiptr(sizeof(std::uint32_t) * wide.size()), wide.data());
}

void PointCloud::draw(const gl::Buffer& positions, const Camera& camera, float aspect, int height,
                      const Lighting& lighting, bool lines_only) {
    const Eigen::Matrix4f view = camera.view(), view_projection = camera.projection(aspect) * view;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, positions.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, presence_.id());
    line_.set("view_projection", view_projection);
    line_.set("tint", Vec3(0.10f, 0.30f, 0.34f));
    line_.use();
    glBindVertexArray(lines_layout_.id());
    glDrawArrays(GL_LINES, 0, line_indices_);
    if (lines_only) return;
    point_.set("view_projection", view_projection);
    point_.set("view", view);
    point_.set("radius", radius_);
    point_.set("pixels_per_slope", float(height) / (2 * std::tan(camera.fov / 2)));
    point_.set("sky", lighting.sky);
    constexpr const char* kTowards[] = {"light_towards[0]", "light_towards[1]", "light_towards[2]"};
    constexpr const char* kColour[] = {"light_colour[0]", "light_colour[1]", "light_colour[2]"};
    for (int i = 0; i < 3; ++i) {
        point_.set(kTowards[i], lighting.lights[i].towards);
        point_.set(kColour[i], lighting.lights[i].colour);
    }
    point_.use();
    glEnable(GL_PROGRAM_POINT_SIZE);
    glBindVertexArray(points_layout_.id());
    glDrawArrays(GL_POINTS, 0, count_);
}

}  // namespace mien::render
