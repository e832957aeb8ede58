#pragma once

#include <optional>
#include <vector>

#include "model/face_model.hpp"
#include "render/detail_shape.hpp"
#include "render/gl.hpp"
#include "render/shape_steps.hpp"

namespace mien::render {

/// The drawn points of a face model on the GPU. Static parts are uploaded once; a frame costs its coefficients and corrections.
class Shape {
public:
    Shape(const model::FaceModel& model, const model::LinearMotion& composed);

    /// Forms positions and normals: model::evaluate on the GPU.
    void form(const model::Motion& motion, const ShapeSteps& steps);
    /// Positions from outside (V x 3 mm, clip space), for truth renders; `pose` is the head's, for cavities and light.
    void form(PointsRef positions, const RigidPose& pose);

    /// Of a model with detail: what its maps are functions of. Null without.
    const DetailShape* detail() const { return detail_ ? &*detail_ : nullptr; }
    DetailShape* detail() { return detail_ ? &*detail_ : nullptr; }

    const gl::Buffer& positions() const { return positions_; }
    /// Positions, normals and the neutral positions, for shaders to fetch, to this and the next two texture units.
    void bind_texels(GLuint unit) const;
    const RigidPose& pose() const { return pose_; }
    int count() const { return count_; }
    Points read_positions() const;
    Points read_normals() const;

private:
    /// Positions = neutral + mean + corrections.
    void correct(std::span<const model::Correction> corrections);
    void keep_lids_on_eyeballs();
    void hold_apart();
    void form_normals();

    int count_ = 0;
    int components_ = 0;
    struct Contact {
        gl::Buffer pairs, members;
        int pair_count = 0, member_count = 0;
    };
    std::vector<Contact> contacts_;
    int lid_members_ = 0;
    int per_buffer_ = 1;                    ///< components that fit into one buffer of texels
    gl::Program shape_, correct_, contact_, lids_program_, normals_program_;
    gl::Buffer positions_, normals_, neutral_, neutral_and_mean_, weights_, eye_of_, lids_, ring_start_, ring_;
    std::vector<gl::Buffer> component_blocks_;
    gl::Texture position_texels_, normal_texels_, neutral_texels_, ring_start_texels_, ring_texels_;
    std::vector<gl::Texture> component_texels_;
    std::optional<DetailShape> detail_;
    gl::Buffer corrections_;                ///< of the last corrected frame
    std::size_t corrections_room_ = 0;      ///< entries that fit into it
    Eigen::SparseMatrix<float> spread_;     ///< model::LinearMotion's
    Vec3 eye_centre_[2] = {Vec3::Zero(), Vec3::Zero()};
    RigidPose pose_;
};

}  // namespace mien::render
