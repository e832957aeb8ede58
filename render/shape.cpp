#include "render/shape.hpp"

#include <algorithm>
#include <cassert>

#include "core/environment_error.hpp"
#include "embedded_mien_render.hpp"

namespace mien::render {
namespace {

constexpr int kGroupSize = 64;  // local_size_x of both compute shaders

struct Rings {
    std::vector<std::uint32_t> start;                    // V + 1
    std::vector<std::array<std::uint32_t, 2>> corners;
};

Rings rings_of(std::uint32_t V, const std::vector<Triangle>& triangles) {
    Rings rings;
    rings.start.assign(V + 1, 0);
    for (const Triangle& t : triangles)
        for (const std::uint32_t v : t) ++rings.start[v + 1];
    for (std::uint32_t v = 0; v < V; ++v) rings.start[v + 1] += rings.start[v];
    rings.corners.resize(rings.start[V]);
    std::vector<std::uint32_t> next(rings.start.begin(), rings.start.end() - 1);
    for (const Triangle& t : triangles)
        for (int i = 0; i < 3; ++i) rings.corners[next[t[i]]++] = {t[(i + 1) % 3], t[(i + 2) % 3]};
    return rings;
}

const std::vector<Triangle>& triangles_of(const model::FaceModel& model) {
    const auto* points = std::get_if<model::PointBase>(&model.base);
    return points ? points->triangulation : model.neutral.triangles;
}

void dispatch(int count) {
    glDispatchCompute(GLuint(count + kGroupSize - 1) / kGroupSize, 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
}

Points read_points(const gl::Buffer& buffer, int count) {
    Points points(count, 3);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffer.id(), 0, GLsizeiptr(sizeof(float)) * points.size(), points.data());
    return points;
}

}  // namespace

Shape::Shape(const model::FaceModel& model, const model::LinearMotion& composed)
    : count_(int(model.point_count())), components_(int(composed.size())), spread_(composed.spread) {
    shape_ = gl::make_compute(embedded::shaders_shape_comp);
    normals_program_ = gl::make_compute(embedded::shaders_normals_comp);

    const Points& neutral = model::neutral_points(model);
    const std::size_t bytes = sizeof(float) * neutral.size();
    positions_ = gl::make_buffer(bytes, neutral.data());
    position_texels_ = gl::make_texels(GL_RGB32F, positions_);
    normals_ = gl::make_buffer(bytes);
    normal_texels_ = gl::make_texels(GL_RGB32F, normals_);
    neutral_ = gl::make_buffer(bytes, neutral.data());
    neutral_texels_ = gl::make_texels(GL_RGB32F, neutral_);
    Points start = neutral;
    if (composed.dimension() != 0) {
        assert(composed.dimension() == neutral.size());
        start += ConstPointsMap(composed.mean.data(), neutral.rows(), 3);
    }
    neutral_and_mean_ = gl::make_buffer(bytes, start.data());
    weights_ = gl::make_buffer(sizeof(float) * components_);

    GLint64 largest = 0;
    GLint most_texels = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most_texels);
    const auto texels = std::size_t(neutral.rows());
    if (bytes > std::size_t(largest))
        throw EnvironmentError("this OpenGL driver's buffers are too small for a mesh of this size");
    per_buffer_ = bytes ? std::max(1, int(std::min<std::size_t>(std::size_t(most_texels) / texels, 1 << 20))) : 1;
    for (int first = 0; first < components_; first += per_buffer_) {
        const int here = std::min(per_buffer_, components_ - first);
        component_blocks_.push_back(gl::make_buffer(bytes * here, composed.components.col(first).data()));
        component_texels_.push_back(gl::make_texels(GL_RGB32F, component_blocks_.back()));
    }

    std::vector<std::uint32_t> eye_of(count_, 0);
    for (std::uint32_t side = 0; side < 2; ++side)
        if (const auto& eye = model.eyes[side]) {
            eye_centre_[side] = eye->centre;
            for (const std::uint32_t v : eye->vertices) eye_of[v] = side + 1;
        }
    eye_of_ = gl::make_buffer(sizeof(std::uint32_t) * eye_of.size(), eye_of.data());

    if (!model.lids.empty()) {
        struct Member {  // as in lids.comp
            float centre[3], rest;
            std::uint32_t vertex;
            float hold;
            float padding[2];
        };
        std::vector<Member> members;
        for (const model::Lid& lid : model.lids)
            for (const auto& member : lid.members)
                members.push_back({{lid.centre.x(), lid.centre.y(), lid.centre.z()}, (neutral.row(member.vertex).transpose() - lid.centre).norm(), member.vertex, member.hold, {}});
        lids_program_ = gl::make_compute(embedded::shaders_lids_comp);
        lid_members_ = int(members.size());
        lids_ = gl::make_buffer(sizeof members[0] * members.size(), members.data());
    }
    if (!model.contacts.empty()) contact_ = gl::make_compute(embedded::shaders_contact_comp);
    for (const model::Contact& contact : model.contacts) {
        static_assert(sizeof(model::Contact::Member) == 8, "as in contact.comp");
        assert(contact.pairs.size() <= model::kMaxContactPairs);
        contacts_.push_back({gl::make_buffer(sizeof contact.pairs[0] * contact.pairs.size(), contact.pairs.data()),
                             gl::make_buffer(sizeof contact.members[0] * contact.members.size(), contact.members.data()), int(contact.pairs.size()),
                             int(contact.members.size())});
    }

    if (model.detail) detail_.emplace(*model.detail);
    if (composed.corrected) correct_ = gl::make_compute(embedded::shaders_correct_comp);

