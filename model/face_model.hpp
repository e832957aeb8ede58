#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/clip.hpp"
#include "core/mesh.hpp"
#include "model/contact.hpp"
#include "model/detail_layers.hpp"
#include "model/lid.hpp"
#include "model/linear_motion.hpp"

/// The face model: everything static about one actor, as layers (design: base shape, dynamics, medium, fine, albedo).
namespace mien::model {

/// Base shape: the motion vector is the offsets of all vertices.
struct VertexBase {};

/// Base shape of Making Faces (Guenter et al. 1998, section 4.2): p_j = neutral_j + sum_k a_jk (d_k - neutral d_k), where
/// sum_k a_jk <= 1 but on a lid (add_lid); what is missing to one hangs on still points that follow the head pose only.
struct BlendBase {
    struct Term {
        std::uint32_t marker;
        float weight;  ///< a_jk
    };
    Points markers;                        ///< M x 3 neutral marker positions, mm, head space
    std::vector<Site> sites;               ///< M, place of each marker on the neutral mesh
    std::vector<std::uint32_t> row_start;  ///< V + 1; terms of vertex j are row_start[j] .. row_start[j + 1]
    std::vector<Term> terms;
};

/// Base shape of Ma et al. 2008, section 4: a linear thin shell that its markers hold.
struct ShellBase {
    Points markers;                        ///< M x 3 neutral marker positions, mm, head space
    std::vector<Site> sites;               ///< M, place of each marker on the neutral mesh
    Eigen::MatrixXf response;              ///< V x M: thin_shell_response, and blend coefficients of what no shell forms
};

/// The shell over markers at `sites` of `neutral`, at rest `rest_offsets` (M x 3 mm) from them. `fixed`: vertices that never move.
/// beside: vertices that have terms there are blended instead, as no shell forms them; null: none. Both have M markers.
ShellBase make_shell_base(const Mesh& neutral, std::vector<Site> sites, PointsRef rest_offsets, const std::vector<std::uint32_t>& fixed, const BlendBase* beside);

/// Base shape: a mesh moved by blendshape weights.
struct BlendshapeBase {
    std::vector<Blendshape> targets;  ///< n_b, in the order of the motion vector
};

/// No mesh known: the motion vector is the offsets of markers from `markers`; drawn as points with a triangulation.
struct PointBase {
    Points markers;                        ///< M x 3 neutral positions, mm
    std::vector<Triangle> triangulation;   ///< over the markers, for display
};

/// An eyeball that gaze turns about its centre.
struct Eyeball {
    Vec3 centre = Vec3::Zero();            ///< mm, head space, at neutral
    std::vector<std::uint32_t> vertices;   ///< sorted
};

struct FaceModel {
    std::string actor;
    Mesh neutral;                                  ///< empty for PointBase
    std::variant<VertexBase, BlendBase, ShellBase, BlendshapeBase, PointBase> base;
    std::shared_ptr<const DetailLayers> detail;    ///< medium, fine and albedo over any base shape that has a mesh; or null
    std::optional<Eyeball> eyes[2];                ///< actor's right, left; only when gaze is not already in the motion vector
    std::vector<Lid> lids;                         ///< the base shape knows of their shares: add_lid
    std::vector<Contact> contacts;                 ///< of lips and lids, where the base shape does not keep them apart
    std::optional<Image> static_albedo;            ///< used when the stream has no texture track
    bool video_albedo = false;

    /// Points the base shape forms: vertices, or markers of a PointBase.
    Eigen::Index point_count() const;
};

/// Base shape and motion basis multiplied into one: offsets of all drawn points from neutral are
/// mean + components * w, 3V values (x y z of vertex 0, ...). Every base shape is linear in the motion vector, so a frame
/// costs one small matrix product whatever the base is; the GPU holds exactly this.
LinearMotion compose(const FaceModel& model, const LinearMotion& motion);

/// Gives a model a lid. Where markers move its base shape, those on the lid tell how far it goes: with s_m the share of the lid's way at
/// marker m (of its members, at its site), a_m its part in vertex v, A those of the markers with s_m > kLeastLidShare and R the others,
///     offset of v = sum_R a_m o_m + (weight share / sum_A a_m s_m + 1 - weight) sum_A a_m o_m.
/// A vertex with hardly anything of A in it (sum_A a_m s_m < 0.001) keeps its parts.
void add_lid(FaceModel& model, Lid lid);

/// Neutral positions of the markers that drive a model, M x 3 mm, and where they sit on its mesh; null when no markers drive it, or there is
/// no mesh.
const Points* driving_markers(const FaceModel& model);
const std::vector<Site>* driving_sites(const FaceModel& model);

/// Neutral positions of all drawn points, V x 3 mm.
const Points& neutral_points(const FaceModel& model);

/// The reference for the GPU: neutral + mean + components * w + corrections, the medium layer of its detail, eyes
/// turned by gaze, lids kept on their eyeballs, lips and lids held apart, then the head pose. V x 3 mm.
Points evaluate(const FaceModel& model, const LinearMotion& composed, const Motion& motion);

}  // namespace mien::model
