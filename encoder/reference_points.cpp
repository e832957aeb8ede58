#include "encoder/reference_points.hpp"

#include <cmath>

#include "encoder/motion_pose.hpp"

namespace mien::encoder {
namespace {

Points rounded_mean(const PointSequence& sequence) {
    // The frame with the most points starts; then the head pose of every frame to the mean so far is removed.
    const Eigen::Index points = sequence.points;
    std::int64_t best = 0;
    Eigen::Index most = -1;
    for (std::int64_t f = 0; f < sequence.frames; ++f) {
        const Eigen::Index present = (sequence.frame(f).col(0).array() == sequence.frame(f).col(0).array()).count();
        if (present > most) most = present, best = f;
    }
    Points mean = Points::Zero(points, 3);
    if (sequence.frames > 0) mean = sequence.frame(best);
    Vec3 middle = Vec3::Zero();
    if (most > 0) {
        for (Eigen::Index p = 0; p < points; ++p)
            if (mean(p, 0) == mean(p, 0)) middle += mean.row(p).transpose() / float(most);
    }
    // A marker that the first frame lacks starts without weight and joins once the mean knows it.
    for (int pass = 0; pass < 3; ++pass) {
        const std::vector<RigidPose> poses = steady_poses(sequence, mean, {});
        Eigen::MatrixX3d sum = Eigen::MatrixX3d::Zero(points, 3);
        Eigen::VectorXd seen = Eigen::VectorXd::Zero(points);
        for (std::int64_t f = 0; f < sequence.frames; ++f) {
            const RigidPose back = poses[std::size_t(f)].inverse();
            const auto frame = sequence.frame(f);
            for (Eigen::Index p = 0; p < points; ++p) {
                if (!(frame(p, 0) == frame(p, 0))) continue;
                sum.row(p) += back.apply(frame.row(p).transpose()).cast<double>().transpose();
                seen[p] += 1;
            }
        }
        for (Eigen::Index p = 0; p < points; ++p)
            if (seen[p] > 0) mean.row(p) = (sum.row(p) / seen[p]).cast<float>();
    }
    for (Eigen::Index p = 0; p < points; ++p)
        for (int c = 0; c < 3; ++c) {
            const float x = mean(p, c) == mean(p, c) ? mean(p, c) : middle[c];
            mean(p, c) = std::round(x * 64) / 64;
        }
    return mean;
}

}  // namespace

Points reference_points(const Clip& clip, protocol::MotionKind kind) {
    if (kind == protocol::MotionKind::vertices) {
        if (clip.neutral) return clip.neutral->positions;
        return clip.vertices ? rounded_mean(*clip.vertices) : Points();
    }
    if (kind == protocol::MotionKind::markers) {
        if (clip.neutral && !clip.marker_sites.empty()) {
            Points sites(Eigen::Index(clip.marker_sites.size()), 3);
            for (Eigen::Index m = 0; m < sites.rows(); ++m)
                sites.row(m) = clip.marker_sites[std::size_t(m)].position(clip.neutral->positions).transpose();
            return sites;
        }
        return clip.markers ? rounded_mean(*clip.markers) : Points();
    }
    return Points();
}

}  // namespace mien::encoder
