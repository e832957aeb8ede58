#include "model/face_model.hpp"

#include <cassert>
#include <cmath>
#include <span>

#include "model/thin_shell.hpp"

namespace mien::model {
namespace {

/// D (3V x k) from C (3M x k): row block j of D = sum over the terms of vertex j of a_jk times row block k of C.
Eigen::MatrixXf blend_rows(const BlendBase& base, const Eigen::MatrixXf& markers) {
    const Eigen::Index V = Eigen::Index(base.row_start.size()) - 1;
    Eigen::MatrixXf vertices = Eigen::MatrixXf::Zero(3 * V, markers.cols());
    for (Eigen::Index column = 0; column < markers.cols(); ++column)
        for (Eigen::Index j = 0; j < V; ++j)
            for (std::uint32_t i = base.row_start[j]; i < base.row_start[j + 1]; ++i) {
                const BlendBase::Term& term = base.terms[i];
                vertices.col(column).segment<3>(3 * j) +=
                    term.weight * markers.col(column).segment<3>(3 * Eigen::Index(term.marker));
            }
    return vertices;
}

/// The same through a dense V x M response.
Eigen::MatrixXf shell_rows(const ShellBase& base, const Eigen::MatrixXf& markers) {
    using RowPoints = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const Eigen::Index V = base.response.rows(), M = base.response.cols();
    Eigen::MatrixXf vertices(3 * V, markers.cols());
    for (Eigen::Index column = 0; column < markers.cols(); ++column)
        Eigen::Map<RowPoints>(vertices.col(column).data(), V, 3).noalias() = base.response * Eigen::Map<const RowPoints>(markers.col(column).data(), M, 3);
    return vertices;
}

Eigen::MatrixXf blendshape_rows(const BlendshapeBase& base, Eigen::Index rows, const Eigen::MatrixXf& weights) {
    if (base.targets.empty()) return Eigen::MatrixXf::Zero(rows, weights.cols());  // weights without a rig move nothing
    assert(Eigen::Index(base.targets.size()) == weights.rows());
    Eigen::MatrixXf targets(rows, Eigen::Index(base.targets.size()));
    for (Eigen::Index i = 0; i < targets.cols(); ++i)
        targets.col(i) = Eigen::Map<const Eigen::VectorXf>(base.targets[i].offsets.data(), rows);
    return targets * weights;
}

/// What an entry of the motion vector adds to the offsets of the vertices: 3V x 3M.
Eigen::SparseMatrix<float> blend_spread(const BlendBase& base) {
    const Eigen::Index V = Eigen::Index(base.row_start.size()) - 1;
    std::vector<Eigen::Triplet<float>> entries;
    entries.reserve(3 * base.terms.size());
    for (Eigen::Index j = 0; j < V; ++j)
        for (std::uint32_t i = base.row_start[j]; i < base.row_start[j + 1]; ++i)
            for (int c = 0; c < 3; ++c) entries.emplace_back(3 * j + c, 3 * Eigen::Index(base.terms[i].marker) + c, base.terms[i].weight);
    Eigen::SparseMatrix<float> spread(3 * V, base.markers.size());
    spread.setFromTriplets(entries.begin(), entries.end());
    return spread;
}

/// The same through a response, less what moves a point by under a thousandth of its marker's correction.
Eigen::SparseMatrix<float> shell_spread(const ShellBase& base) {
    std::vector<Eigen::Triplet<float>> entries;
    for (Eigen::Index marker = 0; marker < base.response.cols(); ++marker)
        for (Eigen::Index j = 0; j < base.response.rows(); ++j)
            if (std::abs(base.response(j, marker)) > 1e-3f)
                for (int c = 0; c < 3; ++c) entries.emplace_back(3 * j + c, 3 * marker + c, base.response(j, marker));
    Eigen::SparseMatrix<float> spread(3 * base.response.rows(), 3 * base.response.cols());
    spread.setFromTriplets(entries.begin(), entries.end());
    return spread;
}

/// The same for weights: 3V x n_b; nothing moves without a rig.
Eigen::SparseMatrix<float> blendshape_spread(const BlendshapeBase& base, Eigen::Index rows, Eigen::Index weights) {
    Eigen::SparseMatrix<float> spread(rows, weights);
    std::vector<Eigen::Triplet<float>> entries;
    for (std::size_t i = 0; i < base.targets.size(); ++i) {
        const float* offsets = base.targets[i].offsets.data();
        for (Eigen::Index row = 0; row < rows; ++row)
            if (offsets[row] != 0) entries.emplace_back(row, Eigen::Index(i), offsets[row]);
    }
    spread.setFromTriplets(entries.begin(), entries.end());
    return spread;
}

void turn_eye(const Eyeball& eye, float yaw, float pitch, Points& points) {
    // Yaw > 0 looks to +x, pitch > 0 looks up; +z is straight ahead.
    const Eigen::Matrix3f turn = (Eigen::AngleAxisf(yaw, Vec3::UnitY()) * Eigen::AngleAxisf(-pitch, Vec3::UnitX())).toRotationMatrix();
    for (const std::uint32_t v : eye.vertices) {
        const Vec3 arm = points.row(v).transpose() - eye.centre;
        points.row(v) = (eye.centre + turn * arm).transpose();
    }
}

}  // namespace

Eigen::Index FaceModel::point_count() const { return neutral_points(*this).rows(); }

const Points& neutral_points(const FaceModel& model) {
    const auto* points = std::get_if<PointBase>(&model.base);
    return points ? points->markers : model.neutral.positions;
}

ShellBase make_shell_base(const Mesh& neutral, std::vector<Site> sites, PointsRef rest_offsets, const std::vector<std::uint32_t>& fixed, const BlendBase* beside) {
    assert(rest_offsets.rows() == Eigen::Index(sites.size()) && (!beside || beside->sites.size() == sites.size()));
    ShellBase base;
    base.markers = rest_offsets;
    for (std::size_t m = 0; m < sites.size(); ++m) base.markers.row(Eigen::Index(m)) += sites[m].position(neutral.positions).transpose();
    base.response = thin_shell_response(neutral, sites, fixed);
    base.sites = std::move(sites);
    for (Eigen::Index v = 0; beside && v < base.response.rows(); ++v) {
        const std::uint32_t begin = beside->row_start[std::size_t(v)], end = beside->row_start[std::size_t(v) + 1];
        if (begin == end) continue;
        base.response.row(v).setZero();
        for (std::uint32_t i = begin; i < end; ++i) base.response(v, Eigen::Index(beside->terms[i].marker)) += beside->terms[i].weight;
    }
    return base;
}

namespace {

/// Parts of one vertex as the lid has them (add_lid). parts: of the markers `marker_of` names.
template <class Parts, class MarkerOf>
void reach_with_lid(const Lid::Member& member, const std::vector<float>& marker_share, Parts parts, MarkerOf marker_of) {
    float shown = 0;
    for (Eigen::Index i = 0; i < parts.size(); ++i) shown += parts[i] * marker_share[std::size_t(marker_of(i))];
    constexpr float kLeast = 1e-3f;
    if (shown < kLeast) return;
    for (Eigen::Index i = 0; i < parts.size(); ++i)
        if (marker_share[std::size_t(marker_of(i))] > 0) parts[i] *= 1 - member.weight + member.weight * member.share / shown;
}

}  // namespace

void add_lid(FaceModel& model, Lid lid) {
    if (const std::vector<Site>* sites = driving_sites(model)) {
        std::vector<float> share(model.neutral.vertex_count(), 0);
        for (const Lid::Member& member : lid.members) share[member.vertex] = member.share;
        std::vector<float> marker_share;
        for (const Site& site : *sites) {
            float seen = 0;
            for (int i = 0; i < 3; ++i) seen += site.weights[i] * share[site.vertices[i]];
            marker_share.push_back(seen > kLeastLidShare ? seen : 0);
        }
        for (const Lid::Member& member : lid.members) {
            if (auto* shell = std::get_if<ShellBase>(&model.base))
                reach_with_lid(member, marker_share, shell->response.row(member.vertex), [](Eigen::Index i) { return i; });
            if (auto* blend = std::get_if<BlendBase>(&model.base)) {
                std::span terms(blend->terms.data() + blend->row_start[member.vertex], blend->row_start[member.vertex + 1] - blend->row_start[member.vertex]);
                Eigen::VectorXf parts{Eigen::Index(terms.size())};
                for (std::size_t i = 0; i < terms.size(); ++i) parts[Eigen::Index(i)] = terms[i].weight;
                reach_with_lid<Eigen::VectorXf&>(member, marker_share, parts, [&](Eigen::Index i) { return terms[std::size_t(i)].marker; });
                for (std::size_t i = 0; i < terms.size(); ++i) terms[i].weight = parts[Eigen::Index(i)];
            }
        }
    }
    model.lids.push_back(std::move(lid));
}

const Points* driving_markers(const FaceModel& model) {
    if (const auto* blend = std::get_if<BlendBase>(&model.base)) return &blend->markers;
    if (const auto* shell = std::get_if<ShellBase>(&model.base)) return &shell->markers;
    if (const auto* points = std::get_if<PointBase>(&model.base)) return &points->markers;
    return nullptr;
}

const std::vector<Site>* driving_sites(const FaceModel& model) {
    if (const auto* blend = std::get_if<BlendBase>(&model.base)) return &blend->sites;
    if (const auto* shell = std::get_if<ShellBase>(&model.base)) return &shell->sites;
    return nullptr;
}

LinearMotion compose(const FaceModel& model, const LinearMotion& motion) {
    const auto through = [&](const auto& rows) {
        return LinearMotion{rows(Eigen::MatrixXf(motion.mean)), rows(motion.components), motion.corrected, {}};
    };
    if (const auto* blend = std::get_if<BlendBase>(&model.base)) {
        assert(motion.dimension() == 3 * blend->markers.rows());
        LinearMotion composed = through([&](const Eigen::MatrixXf& m) { return blend_rows(*blend, m); });
        if (motion.corrected) composed.spread = blend_spread(*blend);
        return composed;
    }
    if (const auto* shapes = std::get_if<BlendshapeBase>(&model.base)) {
        const Eigen::Index rows = model.neutral.positions.size();
        LinearMotion composed = through([&](const Eigen::MatrixXf& m) { return blendshape_rows(*shapes, rows, m); });
        if (motion.corrected) composed.spread = blendshape_spread(*shapes, rows, motion.dimension());
        return composed;
    }
    if (const auto* shell = std::get_if<ShellBase>(&model.base)) {
        assert(motion.dimension() == 3 * shell->response.cols());
        LinearMotion composed = through([&](const Eigen::MatrixXf& m) { return shell_rows(*shell, m); });
        if (motion.corrected) composed.spread = shell_spread(*shell);
        return composed;
    }
    assert(motion.dimension() == 3 * model.point_count());
    return motion;
}

Points evaluate(const FaceModel& model, const LinearMotion& composed, const Motion& motion) {
    const Eigen::VectorXf offsets = motion_vector(composed, motion);
    Points points = neutral_points(model) + ConstPointsMap(offsets.data(), offsets.size() / 3, 3);
    if (model.detail) model.detail->add_medium(model.detail->parameters(points), points);
    for (int side = 0; side < 2; ++side)
        if (model.eyes[side]) turn_eye(*model.eyes[side], motion.gaze.yaw[side], motion.gaze.pitch[side], points);
    for (const Lid& lid : model.lids) keep_on_eyeball(lid, model.neutral.positions, points);
    for (const Contact& contact : model.contacts) hold_apart(contact, points);
    apply_pose(motion.pose, points);
    return points;
}

}  // namespace mien::model
