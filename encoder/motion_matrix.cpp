#include "encoder/motion_matrix.hpp"

#include <cmath>
#include <string>

#include "core/parallel.hpp"
#include "encoder/motion_components.hpp"

namespace mien::encoder {
namespace {

const PointSequence& points_of(const Clip& clip, protocol::MotionKind kind) {
    return kind == protocol::MotionKind::vertices ? *clip.vertices : *clip.markers;
}

}  // namespace

Result<void> check_motion(const Clip& clip, protocol::MotionKind kind) {
    using protocol::MotionKind;
    const bool there = kind == MotionKind::vertices  ? clip.vertices.has_value()
                       : kind == MotionKind::markers ? clip.markers.has_value()
                                                     : clip.weights.has_value();
    const std::string name = kind == MotionKind::vertices ? "vertex" : kind == MotionKind::markers ? "marker" : "weight";
    if (!there) return Error{ErrorCode::missing, "the clip has no " + name + " motion"};
    if (kind == MotionKind::weights) {
        const WeightSequence& weights = *clip.weights;
        if (weights.frames == 0 || weights.count == 0) return Error{ErrorCode::invalid, "the clip has no frames of weights"};
        for (std::int64_t f = 0; f < weights.frames; ++f)
            for (std::int64_t i = 0; i < weights.count; ++i)
                if (!std::isfinite(weights.frame(f)[i]))
                    return Error{ErrorCode::invalid, "weight " + std::to_string(i) + " of frame " + std::to_string(f) +
                                                         " is not a finite number"};
        return {};
    }
    const PointSequence& points = points_of(clip, kind);
    if (points.frames == 0 || points.points == 0) return Error{ErrorCode::invalid, "the clip has no frames of " + name + " motion"};
    for (std::int64_t f = 0; f < points.frames; ++f)
        for (std::int64_t p = 0; p < points.points; ++p) {
            const auto at = points.frame(f).row(p);
            if (at.array().isFinite().all() && at.cwiseAbs().maxCoeff() < 1e7f) continue;
            const bool missing = kind == MotionKind::markers && at.array().isNaN().all();
            if (!missing)
                return Error{ErrorCode::invalid, name + " " + std::to_string(p) + " of frame " + std::to_string(f) +
                                                     " is not a usable position"};
        }
    return {};
}

bool has_missing_markers(const Clip& clip) {
    if (!clip.markers) return false;
    for (float x : clip.markers->xyz)
        if (std::isnan(x)) return true;
    return false;
}

MotionMatrix motion_matrix(const Clip& clip, protocol::MotionKind kind, PointsRef reference,
                           const std::vector<RigidPose>& poses) {
    MotionMatrix out;
    if (kind == protocol::MotionKind::weights) {
        const WeightSequence& weights = *clip.weights;
        out.values = Eigen::Map<const Eigen::MatrixXf>(weights.values.data(), weights.count, weights.frames);
        out.present = weights.frames * weights.count;
        return out;
    }
    const PointSequence& points = points_of(clip, kind);
    const bool missing = kind == protocol::MotionKind::markers && has_missing_markers(clip);
    out.values.resize(points.points * 3, points.frames);
    if (missing) out.presence.assign(std::size_t(points.frames * points.points), 1);
    parallel_for(points.frames, [&](std::int64_t f) {
        const auto frame = points.frame(f);
        PointsMap column(out.values.col(f).data(), points.points, 3);
        column = frame;
        if (!poses.empty()) apply_pose(poses[std::size_t(f)].inverse(), column);
        column -= reference;
        if (!missing) return;
        for (std::int64_t p = 0; p < points.points; ++p)
            if (std::isnan(frame(p, 0))) out.presence[std::size_t(f * points.points + p)] = 0;
    });
    out.present = points.frames * points.points;
    if (!missing) return out;
    // First guess: in between the nearest frames that have the marker; zero when none has.
    for (std::int64_t p = 0; p < points.points; ++p) {
        const auto seen = [&](std::int64_t f) { return out.presence[std::size_t(f * points.points + p)] != 0; };
        std::int64_t before = -1;
        for (std::int64_t f = 0; f < points.frames; ++f) {
            if (seen(f)) {
                before = f;
                continue;
            }
            --out.present;
            std::int64_t after = f;
            while (after < points.frames && !seen(after)) ++after;
            for (int c = 0; c < 3; ++c) {
                const Eigen::Index row = p * 3 + c;
                float& x = out.values(row, f);
                if (before < 0 && after == points.frames) x = 0;
                else if (before < 0) x = out.values(row, after);
                else if (after == points.frames) x = out.values(row, before);
                else {
                    const float t = float(f - before) / float(after - before);
                    x = (1 - t) * out.values(row, before) + t * out.values(row, after);
                }
            }
        }
    }
    return out;
}

void impute(MotionMatrix& matrix) {
    if (matrix.presence.empty()) return;
    const Eigen::Index points = matrix.values.rows() / 3, frames = matrix.values.cols();
    for (int round = 0; round < 4; ++round) {
        const MotionComponents fit = find_components(matrix.values, 0, 12 + 8 * round);
        parallel_for(frames, [&](std::int64_t f) {
            const std::uint8_t* present = matrix.presence.data() + f * points;
            const Eigen::VectorXf w = fit.coefficients.col(f).cast<float>();
            for (Eigen::Index p = 0; p < points; ++p)
                if (!present[p])
                    matrix.values.col(f).segment<3>(3 * p) =
                        fit.mean.segment<3>(3 * p) + fit.vectors.middleRows<3>(3 * p) * w;
        });
    }
}

}  // namespace mien::encoder
