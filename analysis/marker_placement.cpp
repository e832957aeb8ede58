#include "analysis/marker_placement.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <Eigen/Cholesky>

#include "core/parallel.hpp"

namespace mien::analysis {
namespace {

constexpr int kRounds = 60;
constexpr double kStill = 1e-4;              // mm: closer than this to the round before, it has ended
constexpr float kFarthest = 3;              // medians
constexpr Eigen::Index kMostPoints = 300;    // of a surface: more do not turn a rigid fit

/// The nearest point of a triangle, as weights of its corners (Ericson, Real-Time Collision Detection, section 5.1.5).
Vec3 nearest_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const float d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
    if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
    if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
    const float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
    if (va <= 0 && d4 >= d3 && d5 >= d6) {
        const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0, 1 - w, w};
    }
    const float sum = va + vb + vc;
    return sum > 0 ? Vec3(va / sum, vb / sum, vc / sum) : Vec3(1, 0, 0);
}

class Skin {
public:
    explicit Skin(const Mesh& mesh) : mesh_(mesh) {
        const std::vector<Surface> surfaces = mesh.triangle_surfaces();
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            if (surfaces[t] != Surface::skin) continue;
            const Triangle& c = mesh.triangles[t];
            const Vec3 middle = (mesh.positions.row(c[0]) + mesh.positions.row(c[1]) + mesh.positions.row(c[2])).transpose() / 3;
            float radius = 0;
            for (const std::uint32_t v : c) radius = std::max(radius, (mesh.positions.row(v).transpose() - middle).norm());
            faces_.push_back({c, middle, radius});
        }
    }
    bool empty() const { return faces_.empty(); }

    struct Place {
        Site site;
        Vec3 normal;   // of the triangle
    };
    Place nearest(const Vec3& p) const {
        float best = std::numeric_limits<float>::infinity();
        Place place{{}, Vec3::UnitZ()};
        for (const Face& face : faces_) {
            if ((p - face.middle).norm() - face.radius >= best) continue;
            const auto corner = [&](int i) { return Vec3(mesh_.positions.row(face.corners[std::size_t(i)]).transpose()); };
            const Vec3 w = nearest_weights(p, corner(0), corner(1), corner(2));
            const float distance = (w[0] * corner(0) + w[1] * corner(1) + w[2] * corner(2) - p).norm();
            if (distance >= best) continue;
            best = distance;
            for (int i = 0; i < 3; ++i) place.site.vertices[i] = face.corners[std::size_t(i)], place.site.weights[i] = w[i];
            const Vec3 across = (corner(1) - corner(0)).cross(corner(2) - corner(0));
            if (across.norm() > 0) place.normal = across.normalized();
        }
        return place;
    }
    std::vector<Place> nearest_all(PointsRef points) const {
        std::vector<Place> places(std::size_t(points.rows()));
        parallel_for(points.rows(), [&](std::int64_t i) { places[std::size_t(i)] = nearest(Vec3(points.row(i).transpose())); });
        return places;
    }

private:
    struct Face {
        Triangle corners;
        Vec3 middle;
        float radius;
    };
    const Mesh& mesh_;
    std::vector<Face> faces_;
};

struct Fit {
    RigidPose pose;
    double error = std::numeric_limits<double>::infinity();   // mm RMS
};

/// One Gauss-Newton step: distances to the tangent planes (Chen and Medioni 1992), which lets points slide along the skin to where they belong,
/// and a little of those to the points themselves, so that a plane may not slide away.
RigidPose closer(const RigidPose& pose, PointsRef moved, const std::vector<Skin::Place>& places, PointsRef there, const Eigen::VectorXf& weights) {
    constexpr double kToPoint = 0.02;
    const Eigen::Vector3d middle = moved.cast<double>().colwise().mean().transpose();
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Identity() * 1e-9;
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (Eigen::Index i = 0; i < moved.rows(); ++i) {
        if (weights[i] == 0) continue;
        const Eigen::Vector3d p = moved.row(i).transpose().cast<double>() - middle, off = (there.row(i) - moved.row(i)).transpose().cast<double>();
        const Eigen::Vector3d normal = places[std::size_t(i)].normal.cast<double>();
        const auto add = [&](const Eigen::Vector3d& direction, double weight) {
            Eigen::Matrix<double, 6, 1> row;
            row << p.cross(direction), direction;
            A += weight * row * row.transpose();
            b += weight * direction.dot(off) * row;
        };
        add(normal, 1);
        for (int c = 0; c < 3; ++c) add(Eigen::Vector3d::Unit(c), kToPoint);
    }
    const Eigen::Matrix<double, 6, 1> x = A.ldlt().solve(b);
    const double angle = x.head<3>().norm();
    const Eigen::Quaterniond turn(angle > 0 ? Eigen::AngleAxisd(angle, x.head<3>() / angle) : Eigen::AngleAxisd::Identity());
    RigidPose out;
    out.rotation = (turn * pose.rotation.cast<double>()).normalized().cast<float>();
    out.translation = (turn * (pose.translation.cast<double>() - middle) + middle + x.tail<3>()).cast<float>();
    return out;
}

