#include "encoder/motion_pose.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

constexpr std::int64_t kMaxPoints = 400;   // enough for a pose; more only costs time
constexpr std::int64_t kMaxFrames = 300;   // that the weights are learnt from
constexpr int kRounds = 6;

bool present(const Eigen::Ref<const Eigen::RowVector3f>& p) { return p.array().isFinite().all(); }

struct Fit {
    const PointSequence& sequence;
    std::vector<std::uint32_t> points;
    Points reference;  ///< of `points`

    RigidPose pose(std::int64_t f, const Eigen::VectorXf& weights, const RigidPose& otherwise) const {
        const auto frame = sequence.frame(f);
        Points from(reference.rows(), 3), to(reference.rows(), 3);
        Eigen::VectorXf w(reference.rows());
        Eigen::Index n = 0;
        for (Eigen::Index i = 0; i < reference.rows(); ++i) {
            const auto row = frame.row(points[std::size_t(i)]);
            if (!present(row) || weights[i] <= 0) continue;
            from.row(n) = reference.row(i);
            to.row(n) = row;
            w[n++] = weights[i];
        }
        if (n < 3) return otherwise;
        return fit_rigid(from.topRows(n), to.topRows(n), w.head(n));
    }
};

}  // namespace

std::vector<RigidPose> steady_poses(const PointSequence& sequence, PointsRef reference,
                                    std::span<const std::uint32_t> rigid) {
    Fit fit{.sequence = sequence, .points = {}, .reference = {}};
    std::vector<std::uint32_t> candidates(rigid.begin(), rigid.end());
    if (candidates.empty())
        for (std::int64_t p = 0; p < sequence.points; ++p) candidates.push_back(std::uint32_t(p));
    std::erase_if(candidates, [&](std::uint32_t p) { return p >= sequence.points || !present(reference.row(p)); });
    const std::size_t stride = std::max<std::size_t>(1, candidates.size() / kMaxPoints);
    for (std::size_t i = 0; i < candidates.size(); i += stride) fit.points.push_back(candidates[i]);
    fit.reference.resize(Eigen::Index(fit.points.size()), 3);
    for (std::size_t i = 0; i < fit.points.size(); ++i) fit.reference.row(Eigen::Index(i)) = reference.row(fit.points[i]);

    Eigen::VectorXf weights = Eigen::VectorXf::Ones(fit.reference.rows());
    if (rigid.empty()) {
        const std::int64_t step = std::max<std::int64_t>(1, sequence.frames / kMaxFrames);
        const std::int64_t frames = (sequence.frames + step - 1) / step;
        for (int round = 0; round < kRounds; ++round) {
            std::vector<Eigen::VectorXd> squared(static_cast<std::size_t>(frames));
            parallel_for(frames, [&](std::int64_t i) {
                const RigidPose back = fit.pose(i * step, weights, {}).inverse();
                const auto frame = sequence.frame(i * step);
                Eigen::VectorXd& here = squared[std::size_t(i)];
                here = Eigen::VectorXd::Constant(fit.reference.rows(), -1);
                for (Eigen::Index p = 0; p < fit.reference.rows(); ++p) {
                    const auto row = frame.row(fit.points[std::size_t(p)]);
                    if (present(row))
                        here[p] = (back.apply(row.transpose()) - fit.reference.row(p).transpose()).squaredNorm();
                }
            });
            Eigen::VectorXd mean = Eigen::VectorXd::Zero(fit.reference.rows());
            for (Eigen::Index p = 0; p < mean.size(); ++p) {
                double sum = 0, count = 0;
                for (const auto& here : squared)
                    if (here[p] >= 0) sum += here[p], count += 1;
                mean[p] = count > 0 ? sum / count : 1e12;
            }
            // A floor keeps one perfect point from taking all the weight.
            std::vector<double> sorted(mean.begin(), mean.end());
            std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 8), sorted.end());
            const double floor = std::max(1e-8, sorted.empty() ? 0 : sorted[sorted.size() / 8]);
            for (Eigen::Index p = 0; p < mean.size(); ++p) weights[p] = float(floor / (floor + mean[p]));
            for (float& w : weights) w *= w;
        }
    }
    std::vector<RigidPose> poses(static_cast<std::size_t>(sequence.frames));
    std::vector<std::uint8_t> fitted(poses.size(), 1);
    parallel_for(sequence.frames, [&](std::int64_t f) {
        RigidPose nobody;
        nobody.translation.setConstant(std::nanf(""));
        poses[std::size_t(f)] = fit.pose(f, weights, nobody);
        fitted[std::size_t(f)] = poses[std::size_t(f)].translation.array().isFinite().all();
    });
    for (std::size_t f = 0; f < poses.size(); ++f) {
        if (fitted[f]) continue;
        std::size_t near = f;
        if (f > 0) near = f - 1;
        else
            while (near + 1 < poses.size() && !fitted[near]) ++near;
        poses[f] = f > 0 || fitted[near] ? poses[near] : RigidPose{};
    }
    return poses;
}

double steadiest_stray(const PointSequence& sequence, PointsRef reference) {
    std::vector<double> sums(std::size_t(sequence.points), 0), counts(sums);
    const std::int64_t step = std::max<std::int64_t>(1, sequence.frames / kMaxFrames);
    for (std::int64_t f = 0; f < sequence.frames; f += step) {
        const auto frame = sequence.frame(f);
        for (Eigen::Index p = 0; p < frame.rows(); ++p) {
            if (!present(frame.row(p))) continue;
            sums[std::size_t(p)] += double((frame.row(p) - reference.row(p)).squaredNorm());
            counts[std::size_t(p)] += 1;
        }
    }
    std::vector<double> strays;
    for (std::size_t p = 0; p < sums.size(); ++p)
        if (counts[p] > 0) strays.push_back(sums[p] / counts[p]);
    if (strays.empty()) return 0;
    const auto eighth = strays.begin() + std::ptrdiff_t(strays.size() / 8);
    std::nth_element(strays.begin(), eighth, strays.end());
    return std::sqrt(*eighth);
}

}  // namespace mien::encoder
