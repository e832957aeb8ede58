#include "analysis/deformation_axes.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <queue>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace mien::analysis {
namespace {

using Axis = Eigen::Matrix<double, model::kDeformationSize, 1>;
using Plane = Eigen::Matrix<double, model::kDeformationSize, 2>;

constexpr double kStill = 1e-3;  // of the mean energy: what is added to a marker's own before it is scaled to one
// How much the energy of S itself says beside the slopes, which few takes make uncertain: with less of it, rare shapes go astray in the
// largest errors. Measured on the procedural head.
constexpr double kEnergyShare = 0.6;

struct Principal {
    Axis energies;    // descending
    Moment axes;      // columns
};

Principal principal(const Moment& moment) {
    const Eigen::SelfAdjointEigenSolver<Moment> solver(moment);
    return {solver.eigenvalues().reverse().cwiseMax(0), solver.eigenvectors().rowwise().reverse()};
}

/// The plane of S that changes with slopes b follow best, from E[S S'] and the sum of b b': with s the root of the first, the first
/// two principal axes of s (sum b b') s, whitened.
Plane telling_plane(const Moment& moment, const Moment& slopes) {
    const Eigen::SelfAdjointEigenSolver<Moment> solver(moment);
    const Moment root = solver.operatorSqrt(), changes = root * slopes * root;
    const Principal best = principal(changes / changes.trace() + kEnergyShare * moment / moment.trace());
    return solver.operatorInverseSqrt() * best.axes.leftCols<2>();
}

/// Every marker's slopes and the mean of its neighbours': few texels tell little, and planes that change from marker to marker mix
/// badly in between.
std::vector<Moment> shared(const DeformationMoments& moments, const std::vector<Moment>& slopes) {
    std::vector<Moment> all = slopes;
    for (std::size_t m = 0; m < slopes.size(); ++m)
        for (const std::uint32_t beside : moments.beside(m)) all[m] += slopes[beside] / double(moments.beside(m).size());
    return all;
}

/// The orthogonal matrix nearest to a 2 x 2 matrix (Schönemann 1966).
Eigen::Matrix2d orthogonal(const Eigen::Matrix2d& m) {
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return svd.matrixU() * svd.matrixV().transpose();
}

/// Turns every plane's frame so that sum over edges of trace((W_i G_i)' E[S_i S_j'] (W_j G_j)), the correlation of neighbours'
/// d1 and d2, is large: outward from the strongest marker first, then one marker at a time until nothing turns.
void align_frames(const DeformationMoments& moments, const std::vector<double>& energy, std::vector<Plane>& planes) {
    const std::size_t M = planes.size();
    std::vector<char> aligned(M, 0);
    const auto wanted = [&](std::size_t i) {
        Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
        for (std::size_t k = 0; k < moments.beside(i).size(); ++k) {
            const std::uint32_t j = moments.beside(i)[k];
            if (aligned[j]) sum += planes[i].transpose() * moments.across(i, k) * planes[j];
        }
        return sum;
    };
    std::vector<std::size_t> order(M);
    for (std::size_t i = 0; i < M; ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return energy[a] > energy[b]; });
    for (const std::size_t start : order) {  // once per piece of the mesh
        if (aligned[start]) continue;
        std::priority_queue<std::pair<double, std::size_t>> front;
        front.emplace(0.0, start);
        while (!front.empty()) {
            const std::size_t i = front.top().second;
            front.pop();
            if (aligned[i]) continue;
            planes[i] *= orthogonal(wanted(i));
            aligned[i] = 1;
            for (const std::uint32_t j : moments.beside(i))
                if (!aligned[j]) front.emplace(wanted(j).norm(), j);
        }
    }
    for (int sweep = 0; sweep < 200; ++sweep) {
        double most = 0;
        for (std::size_t i = 0; i < M; ++i) {
            const Eigen::Matrix2d turn = orthogonal(wanted(i));
            most = std::max(most, (turn - Eigen::Matrix2d::Identity()).norm());
            planes[i] *= turn;
        }
        if (most < 1e-6) break;
    }
}

/// Section 4.1 to the letter; signs are aligned before averaging, since an axis has none.
void smooth_as_in_paper(const DeformationMoments& moments, const AxisOptions& options, std::vector<Plane>& planes) {
    const double allowed = std::cos(options.outlier_degrees * std::numbers::pi / 180);
    const auto mean_around = [&](std::size_t i, int axis) {
        Axis sum = Axis::Zero();
        for (const std::uint32_t j : moments.beside(i)) {
            const Axis other = planes[j].col(axis);
            sum += other.dot(planes[i].col(axis)) < 0 ? Axis(-other) : other;
        }
        return Axis(sum.normalized());
    };
    for (int step = 0; step < options.most_steps; ++step) {
        double worst = allowed;
        std::size_t where = planes.size();
        int which = 0;
        for (std::size_t i = 0; i < planes.size(); ++i)
            for (int axis = 0; axis < 2 && !moments.beside(i).empty(); ++axis)
                if (const double cosine = mean_around(i, axis).dot(planes[i].col(axis)); cosine < worst)
                    worst = cosine, where = i, which = axis;
        if (where == planes.size()) break;
        Plane& plane = planes[where];
        plane.col(which) = mean_around(where, which);
        plane.col(0).normalize();
        plane.col(1) -= plane.col(0).dot(plane.col(1)) * plane.col(0);
        if (plane.col(1).norm() < 1e-9) plane.col(1) = plane.col(0).unitOrthogonal();
        plane.col(1).normalize();
    }
    // One sign over the whole mesh, as far as it goes: opposed neighbours would cancel in between.
    std::vector<char> seen(planes.size(), 0);
    for (std::size_t start = 0; start < planes.size(); ++start) {
        if (seen[start]) continue;
        std::queue<std::size_t> front({start});
        seen[start] = 1;
        while (!front.empty()) {
            const std::size_t i = front.front();
            front.pop();
            for (const std::uint32_t j : moments.beside(i)) {
                if (seen[j]) continue;
                seen[j] = 1;
                for (int axis = 0; axis < 2; ++axis)
                    if (planes[j].col(axis).dot(planes[i].col(axis)) < 0) planes[j].col(axis) *= -1;
                front.push(j);
            }
        }
    }
}

}  // namespace

