#include "encoder/motion_peaks.hpp"

#include <cmath>

#include "coding/motion_values.hpp"
#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

using coding::MotionBasis;
using Change = coding::MotionCorrections::Change;

// Of the allowed error. Looking ahead chooses among the few values that fit; else the nearest of the coarsest grid that always
// holds one (up to 2 / sqrt 3) costs least.
constexpr double kChosenStep = 0.6, kNearestStep = 1.0;

/// Corrections of one point in one group.
class PointWalk {
public:
    using Vector = Eigen::Vector3d;   // the last coordinates of a weight are zero

    PointWalk(const Eigen::MatrixXf& errors, Eigen::Index row, std::uint32_t coordinates, double step, double peak, double price,
              const std::vector<std::uint8_t>& there)
        : errors_(errors), row_(row), coordinates_(coordinates), step_(step), allowed_(peak * peak), price_(price), there_(there) {}

    /// found(frame, value) for every change in [first, end).
    template <class Found>
    void walk(std::int64_t first, std::int64_t end, bool look_ahead, Found&& found) const {
        Vector held = Vector::Zero();
        double burden = 0;   // squared error that `held` has added of late
        const auto change = [&](std::int64_t t, const Vector& next) {
            held = next * step_;
            burden = 0;
            found(t, next);
        };
        for (std::int64_t t = first; t < end; ++t) {
            if (!fits(held, t)) {
                change(t, look_ahead ? longest(t, end) : nearest(t));
            } else if (!held.isZero() && fits(Vector::Zero(), t)) {
                if (look_ahead) {
                    const auto [release, until] = best_release(held, t, end);
                    if (release < until) change(release, Vector::Zero());
                    t = std::min(release, until) - 1;
                } else {
                    burden = std::max(0.0, burden + added(held, t));
                    if (burden > price_) change(t, Vector::Zero());
                }
            }
        }
    }

private:
    Vector error(std::int64_t t) const {
        Vector e = Vector::Zero();
        for (std::uint32_t c = 0; c < coordinates_; ++c) e[c] = errors_(row_ + c, t);
        return e;
    }
    bool fits(const Vector& held, std::int64_t t) const { return !there_[std::size_t(t)] || (error(t) - held).squaredNorm() <= allowed_; }
    /// Squared error that `held` adds at t.
    double added(const Vector& held, std::int64_t t) const {
        return there_[std::size_t(t)] ? (error(t) - held).squaredNorm() - error(t).squaredNorm() : 0;
    }

    /// From t on, while both fit: where going back to none saves most, and the end of these frames; twice that end where it does not pay.
    std::pair<std::int64_t, std::int64_t> best_release(const Vector& held, std::int64_t t, std::int64_t end) const {
        std::int64_t until = t;
        while (until < end && fits(held, until) && fits(Vector::Zero(), until)) ++until;
        // Where `held` alone stops to fit, this change comes anyway; where none does, it has to come back.
        const double changes = until == end ? 1 : fits(Vector::Zero(), until) ? 0 : fits(held, until) ? 2 : 1;
        double sum = 0, best = changes * price_;
        std::int64_t release = until;
        for (std::int64_t f = until; f-- > t;) {
            sum += added(held, f);
            if (sum > best) best = sum, release = f;
        }
        return {release, until};
    }

    Vector nearest(std::int64_t t) const { return (error(t) / step_).array().round(); }

    // Of all values that fit at t the one that fits longest; of equals the one that fits best.
    Vector longest(std::int64_t t, std::int64_t end) const {
        const Vector middle = nearest(t);
        const int reach = int(std::ceil(std::sqrt(allowed_) / step_)) + 1;
        Vector best = middle;
        std::int64_t best_end = -1;
        double best_error = 0;
        for (int x = -reach; x <= reach; ++x)
            for (int y = coordinates_ > 1 ? -reach : 0; y <= (coordinates_ > 1 ? reach : 0); ++y)
                for (int z = coordinates_ > 1 ? -reach : 0; z <= (coordinates_ > 1 ? reach : 0); ++z) {
                    const Vector tried = middle + Vector(x, y, z);
                    double sum = 0;
                    std::int64_t until = t;
                    while (until < end && fits(tried * step_, until)) {
                        if (there_[std::size_t(until)]) sum += (error(until) - tried * step_).squaredNorm();
                        ++until;
                    }
                    if (until == t) continue;
                    if (until > best_end || (until == best_end && sum < best_error)) best = tried, best_end = until, best_error = sum;
                }
        return best;
    }

