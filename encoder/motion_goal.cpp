#include "encoder/motion_goal.hpp"

#include <algorithm>
#include <cmath>

#include "coding/motion_values.hpp"
#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

using coding::MotionBasis;
using protocol::MotionKind;

// Errors of a trial in the clip's own space, from the values a decoder has.
MotionErrors measure(const Clip& clip, MotionKind kind, const MotionTask& task, const MotionTrial& trial, PointsRef reference) {
    const Eigen::VectorXf mean = coding::mean_of(trial.basis);
    const Eigen::MatrixXf columns = coding::components_of(trial.basis);
    std::vector<double> squared(std::size_t(task.plan.frames), 0), peaks(squared), counts(squared);
    parallel_for(task.plan.frames, [&](std::int64_t f) {
        const Eigen::VectorXf w = (trial.coded.samples.col(f).tail(columns.cols()) * MotionBasis::kFraction).cast<float>();
        Eigen::VectorXf x = mean + columns * w;
        double& sum = squared[std::size_t(f)];
        double& peak = peaks[std::size_t(f)];
        if (kind == MotionKind::weights) {
            const Eigen::Map<const Eigen::VectorXf> truth(clip.weights->frame(f), clip.weights->count);
            sum = (x - truth).cast<double>().squaredNorm();
            peak = double((x - truth).cwiseAbs().maxCoeff());
            counts[std::size_t(f)] = double(truth.size());
            return;
        }
        PointsMap points(x.data(), reference.rows(), 3);
        points += reference;
        if (task.shape.pose) {
            std::array<std::int64_t, 6> steps{};
            for (int i = 0; i < 6; ++i)
                steps[std::size_t(i)] = std::llround(trial.coded.samples(i, f) * MotionBasis::kFraction);
            apply_pose(coding::pose_of(trial.basis, steps), points);
        }
        const auto truth = kind == MotionKind::vertices ? clip.vertices->frame(f) : clip.markers->frame(f);
        for (Eigen::Index p = 0; p < points.rows(); ++p) {
            if (std::isnan(truth(p, 0))) continue;
            const double error = (points.row(p) - truth.row(p)).cast<double>().squaredNorm();
            sum += error;
            peak = std::max(peak, std::sqrt(error));
            counts[std::size_t(f)] += 1;
        }
    });
    MotionErrors out;
    double sum = 0, count = 0;
    for (std::size_t f = 0; f < squared.size(); ++f) {
        sum += squared[f];
        count += counts[f];
        out.peak = std::max(out.peak, peaks[f]);
    }
    out.rms = count > 0 ? std::sqrt(sum / count) : 0;
    return out;
}

}  // namespace

Result<MotionGoal> goal_of(const MotionOptions& options) {
    const int set = int(options.rms.has_value()) + int(options.peak.has_value()) + int(options.kbps.has_value());
    if (set != 1) return Error{ErrorCode::invalid, "exactly one of RMS error, peak error and bitrate can be asked for"};
    const double value = options.rms ? *options.rms : options.peak ? *options.peak : *options.kbps;
    if (!(value > 0) || !std::isfinite(value)) return Error{ErrorCode::invalid, "the asked error or bitrate is not a positive number"};
    const auto what = options.rms ? MotionGoal::What::rms : options.peak ? MotionGoal::What::peak : MotionGoal::What::kbps;
    return MotionGoal{what, value, options.kind};
}

bool better(const MotionGoal& goal, const MotionAnswer& a, const MotionAnswer& b) {
    return goal.what == MotionGoal::What::kbps ? a.errors.rms < b.errors.rms : a.trial.bits() < b.trial.bits();
}

Result<MotionAnswer> meet(const MotionGoal& goal, const Clip& clip, const MotionTask& task, PointsRef reference,
                          const Progress& progress) {
    MotionSearch search(task);
    const double seconds = double(task.plan.frames) / clip.frame_rate.value();
    const auto figure = [&](const MotionTrial& trial, const MotionErrors& measured) {
        switch (goal.what) {
            case MotionGoal::What::rms: return measured.rms;
            case MotionGoal::What::peak: return measured.peak;
            case MotionGoal::What::kbps: return trial.bits() / seconds / 1000;
        }
        return 0.0;
    };
    // Bits fall and errors grow with the step.
    const double direction = goal.what == MotionGoal::What::kbps ? -1 : 1;
    const auto components = double(std::clamp<Eigen::Index>(task.components.vectors.cols(), 4, 24));
    double step = goal.guess() * std::sqrt(12.0 * double(task.shape.points) / components);
    std::optional<MotionAnswer> best;
    double best_figure = 0, low = 0, high = 0, low_figure = 0, high_figure = 0;
    constexpr int kTrials = 24, kLooseTrials = 6;
    bool settled = false;
    for (int trial_number = 0; trial_number < kTrials; ++trial_number) {
        if (progress) progress("motion", trial_number, kTrials);
        MotionTrial trial = search.run(step);
        const MotionErrors measured = measure(clip, goal.kind, task, trial, reference);
        const double got = figure(trial, measured);
        const bool meets = got <= goal.value;
        MotionAnswer answer{std::move(trial), measured};
        if (meets && (!best || better(goal, answer, *best))) {
            best = std::move(answer);
            best_figure = got;
        }
        const bool too_fine = direction > 0 ? meets : !meets;   // a larger step is allowed or needed
        if (too_fine) low = step, low_figure = got;
        else high = step, high_figure = got;
        if (best && best_figure > 0.996 * goal.value) break;
        if (!settled && (std::abs(std::log(std::max(1e-9, got) / goal.value)) < 0.06 || trial_number + 1 == kLooseTrials)) {
            // How many components pay changes by leaps: near the goal their number stays and the search begins anew.
            search.settle();
            settled = true;
            low = high = 0;
            (too_fine ? low : high) = step;
            (too_fine ? low_figure : high_figure) = got;
        }
        const double ratio = std::max(1e-6, got) / goal.value;
        if (low > 0 && high > 0) {
            if (high / low < 1.0005) break;
            // Between the two on a log-log line, kept off the ends.
            const double aim = std::log(goal.value * 0.9985);
            double t = 0.5;
            const double a = std::log(std::max(1e-9, low_figure)), b = std::log(std::max(1e-9, high_figure));
            if (std::abs(b - a) > 1e-6 && trial_number % 5 != 4) t = (aim - a) / (b - a);
            step = std::exp(std::log(low) + std::clamp(t, 0.05, 0.95) * (std::log(high) - std::log(low)));
        } else {
            const double move = std::clamp(std::pow(ratio, direction > 0 ? -1.05 : 1.3), 0.1, 10.0);
            step *= too_fine ? std::max(move, 1.02) : std::min(move, 0.98);
        }
        if (step > 1e6 || step < 1e-9) break;
    }
    if (!best) {
        const bool rate = goal.what == MotionGoal::What::kbps;
        const char* what = rate ? "bitrate" : goal.what == MotionGoal::What::rms ? "RMS error" : "peak error";
        const char* unit = rate ? " kbit/s" : goal.kind == MotionKind::weights ? "" : " mm";
        return Error{ErrorCode::invalid, std::string("the asked ") + what + " of " + std::to_string(goal.value) + unit +
                                             " cannot be met: this motion needs more"};
    }
    if (progress) progress("motion", kTrials, kTrials);
    return std::move(*best);
}

}  // namespace mien::encoder