DeformationMoments::DeformationMoments(const model::MarkerMesh& mesh)
    : beside_(vertex_neighbours(std::uint32_t(mesh.neutral.rows()), mesh.triangles)),
      own_(std::size_t(mesh.neutral.rows()), Moment::Zero()) {
    for (const auto& list : beside_) across_.emplace_back(list.size(), Moment::Zero());
}

void DeformationMoments::add(const model::Deformations& S) {
    const Eigen::Matrix<double, Eigen::Dynamic, model::kDeformationSize, Eigen::RowMajor> s = S.cast<double>();
    for (std::size_t i = 0; i < own_.size(); ++i) {
        const auto row = s.row(Eigen::Index(i));
        own_[i] += row.transpose() * row;
        for (std::size_t k = 0; k < beside_[i].size(); ++k) across_[i][k] += row.transpose() * s.row(beside_[i][k]);
    }
    ++frames_;
}

Moment DeformationMoments::at(std::size_t marker) const { return own_[marker] / double(std::max<std::int64_t>(frames_, 1)); }
Moment DeformationMoments::across(std::size_t marker, std::size_t k) const {
    return across_[marker][k] / double(std::max<std::int64_t>(frames_, 1));
}

std::array<double, model::kDeformationSize> axis_energy(const DeformationMoments& moments) {
    std::array<double, model::kDeformationSize> share{};
    int counted = 0;
    for (std::size_t m = 0; m < moments.markers(); ++m) {
        const Axis energies = principal(moments.at(m)).energies;
        if (!(energies.sum() > 0)) continue;
        double sum = 0;
        for (int k = 0; k < model::kDeformationSize; ++k) share[std::size_t(k)] += (sum += energies[k]) / energies.sum();
        ++counted;
    }
    for (double& s : share) s /= std::max(counted, 1);
    return share;
}

model::DomainAxes deformation_axes(const DeformationMoments& moments, const AxisOptions& options, const std::vector<Moment>& slopes) {
    const std::size_t M = moments.markers();
    assert(slopes.empty() || slopes.size() == M);
    const std::vector<Moment> told = options.choice == AxisChoice::telling && !slopes.empty() ? shared(moments, slopes) : std::vector<Moment>(M, Moment::Zero());
    std::vector<Plane> planes;
    std::vector<Principal> all;
    std::vector<double> energy;
    double mean = 0;
    for (std::size_t m = 0; m < M; ++m) {
        all.push_back(principal(moments.at(m)));
        energy.push_back(all[m].energies[0]);
        mean += energy[m] / double(M);
    }
    const double floor = std::max(kStill * mean, 1e-12);
    for (std::size_t m = 0; m < M; ++m) {
        Plane plane = all[m].axes.leftCols<2>();
        if (told[m].trace() > 0) plane = telling_plane(moments.at(m) + floor * Moment::Identity(), told[m]);
        else if (options.smoothing == AxisSmoothing::frames)
            for (int axis = 0; axis < 2; ++axis) plane.col(axis) /= std::sqrt(all[m].energies[axis] + floor);
        planes.push_back(plane);
    }
    if (options.smoothing == AxisSmoothing::frames) {
        align_frames(moments, energy, planes);
    } else {
        if (options.smoothing == AxisSmoothing::paper) smooth_as_in_paper(moments, options, planes);
        for (std::size_t m = 0; m < M; ++m)
            for (int axis = 0; axis < 2; ++axis) {
                const Axis direction = planes[m].col(axis);
                planes[m].col(axis) /= std::sqrt(direction.dot(moments.at(m) * direction) + floor);
            }
    }
    model::DomainAxes axes{model::Deformations(Eigen::Index(M), model::kDeformationSize), model::Deformations(Eigen::Index(M), model::kDeformationSize)};
    for (std::size_t m = 0; m < M; ++m) {
        axes.q.row(Eigen::Index(m)) = planes[m].col(0).transpose().cast<float>();
        axes.r.row(Eigen::Index(m)) = planes[m].col(1).transpose().cast<float>();
    }
    return axes;
}

}  // namespace mien::analysis
