#include "render/detail_shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "embedded_mien_render.hpp"

namespace mien::render {
namespace {

constexpr int kGroupSize = 64;          // local_size_x of the compute shaders
constexpr std::size_t kParameters = 12; // floats per marker triangle

/// As in deformation.comp: scalars alone, so that std430 packs it like C++.
struct Marker {
    std::array<std::uint32_t, 3> corner;
    std::array<float, 3> share, neutral, u, v;
    std::array<float, 2> spread;
    std::array<float, model::kDeformationSize> q, r;
    float extent;
    std::uint32_t near_begin, near_end;
};
static_assert(sizeof(Marker) == 30 * 4);

struct Moved {
    std::uint32_t vertex, begin, end;
};
struct Texel {
    float weight;
    std::uint32_t triangle;
    float b1, b2;
};

void dispatch(int count) {
    glDispatchCompute(GLuint(count + kGroupSize - 1) / kGroupSize, 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
}

template <class T>
gl::Buffer buffer_of(const std::vector<T>& values) {
    return gl::make_buffer(sizeof(T) * values.size(), values.data());
}

std::array<float, 3> row(const Points& points, Eigen::Index i) { return {points(i, 0), points(i, 1), points(i, 2)}; }

}  // namespace

DetailShape::DetailShape(const model::DetailLayers& layers) {
    deformation_program_ = gl::make_compute(embedded::shaders_deformation_comp);
    parameters_program_ = gl::make_compute(embedded::shaders_parameters_comp);
    make_markers(layers);
    const std::vector<Triangle>& triangles = layers.model().marker_triangles;
    triangle_count_ = int(triangles.size());
    triangles_ = buffer_of(triangles);
    deformations_ = gl::make_buffer(sizeof(float) * model::kDeformationSize * std::size_t(marker_count_));
    parameters_ = gl::make_buffer(sizeof(float) * kParameters * triangles.size());
    parameter_texels_ = gl::make_texels(GL_RGBA32F, parameters_);
    if (layers.model().medium.texels > 0) {
        medium_program_ = gl::make_compute(embedded::shaders_medium_comp, fmt::format("#define TERMS {}\n", model::term_count(layers.model().medium.order)));
        make_moved(layers);
    }
}

void DetailShape::make_markers(const model::DetailLayers& layers) {
    const model::DetailModel& model = layers.model();
    const model::MarkerMesh& mesh = layers.meter().mesh();
    std::vector<Marker> markers;
    std::vector<std::uint32_t> near;
    for (std::size_t m = 0; m < model.sites.size(); ++m) {
        const auto i = Eigen::Index(m);
        Marker marker{};
        for (std::size_t k = 0; k < 3; ++k) marker.corner[k] = model.sites[m].vertices[k], marker.share[k] = model.sites[m].weights[k];
        marker.neutral = row(mesh.neutral, i);
        marker.u = row(mesh.u, i);
        marker.v = row(mesh.v, i);
        marker.spread = {layers.meter().neutral_spread(m).x(), layers.meter().neutral_spread(m).y()};
        for (int k = 0; k < model::kDeformationSize; ++k) marker.q[std::size_t(k)] = model.axes.q(i, k), marker.r[std::size_t(k)] = model.axes.r(i, k);
        marker.extent = model.axes.extents.size() > 0 ? model.axes.extents[i] : std::numeric_limits<float>::max();
        marker.near_begin = std::uint32_t(near.size());
        const auto& neighbourhood = layers.meter().neighbourhood(m);
        near.insert(near.end(), neighbourhood.begin(), neighbourhood.end());
        marker.near_end = std::uint32_t(near.size());
        markers.push_back(marker);
    }
    marker_count_ = int(markers.size());
    markers_ = buffer_of(markers);
    near_ = buffer_of(near);
}

void DetailShape::make_moved(const model::DetailLayers& layers) {
    const model::DomainMap& domain = layers.model().medium_domain;
    std::vector<std::uint32_t> triangle(domain.size());
    for (const auto& run : domain.runs) std::fill(triangle.begin() + run.begin, triangle.begin() + run.end, run.triangle);
    std::vector<Moved> moved;
    std::vector<Texel> texels;
    for (std::uint32_t v = 0; v < layers.model().neutral.vertex_count(); ++v) {
        const model::DomainSampler::Sample& sample = layers.medium_surface().sample(v);
        if (sample.count == 0) continue;
        const auto begin = std::uint32_t(texels.size());
        for (int k = 0; k < sample.count; ++k) {
            const std::uint32_t i = sample.texel[k];
            texels.push_back({sample.weight[k], triangle[i], domain.b1[i], domain.b2[i]});
        }
        moved.push_back({v, begin, std::uint32_t(texels.size())});
    }
    moved_count_ = int(moved.size());
    moved_ = buffer_of(moved);
    places_ = buffer_of(texels);
    place_texels_ = gl::make_texels(GL_RGBA32F, places_);
    coefficients_ = buffer_of(medium_coefficients(layers.model(), layers.medium_surface()));
    coefficient_texels_ = gl::make_texels(GL_RGB32F, coefficients_);
}

bool DetailShape::take(const std::vector<float>& medium, std::size_t& budget) {
    if (!coming_) coming_ = gl::make_buffer(sizeof medium[0] * medium.size());
    const std::size_t now = std::min(medium.size() - taken_, budget / sizeof medium[0]);
    glNamedBufferSubData(coming_.id(), GLintptr(sizeof medium[0] * taken_), GLsizeiptr(sizeof medium[0] * now), medium.data() + taken_);
    budget -= sizeof medium[0] * now;
    if ((taken_ += now) < medium.size()) return false;
    coefficients_ = std::exchange(coming_, gl::Buffer());
    coefficient_texels_ = gl::make_texels(GL_RGB32F, coefficients_);
    taken_ = 0;
    return true;
}

void DetailShape::form(const gl::Buffer& positions, const RigidPose& pose, bool medium) {
    const Eigen::Matrix3f rotation = pose.rotation.toRotationMatrix();
    deformation_program_.set("marker_count", marker_count_);
    deformation_program_.set("rotation", rotation);
    deformation_program_.set("translation", pose.translation);
    deformation_program_.use();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, positions.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, markers_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, near_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, deformations_.id());
    dispatch(marker_count_);

    parameters_program_.set("triangle_count", triangle_count_);
    parameters_program_.use();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, triangles_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, parameters_.id());
    dispatch(triangle_count_);

    if (!medium || moved_count_ == 0) return;
    medium_program_.set("moved_count", moved_count_);
    medium_program_.set("rotation", rotation);
    medium_program_.use();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, moved_.id());
    glBindTextureUnit(4, place_texels_.id());
    glBindTextureUnit(5, coefficient_texels_.id());
    glBindTextureUnit(6, parameter_texels_.id());
    dispatch(moved_count_);
}

model::DomainParameters DetailShape::read_parameters() const {
    std::vector<float> values(kParameters * std::size_t(triangle_count_));
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(parameters_.id(), 0, GLsizeiptr(sizeof(float) * values.size()), values.data());
    model::DomainParameters parameters;
    for (std::size_t t = 0; t < std::size_t(triangle_count_); ++t) {
        auto& d1 = parameters.d1.emplace_back();
        auto& d2 = parameters.d2.emplace_back();
        std::copy_n(&values[kParameters * t], 6, d1.c);
        std::copy_n(&values[kParameters * t + 6], 6, d2.c);
    }
    return parameters;
}

}  // namespace mien::render