    const Rings rings = rings_of(std::uint32_t(count_), triangles_of(model));
    ring_start_ = gl::make_buffer(sizeof rings.start[0] * rings.start.size(), rings.start.data());
    ring_start_texels_ = gl::make_texels(GL_R32UI, ring_start_);
    ring_ = gl::make_buffer(sizeof rings.corners[0] * rings.corners.size(), rings.corners.data());
    ring_texels_ = gl::make_texels(GL_RG32UI, ring_);
    form_normals();
}

void Shape::form(const model::Motion& motion, const ShapeSteps& steps) {
    const bool moves = steps.motion && components_ > 0;
    const bool corrects = steps.motion && !motion.corrections.empty();
    assert(!moves || motion.coefficients.size() == components_);
    pose_ = steps.pose ? motion.pose : RigidPose{};
    if (moves) glNamedBufferSubData(weights_.id(), 0, GLsizeiptr(sizeof(float)) * components_, motion.coefficients.data());
    if (corrects) correct(model::drawn_corrections(spread_, motion.corrections));
    for (int side = 0; side < 2; ++side) {
        const float yaw = steps.gaze ? motion.gaze.yaw[side] : 0, pitch = steps.gaze ? motion.gaze.pitch[side] : 0;
        const Eigen::Matrix3f turn =
            (Eigen::AngleAxisf(yaw, Vec3::UnitY()) * Eigen::AngleAxisf(-pitch, Vec3::UnitX())).toRotationMatrix();
        shape_.set(side == 0 ? "eye_turn[0]" : "eye_turn[1]", turn);
        shape_.set(side == 0 ? "eye_centre[0]" : "eye_centre[1]", eye_centre_[side]);
    }
    shape_.set("rotation", Eigen::Matrix3f(pose_.rotation.toRotationMatrix()));
    shape_.set("translation", pose_.translation);
    shape_.set("vertex_count", count_);
    shape_.use();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, positions_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, steps.motion ? neutral_and_mean_.id() : neutral_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, weights_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, eye_of_.id());
    const std::size_t blocks = moves ? component_blocks_.size() : 1;
    for (std::size_t b = 0; b < blocks; ++b) {
        const int first = int(b) * per_buffer_;
        shape_.set("first_component", first);
        shape_.set("component_count", moves ? std::min(per_buffer_, components_ - first) : 0);
        shape_.set("starts", int(b == 0 && !corrects));
        shape_.set("ends", int(b + 1 == blocks));
        if (moves) glBindTextureUnit(4, component_texels_[b].id());
        dispatch(count_);
    }
    if (detail_) detail_->form(positions_, pose_, steps.medium);
    if (steps.motion && lid_members_ > 0) keep_lids_on_eyeballs();
    if (steps.motion && !contacts_.empty()) hold_apart();
    form_normals();
}

void Shape::correct(std::span<const model::Correction> corrections) {
    static_assert(sizeof(model::Correction) == 8, "as in correct.comp");
    glCopyNamedBufferSubData(neutral_and_mean_.id(), positions_.id(), 0, 0, GLsizeiptr(sizeof(float)) * 3 * count_);
    if (corrections.empty()) return;
    if (corrections.size() > corrections_room_) {
        corrections_room_ = std::max(2 * corrections_room_, corrections.size());
        corrections_ = gl::make_buffer(sizeof corrections[0] * corrections_room_);
    }
    glNamedBufferSubData(corrections_.id(), 0, GLsizeiptr(corrections.size_bytes()), corrections.data());
    correct_.set("correction_count", int(corrections.size()));
    correct_.use();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, positions_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, corrections_.id());
    dispatch(int(corrections.size()));
}

void Shape::keep_lids_on_eyeballs() {
    lids_program_.set("member_count", lid_members_);
    lids_program_.set("rotation", Eigen::Matrix3f(pose_.rotation.toRotationMatrix()));
    lids_program_.set("translation", pose_.translation);
    lids_program_.use();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, positions_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, lids_.id());
    dispatch(lid_members_);
}

void Shape::hold_apart() {
    contact_.set("rotation", Eigen::Matrix3f(pose_.rotation.toRotationMatrix()));
    contact_.set("translation", pose_.translation);
    contact_.set("reach", model::kContactReach);
    contact_.set("softness", model::kContactSoftness);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, positions_.id());
    for (const Contact& contact : contacts_) {
        contact_.set("pair_count", contact.pair_count);
        contact_.set("member_count", contact.member_count);
        contact_.use();
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, contact.pairs.id());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, contact.members.id());
        dispatch(1);
    }
}

void Shape::form(PointsRef positions, const RigidPose& pose) {
    assert(positions.rows() == count_);
    pose_ = pose;
    const Points packed = positions;
    glNamedBufferSubData(positions_.id(), 0, GLsizeiptr(sizeof(float)) * packed.size(), packed.data());
    form_normals();
}

void Shape::form_normals() {
    normals_program_.set("vertex_count", count_);
    normals_program_.use();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, normals_.id());
    glBindTextureUnit(4, position_texels_.id());
    glBindTextureUnit(5, ring_start_texels_.id());
    glBindTextureUnit(6, ring_texels_.id());
    dispatch(count_);
}

void Shape::bind_texels(GLuint unit) const {
    glBindTextureUnit(unit, position_texels_.id());
    glBindTextureUnit(unit + 1, normal_texels_.id());
    glBindTextureUnit(unit + 2, neutral_texels_.id());
}

Points Shape::read_positions() const { return read_points(positions_, count_); }
Points Shape::read_normals() const { return read_points(normals_, count_); }

}  // namespace mien::render
