#include "encoder/motion_goal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "coding/motion_values.hpp"
#include "core/parallel.hpp"
#include "encoder/motion_peaks.hpp"

namespace mien::encoder {
namespace {

using coding::MotionBasis;
using protocol::MotionKind;

// Errors of a trial in the clip's own space, from the values a decoder has.
MotionErrors measure(const Clip& clip, MotionKind kind, const MotionTask& task, const MotionTrial& trial, PointsRef reference) {
    const Eigen::VectorXf mean = coding::mean_of(trial.basis);
    const Eigen::MatrixXf columns = coding::components_of(trial.basis);
    const auto corrections = held_corrections(trial.basis, task.plan, task.shape.coordinates, trial.changes);
    std::vector<double> squared(std::size_t(task.plan.frames), 0), peaks(squared), counts(squared);
    parallel_for(task.plan.frames, [&](std::int64_t f) {
        const Eigen::VectorXf w = (trial.coded.samples.col(f).tail(columns.cols()) * MotionBasis::kFraction).cast<float>();
        Eigen::VectorXf x = mean + columns * w;
        if (task.below) x += task.below_values.col(f);
        for (const model::Correction& correction : corrections[std::size_t(f)]) x[correction.at] += correction.offset;
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
        if (!task.poses.empty()) apply_pose(task.poses[std::size_t(f)], points);
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
    if (options.kbps.has_value() == (options.rms || options.peak))
        return Error{ErrorCode::invalid, "an error (RMS, peak or both) or a bitrate has to be asked for"};
    for (const auto& value : {options.rms, options.peak, options.kbps})
        if (value && (!(*value > 0) || !std::isfinite(*value)))
            return Error{ErrorCode::invalid, "the asked error or bitrate is not a positive number"};
    MotionGoal goal{options.rms, options.peak, options.kbps, options.kind};
    if (goal.rms && !goal.peak && options.preset != MotionPreset::guenter98) goal.peak = MotionOptions::kUsualPeak * *goal.rms;
    return goal;
}

bool better(const MotionGoal& goal, const MotionAnswer& a, const MotionAnswer& b) {
    return goal.kbps ? a.errors.rms < b.errors.rms : a.trial.bits() < b.trial.bits();
}

namespace {

/// One search for the step of a task.
class StepSearch {
public:
    StepSearch(const MotionGoal& goal, const Clip& clip, const MotionTask& task, PointsRef reference, const Progress& progress)
        : goal_(goal), clip_(clip), task_(task), reference_(reference), progress_(progress), search_(task),
          seconds_(double(task.plan.frames) / clip.frame_rate.value()) {
        const auto components = double(std::clamp<Eigen::Index>(task.components.vectors.cols(), 4, 24));
        step_ = goal.guess() * std::sqrt(12.0 * double(task.shape.points) / components);
    }

    Result<MotionAnswer> run() {
        if (goal_.rms || goal_.kbps) {
            meet(false);
            // With the number of components fixed where it happened to come near the goal, no step may keep it.
            if (!best_) meet(true);
        }
        if (goal_.peak) refine();
        if (!best_) return unmet();
        if (progress_) progress_("motion", kTrials, kTrials);
        return std::move(*best_);
    }

private:
    static constexpr int kTrials = 24, kLooseTrials = 6;

    // Keeps the trial when it is the best that meets the goal; returns its RMS error or rate.
    struct Outcome {
        double figure = 0, bits = 0;
        bool meets = false, improves = false;
    };
    Outcome attempt(double step) {
        if (progress_) progress_("motion", std::min(trials_, kTrials - 1), kTrials);
        ++trials_;
        MotionTrial trial = search_.run(step);
        if (goal_.peak) search_.correct(trial, *goal_.peak);
        MotionErrors errors = measure(clip_, goal_.kind, task_, trial, reference_);
        Outcome out;
        out.bits = trial.bits();
        out.figure = goal_.kbps ? out.bits / seconds_ / 1000 : errors.rms;
        out.meets = (!goal_.rms || errors.rms <= *goal_.rms) && (!goal_.peak || errors.peak <= *goal_.peak) &&
                    (!goal_.kbps || out.figure <= *goal_.kbps);
        MotionAnswer answer{std::move(trial), errors};
        out.improves = out.meets && (!best_ || better(goal_, answer, *best_));
        if (out.improves) {
            best_ = std::move(answer);
            best_figure_ = out.figure;
        }
        return out;
    }

    void meet(bool from_within);
    void refine();
    Error unmet() const;

    const MotionGoal& goal_;
    const Clip& clip_;
    const MotionTask& task_;
    PointsRef reference_;
    const Progress& progress_;
    MotionSearch search_;
    double seconds_, step_ = 1;
    int trials_ = 0;
    std::optional<MotionAnswer> best_;
    double best_figure_ = 0;
};

// The largest step that keeps the asked RMS error, or the smallest at the asked rate. from_within: the number of components is
// settled by a trial that keeps the goal, however far from it.
void StepSearch::meet(bool from_within) {
    search_.settle(false);
    const double value = goal_.rms ? *goal_.rms : *goal_.kbps;
    // Bits fall and errors grow with the step.
    const double direction = goal_.kbps ? -1 : 1;
    double step = step_, low = 0, high = 0, low_figure = 0, high_figure = 0;
    double last_step = 0, last_ratio = 0;
    bool settled = false;
    for (int trial_number = 0; trial_number < kTrials; ++trial_number) {
        const Outcome outcome = attempt(step);
        const double got = outcome.figure;
        const bool meets = got <= value;
        const bool too_fine = direction > 0 ? meets : !meets;   // a larger step is allowed or needed
        if (too_fine) low = step, low_figure = got;
        else high = step, high_figure = got;
        if (best_ && best_figure_ > 0.996 * value) break;
        const bool near = std::abs(std::log(std::max(1e-9, got) / value)) < 0.06 || trial_number + 1 == kLooseTrials;
        if (!settled && (from_within ? outcome.meets : near)) {
            // How many components pay changes by leaps: near the goal their number stays and the search begins anew.
            search_.settle();
            settled = true;
            low = high = 0;
            (too_fine ? low : high) = step;
            (too_fine ? low_figure : high_figure) = got;
        }
        const double ratio = std::max(1e-6, got) / value;
        if (low > 0 && high > 0) {
            if (high / low < 1.0005) break;
            // Between the two on a log-log line, kept off the ends.
            const double aim = std::log(value * 0.9985);
            double t = 0.5;
            const double a = std::log(std::max(1e-9, low_figure)), b = std::log(std::max(1e-9, high_figure));
            if (std::abs(b - a) > 1e-6 && trial_number % 5 != 4) t = (aim - a) / (b - a);
            step = std::exp(std::log(low) + std::clamp(t, 0.05, 0.95) * (std::log(high) - std::log(low)));
        } else {
            // Most of the error may lie outside the components, and hardly answer to the step: then the step moves further.
            double answer = 1;
            if (last_step > 0) answer = std::clamp(std::log(ratio / last_ratio) / std::log(step / last_step) * direction, 0.1, 1.0);
            const double move = std::clamp(std::pow(ratio, (direction > 0 ? -1.05 : 1.3) / answer), 0.1, 10.0);
            last_step = step, last_ratio = ratio;
            step *= too_fine ? std::max(move, 1.02) : std::min(move, 0.98);
        }
        if (step > 1e6 || step < 1e-9) break;
    }
}

// Corrections make any step keep the asked peak: a coarse one needs many of them, a fine one none. The cheapest step is looked for,
// beginning with the one that keeps the RMS error, beyond which a larger one is of no use.
void StepSearch::refine() {
    constexpr double kLittle = 0.03;   // of all bits: fewer corrections than that cannot save much
    if (best_ && 8 * best_->trial.correction_bytes < kLittle * best_->trial.bits()) return;
    search_.settle(false);
    if (best_) step_ = double(best_->trial.basis.step);
    else attempt(step_);
    double middle = step_;
    for (double ratio : {1.5, 1.2}) {
        bool moved = false;
        if (!goal_.rms)
            while (attempt(middle * ratio).improves) middle *= ratio, moved = true;
        if (!moved)
            while (attempt(middle / ratio).improves) middle /= ratio;
    }
}

Error StepSearch::unmet() const {
    const char* what = goal_.kbps ? "bitrate" : goal_.rms ? "RMS error" : "peak error";
    const char* unit = goal_.kbps ? " kbit/s" : goal_.kind == MotionKind::weights ? "" : " mm";
    const char* advice = goal_.kbps                        ? "ask for a higher one"
                         : goal_.kind == MotionKind::weights ? "ask for a larger one"
                                                             : "ask for a larger one, if the clip's unit is right and its points are those of the face model";
    const double value = goal_.kbps ? *goal_.kbps : goal_.rms ? *goal_.rms : *goal_.peak;
    return Error{ErrorCode::invalid, fmt::format("the asked {} of {:g}{} cannot be met; {}", what, value, unit, advice)};
}

}  // namespace

Result<MotionAnswer> meet(const MotionGoal& goal, const Clip& clip, const MotionTask& task, PointsRef reference, const Progress& progress) {
    return StepSearch(goal, clip, task, reference, progress).run();
}

}  // namespace mien::encoder
