#include "model/marker_deformation.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace mien::model {

MarkerMesh make_marker_mesh(const Mesh& neutral, const std::vector<Site>& sites, std::vector<Triangle> triangles) {
    // Tangents of a vertex: dP/du and dP/dv of its triangles, weighted by their areas.
    Points u = Points::Zero(neutral.vertex_count(), 3), v = u;
    for (std::size_t t = 0; t < neutral.texcoord_triangles.size(); ++t) {
        const Triangle &corners = neutral.triangles[t], &places = neutral.texcoord_triangles[t];
        const Vec2 a = neutral.texcoords[places[1]] - neutral.texcoords[places[0]], b = neutral.texcoords[places[2]] - neutral.texcoords[places[0]];
        const float area = a.x() * b.y() - a.y() * b.x();
        if (!(std::abs(area) > 1e-12f)) continue;
        const Vec3 ab = (neutral.positions.row(corners[1]) - neutral.positions.row(corners[0])).transpose();
        const Vec3 ac = (neutral.positions.row(corners[2]) - neutral.positions.row(corners[0])).transpose();
        const float weight = ab.cross(ac).norm() / area;
        for (const std::uint32_t corner : corners) {
            u.row(corner) += weight * (b.y() * ab - a.y() * ac).transpose();
            v.row(corner) += weight * (a.x() * ac - b.x() * ab).transpose();
        }
    }
    MarkerMesh mesh;
    const auto M = Eigen::Index(sites.size());
    mesh.neutral.resize(M, 3);
    mesh.u.resize(M, 3);
    mesh.v.resize(M, 3);
    mesh.triangles = std::move(triangles);
    for (Eigen::Index m = 0; m < M; ++m) {
        const Site& site = sites[std::size_t(m)];
        mesh.neutral.row(m) = site.position(neutral.positions).transpose();
        const Vec3 along_u = site.position(u), along_v = site.position(v);
        mesh.u.row(m) = (along_u.norm() > 1e-9f ? Vec3(along_u.normalized()) : Vec3(Vec3::UnitX())).transpose();
        mesh.v.row(m) = (along_v.norm() > 1e-9f ? Vec3(along_v.normalized()) : Vec3(Vec3::UnitY())).transpose();
    }
    return mesh;
}

DeformationMeter::DeformationMeter(MarkerMesh mesh) : mesh_(std::move(mesh)) {
    const auto M = std::uint32_t(mesh_.neutral.rows());
    const auto beside = vertex_neighbours(M, mesh_.triangles);
    near_.resize(M);
    for (std::uint32_t i = 0; i < M; ++i) {
        near_[i] = beside[i];
        near_[i].push_back(i);
        for (const std::uint32_t j : beside[i]) near_[i].insert(near_[i].end(), beside[j].begin(), beside[j].end());
        std::sort(near_[i].begin(), near_[i].end());
        near_[i].erase(std::unique(near_[i].begin(), near_[i].end()), near_[i].end());
    }
    for (std::uint32_t i = 0; i < M; ++i) neutral_spread_.push_back(spread(mesh_.neutral, i));
}

Eigen::Vector2f DeformationMeter::spread(PointsRef markers, std::size_t i) const {
    const auto n = float(near_[i].size());
    Eigen::Vector2f sum = Eigen::Vector2f::Zero(), squares = sum;
    for (const std::uint32_t j : near_[i]) {
        // From marker i, so that the squares stay small beside the head's size.
        const Eigen::RowVector3f arm = markers.row(j) - markers.row(Eigen::Index(i));
        const Eigen::Vector2f along(arm.dot(mesh_.u.row(Eigen::Index(i))), arm.dot(mesh_.v.row(Eigen::Index(i))));
        sum += along;
        squares += along.cwiseAbs2();
    }
    return (squares / n - (sum / n).cwiseAbs2()).cwiseMax(0).cwiseSqrt();
}

Deformations DeformationMeter::measure(PointsRef markers) const {
    assert(markers.rows() == mesh_.neutral.rows());
    Deformations S(markers.rows(), kDeformationSize);
    for (Eigen::Index i = 0; i < markers.rows(); ++i) {
        S.row(i).head<3>() = markers.row(i) - mesh_.neutral.row(i);
        const Eigen::Vector2f strain = spread(markers, std::size_t(i)) - neutral_spread_[std::size_t(i)];
        S.row(i).tail<2>() = std::sqrt(float(near_[std::size_t(i)].size())) * strain.transpose();
    }
    return S;
}

bool fill_missing_markers(const MarkerMesh& mesh, Eigen::Ref<Points> markers) {
    const auto M = std::uint32_t(markers.rows());
    std::vector<std::uint32_t> missing;
    Eigen::RowVector3f mean = Eigen::RowVector3f::Zero();
    for (std::uint32_t m = 0; m < M; ++m)
        if (markers.row(m).allFinite()) mean += markers.row(m) - mesh.neutral.row(m);
        else missing.push_back(m);
    if (missing.size() == M) return false;
    if (missing.empty()) return true;
    mean /= float(M - missing.size());
    for (const std::uint32_t m : missing) markers.row(m) = mesh.neutral.row(m) + mean;
    const auto beside = vertex_neighbours(M, mesh.triangles);
    // Gauss-Seidel: gaps are a few markers wide.
    for (int pass = 0; pass < 100; ++pass) {
        float most = 0;
        for (const std::uint32_t m : missing) {
            if (beside[m].empty()) continue;
            Eigen::RowVector3f offset = Eigen::RowVector3f::Zero();
            for (const std::uint32_t j : beside[m]) offset += markers.row(j) - mesh.neutral.row(j);
            const Eigen::RowVector3f place = mesh.neutral.row(m) + offset / float(beside[m].size());
            most = std::max(most, (place - markers.row(m)).norm());
            markers.row(m) = place;
        }
        if (most < 1e-4f) break;
    }
    return true;
}

}  // namespace mien::model