    const Eigen::MatrixXf& errors_;
    Eigen::Index row_;
    std::uint32_t coordinates_;
    double step_, allowed_, price_;
    const std::vector<std::uint8_t>& there_;
};

}  // namespace

CorrectionPlan plan_corrections(const MotionMatrix& motion, const MotionBasis& basis, const CodedGroups& coded, const GroupPlan& plan,
                                std::uint32_t coordinates, double peak, double price, bool look_ahead) {
    const double allowed = 0.998 * peak;   // what floats may add on the way to the clip's space
    CorrectionPlan out;
    out.step = double(float((look_ahead ? kChosenStep : kNearestStep) * allowed));
    const std::int64_t frames = plan.frames;
    out.changes.resize(std::size_t(frames));
    const std::size_t points = std::size_t(motion.values.rows()) / coordinates;
    const Eigen::VectorXf mean = coding::mean_of(basis);
    const Eigen::MatrixXf columns = coding::components_of(basis);
    const Eigen::MatrixXf w = (coded.samples.bottomRows(columns.cols()) * MotionBasis::kFraction).cast<float>();
    const auto present = [&](std::int64_t f, std::size_t p) { return motion.presence.empty() || motion.presence[std::size_t(f) * points + p]; };

    std::vector<std::vector<std::uint32_t>> outside(static_cast<std::size_t>(frames));
    parallel_for(frames, [&](std::int64_t f) {
        Eigen::VectorXf left = motion.values.col(f) - mean;
        left.noalias() -= columns * w.col(f);
        for (std::size_t p = 0; p < points; ++p)
            if (left.segment(Eigen::Index(p * coordinates), coordinates).squaredNorm() > allowed * allowed && present(f, p))
                outside[std::size_t(f)].push_back(std::uint32_t(p));
    });
    std::vector<std::uint8_t> ever(points, 0);
    for (const auto& here : outside)
        for (const std::uint32_t p : here) ever[p] = 1;
    for (std::size_t p = 0; p < points; ++p)
        if (ever[p]) out.points.push_back(std::uint32_t(p));
    if (out.points.empty()) return out;

    std::vector<std::vector<std::pair<std::int64_t, Change>>> found(out.points.size());
    parallel_for(std::int64_t(out.points.size()), [&](std::int64_t i) {
        const std::size_t p = out.points[std::size_t(i)];
        const Eigen::Index row = Eigen::Index(p * coordinates);
        Eigen::MatrixXf errors = motion.values.middleRows(row, coordinates);
        errors.colwise() -= mean.segment(row, coordinates);
        errors.noalias() -= columns.middleRows(row, coordinates) * w;
        std::vector<std::uint8_t> there(static_cast<std::size_t>(frames));
        for (std::int64_t f = 0; f < frames; ++f) there[std::size_t(f)] = present(f, p);
        const PointWalk point(errors, 0, coordinates, out.step, allowed, price, there);
        for (std::int64_t g = 0; g < plan.count(); ++g)
            point.walk(plan.first(g), plan.first(g) + plan.length(g), look_ahead, [&](std::int64_t f, const Eigen::Vector3d& value) {
                Change change{.at = std::uint32_t(i), .value = {}};
                for (std::size_t c = 0; c < 3; ++c) change.value[c] = std::int32_t(std::lround(value[Eigen::Index(c)]));
                found[std::size_t(i)].push_back({f, change});
            });
    });
    for (const auto& here : found)
        for (const auto& [f, change] : here) out.changes[std::size_t(f)].push_back(change);
    return out;
}

std::vector<std::vector<model::Correction>> held_corrections(const MotionBasis& basis, const GroupPlan& plan, std::uint32_t coordinates,
                                                             const std::vector<std::vector<Change>>& changes) {
    std::vector<std::vector<model::Correction>> out(static_cast<std::size_t>(plan.frames));
    if (changes.empty()) return out;
    std::vector<std::int32_t> values;
    for (std::int64_t g = 0; g < plan.count(); ++g) {
        values.assign(basis.corrected.size() * coordinates, 0);
        for (std::int64_t f = plan.first(g); f < plan.first(g) + plan.length(g); ++f) {
            for (const Change& change : changes[std::size_t(f)])
                std::copy_n(change.value.begin(), coordinates, values.begin() + std::ptrdiff_t(change.at * coordinates));
            for (std::size_t i = 0; i < values.size(); ++i)
                if (values[i] != 0)
                    out[std::size_t(f)].push_back({std::uint32_t(basis.corrected[i / coordinates] * coordinates + i % coordinates),
                                                   float(values[i]) * basis.correction_step});
        }
    }
    return out;
}

}  // namespace mien::encoder