Fit fit_to(const Skin& skin, const Mesh& neutral, PointsRef points, RigidPose pose) {
    Fit fit{pose, std::numeric_limits<double>::infinity()};
    RigidPose before = pose;
    for (int round = 0; round < kRounds; ++round) {
        Points moved = points, there(points.rows(), 3);
        apply_pose(fit.pose, moved);
        const std::vector<Skin::Place> places = skin.nearest_all(moved);
        for (Eigen::Index i = 0; i < there.rows(); ++i) there.row(i) = places[std::size_t(i)].site.position(neutral.positions).transpose();
        // What lies much farther off than most has no part in the model's skin: another haircut, the inside of a mouth.
        const Eigen::VectorXf distances = (moved - there).rowwise().norm();
        std::vector<float> sorted(distances.data(), distances.data() + distances.size());
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
        const float farthest = kFarthest * sorted[sorted.size() / 2] + float(kStill);
        const Eigen::VectorXf weights = (distances.array() <= farthest).cast<float>();
        const double error = std::sqrt(double(distances.cwiseMin(farthest).squaredNorm()) / double(points.rows()));
        if (error >= fit.error) {   // a step too far: the one before stays
            fit.pose = before;
            break;
        }
        const bool still = fit.error - error < kStill;
        fit.error = error;
        if (still) break;
        before = fit.pose;
        fit.pose = closer(fit.pose, moved, places, there, weights);
    }
    return fit;
}

}  // namespace

PlacedMarkers place_markers(const Mesh& neutral, PointsRef markers, PointsRef surface) {
    const Skin skin(neutral);
    assert(markers.rows() >= 3 && markers.allFinite() && !skin.empty());
    Points points = surface.rows() > 0 ? surface : markers;
    if (points.rows() > kMostPoints) {
        Points some(kMostPoints, 3);
        for (Eigen::Index i = 0; i < kMostPoints; ++i) some.row(i) = points.row(i * points.rows() / kMostPoints);
        points = std::move(some);
    }
    // From where they are (sessions of one studio share their axes), and from the middle of the face in front of the skin.
    RigidPose middle;
    const Vec3 low = neutral.positions.colwise().minCoeff().transpose(), high = neutral.positions.colwise().maxCoeff().transpose();
    middle.translation = (surface.rows() > 0 ? Vec3(neutral.positions.colwise().mean().transpose()) : Vec3((low.x() + high.x()) / 2, (low.y() + high.y()) / 2, high.z())) -
                         Vec3(points.colwise().mean().transpose());
    Fit best = fit_to(skin, neutral, points, {});
    if (const Fit other = fit_to(skin, neutral, points, middle); other.error < best.error) best = other;

    PlacedMarkers placed;
    placed.rest = markers;
    apply_pose(best.pose, placed.rest);
    for (const Skin::Place& place : skin.nearest_all(placed.rest)) placed.sites.push_back(place.site);
    for (Eigen::Index m = 0; m < markers.rows(); ++m) {
        const double distance = double((placed.sites[std::size_t(m)].position(neutral.positions) - placed.rest.row(m).transpose()).norm());
        placed.mean += distance / double(markers.rows());
        placed.largest = std::max(placed.largest, distance);
    }
    return placed;
}

void misplace(PlacedMarkers& placed, const Mesh& neutral, double mm, std::uint32_t seed) {
    const Skin skin(neutral);
    const Points normals = vertex_normals(neutral.positions, neutral.triangles);
    std::mt19937 random(seed);
    for (Site& site : placed.sites) {
        const Vec3 normal = site.position(normals).normalized();
        const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
        const float angle = float(2 * std::numbers::pi * double(random()) / 4294967296.0);
        site = skin.nearest(site.position(neutral.positions) + float(mm) * (std::cos(angle) * u + std::sin(angle) * v)).site;
    }
}

}  // namespace mien::analysis
