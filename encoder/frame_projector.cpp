#include "encoder/frame_projector.hpp"

#include <algorithm>
#include <cmath>

#include "coding/motion_values.hpp"

namespace mien::encoder {

namespace {

using coding::MotionBasis;

constexpr double kHold = 0.01;   // of all points: how much the frame before counts where markers are missing

// As motion_pose.hpp weighs points by what is left of them, here by the take's own offsets, where its pose is taken out already.
Eigen::VectorXf steadiness(const Eigen::VectorXd& mean, const Eigen::MatrixXd& columns, const Eigen::MatrixXd& coefficients) {
    const Eigen::Index points = mean.size() / 3;
    Eigen::VectorXd squared = Eigen::VectorXd::Zero(points);
    for (Eigen::Index f = 0; f < coefficients.cols(); ++f) {
        const Eigen::VectorXd offset = mean + columns * coefficients.col(f);
        for (Eigen::Index p = 0; p < points; ++p) squared[p] += offset.segment<3>(3 * p).squaredNorm();
    }
    squared /= double(std::max<Eigen::Index>(1, coefficients.cols()));
    std::vector<double> sorted(squared.begin(), squared.end());
    std::ranges::nth_element(sorted, sorted.begin() + std::ptrdiff_t(sorted.size() / 8));
    const double floor = std::max(1e-8, sorted.empty() ? 0 : sorted[sorted.size() / 8]);
    return (floor / (floor + squared.array())).square().cast<float>();
}

}  // namespace

FrameProjector::FrameProjector(const TrainingTake& take, const MotionBasis& basis, PointsRef reference)
    : basis_(basis), shape_(take.shape()), reference_(reference), mean_(coding::mean_of(basis).cast<double>()),
      columns_(coding::components_of(basis).cast<double>() * MotionBasis::kFraction), gram_(columns_.transpose() * columns_),
      last_(Eigen::VectorXd::Zero(columns_.cols())) {
    Eigen::MatrixXd regular = gram_;
    regular.diagonal().array() += 1e-9;
    solver_.compute(regular);
    // The take's coefficients count its own steps.
    if (shape_.coordinates == 3 && shape_.pose)
        steadiness_ = steadiness(mean_, columns_, take.samples.bottomRows(columns_.cols()) * double(take.basis.step / basis.step));
}

Eigen::VectorXd FrameProjector::sides(const MotionFrame& frame) {
    Eigen::VectorXd sides(shape_.side_channels());
    int row = 0;
    if (shape_.pose) {
        if (frame.pose) {
            pose_ = *frame.pose;
        } else if (shape_.coordinates == 3) {
            Points from(reference_.rows(), 3), to(reference_.rows(), 3);
            Eigen::VectorXf weights(reference_.rows());
            Eigen::Index n = 0;
            for (Eigen::Index p = 0; p < reference_.rows(); ++p) {
                const auto at = frame.values.segment<3>(3 * p);
                if (!at.allFinite()) continue;
                from.row(n) = reference_.row(p);
                to.row(n) = at.transpose();
                weights[n++] = steadiness_[p];
            }
            if (n >= 3) pose_ = fit_rigid(from.topRows(n), to.topRows(n), weights.head(n));
        }
        for (const double v : coding::pose_steps(basis_, pose_)) sides[row++] = v;
    }
    if (shape_.gaze)
        for (const double v : coding::gaze_steps(basis_, frame.gaze.value_or(Gaze{}))) sides[row++] = v;
    for (int c = 0; c < row; ++c) sides[c] -= basis_.side_mean[std::size_t(c)];
    return sides;
}

RigidPose FrameProjector::decoded_pose(const Eigen::VectorXd& sides) const {
    std::array<std::int64_t, 6> steps{};
    for (int i = 0; i < 6; ++i) steps[std::size_t(i)] = std::llround(sides[i] * MotionBasis::kFraction);
    return coding::pose_of(basis_, steps);
}

Eigen::VectorXd FrameProjector::coefficients(const MotionFrame& frame, const Eigen::VectorXd& decoded_sides) {
    Eigen::VectorXd left = frame.values.cast<double>();
    if (shape_.coordinates == 3) {
        Points points = Eigen::Map<const Points>(frame.values.data(), frame.values.size() / 3, 3);
        if (shape_.pose) apply_pose(decoded_pose(decoded_sides).inverse(), points);
        points -= reference_;
        left = Eigen::Map<const Eigen::VectorXf>(points.data(), points.size()).cast<double>();
    }
    left -= mean_;
    std::vector<Eigen::Index> missing;
    for (Eigen::Index i = 0; i < left.size(); ++i)
        if (!std::isfinite(left[i])) missing.push_back(i), left[i] = 0;
    if (columns_.cols() == 0) return last_;
    Eigen::VectorXd right = columns_.transpose() * left;
    if (missing.empty()) return last_ = solver_.solve(right);
    Eigen::MatrixXd rows(Eigen::Index(missing.size()), columns_.cols());
    for (std::size_t i = 0; i < missing.size(); ++i) rows.row(Eigen::Index(i)) = columns_.row(missing[i]);
    Eigen::MatrixXd gram = gram_;
    gram.noalias() -= rows.transpose() * rows;
    const Eigen::VectorXd hold = kHold * gram_.diagonal();
    gram.diagonal() += hold;
    right += hold.cwiseProduct(last_);
    return last_ = gram.ldlt().solve(right);
}

FrameProjector::Errors FrameProjector::errors(const MotionFrame& frame, const Eigen::VectorXd& decoded) const {
    const Eigen::VectorXd offsets = mean_ + columns_ * decoded.tail(columns_.cols());
    Errors out;
    if (shape_.coordinates == 1) {
        const Eigen::VectorXd off = (offsets - frame.values.cast<double>()).cwiseAbs();
        return {off.squaredNorm(), off.size() ? off.maxCoeff() : 0, off.size()};
    }
    Points points = reference_;
    for (Eigen::Index p = 0; p < points.rows(); ++p) points.row(p) += offsets.segment<3>(3 * p).transpose().cast<float>();
    if (shape_.pose) apply_pose(decoded_pose(decoded), points);
    for (Eigen::Index p = 0; p < points.rows(); ++p) {
        const auto truth = frame.values.segment<3>(3 * p);
        if (!truth.allFinite()) continue;
        const double squared = (points.row(p).transpose() - truth).cast<double>().squaredNorm();
        out.squared += squared;
        out.peak = std::max(out.peak, std::sqrt(squared));
        ++out.points;
    }
    return out;
}

}  // namespace mien::encoder
