#include "encoder/motion_goal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

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
    MotionGoal goal{options.rms, options.peak, options.kbps, options.kind, options.peak.has_value()};
    if (goal.rms && !goal.peak && options.preset != MotionPreset::guenter98) goal.peak = MotionOptions::kUsualPeak * *goal.rms;
    return goal;
}

bool better(const MotionGoal& goal, const MotionAnswer& a, const MotionAnswer& b) {
    return goal.kbps ? a.errors.rms < b.errors.rms : a.trial.bits() < b.trial.bits();
}

namespace {

/// The next step to try, from what steps have brought: moves until one is too fine and one too coarse, then closes in.
class StepGuess {
public:
    /// direction: 1 where the figure grows with the step (an error), -1 where it falls (a rate). value: the figure wanted.
    StepGuess(double value, double direction) : value_(value), direction_(direction) {}

    /// Takes in what a step has brought; returns the next, or none when no other is worth a trial.
    std::optional<double> after(double step, double figure) {
        figure = std::max(1e-9, figure);
        const bool too_fine = direction_ > 0 ? figure <= value_ : figure > value_;
        (too_fine ? low_ : high_) = {step, figure};
        const double next = low_.step > 0 && high_.step > 0 ? between() : beyond({step, figure}, too_fine);
        ++trials_;
        last_ = {step, figure};
        if (high_.step > 0 && high_.step / low_.step < 1.0005) return std::nullopt;
        if (futile_ == 2 || next > 1e6 || next < 1e-9) return std::nullopt;
        return next;
    }

    /// Forgets every step but the last, whose figure still holds.
    void begin_anew() {
        const bool too_fine = low_.step == last_.step;
        (too_fine ? high_ : low_) = {};
    }

private:
    struct Tried {
        double step = 0, figure = 0;
    };

    // On a log-log line, kept off the ends; now and then halfway, where the line misleads.
    double between() const {
        const double a = std::log(low_.figure), b = std::log(high_.figure);
        double t = 0.5;
        if (std::abs(b - a) > 1e-6 && trials_ % 5 != 4) t = (std::log(value_ * kInside) - a) / (b - a);
        return std::exp(std::log(low_.step) + std::clamp(t, 0.05, 0.95) * std::log(high_.step / low_.step));
    }

    // Most of an error may lie outside the components, and hardly answer to the step: then the step moves further, until it is
    // plain that none helps.
    double beyond(const Tried& now, bool too_fine) {
        double answer = 1;
        if (last_.step > 0) {
            const double moved = std::log(now.step / last_.step);
            answer = std::log(now.figure / last_.figure) / moved * direction_;
            // A small move may go unanswered by chance.
            if (answer > kNone) futile_ = 0;
            else if (std::abs(moved) > std::log(2.0)) ++futile_;
        }
        const double power = (direction_ > 0 ? -1.05 : 1.3) / std::clamp(answer, 0.1, 1.0);
        const double move = std::clamp(std::pow(now.figure / value_, power), 0.1, 10.0);
        return now.step * (too_fine ? std::max(move, 1.02) : std::min(move, 0.98));
    }

    static constexpr double kInside = 0.9985;   // of the wanted figure: what is aimed at
    static constexpr double kNone = 0.002;      // an answer below it is none

    double value_, direction_;
    Tried low_, high_, last_;
    int trials_ = 0, futile_ = 0;
};

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
        if (const double least = least_error(); out_of_reach(least))
            return unmet(fmt::format(": {} components of its motion leave {:.2g}", task_.components.vectors.cols(), least));
        if (goal_.rms || goal_.kbps) {
            meet(false);
            // With the number of components fixed where it happened to come near the goal, no step may keep it.
            if (!best_) meet(true);
            if (best_ && task_.scheme != coding::MotionScheme::guenter98) vary_components();
        }
        if (goal_.peak) refine();
        if (!best_) return unmet();
        if (progress_) progress_("motion", kTrials, kTrials);
        return std::move(*best_);
    }

private:
    static constexpr int kTrials = 24, kLooseTrials = 6, kVariedTrials = 4;
    static constexpr double kNear = 0.025, kClose = 0.004;   // as parts of the goal

    // What a trial has brought. It is kept as the best when it meets the goal and none was better.
    struct Outcome {
        double figure = 0;          // RMS error or rate, what the goal speaks of
        double bits = 0, rms = 0;
        Eigen::Index components = 0;
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
        out.rms = errors.rms;
        out.components = Eigen::Index(trial.basis.size());
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

    double value() const { return goal_.rms ? *goal_.rms : *goal_.kbps; }
    StepGuess guess() const { return {value(), goal_.kbps ? -1.0 : 1.0}; }
    bool close() const { return best_ && best_figure_ > (1 - kClose) * value(); }

    double least_error() const;
    bool out_of_reach(double least) const;
    void meet(bool from_within);
    void vary_components();
    bool try_components(Eigen::Index components);
    void refine();
    Error unmet(const std::string& why = "") const;

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

// RMS of what the components leave out: no step does better, but for corrections. Missing points count as found, so of them
// nothing is known.
double StepSearch::least_error() const {
    if (task_.shape.presence) return 0;
    return std::sqrt(task_.components.left_out / (double(task_.shape.points) * double(task_.plan.frames)));
}

// Whether that is plainly more than the asked error, and more than corrections of single points would mend where a peak is asked.
bool StepSearch::out_of_reach(double least) const {
    return goal_.rms && 0.9 * least > *goal_.rms && (!goal_.peak_asked || *goal_.peak > 2 * least);
}

// The largest step that keeps the asked RMS error, or the smallest at the asked rate. from_within: the number of components is
// settled by a trial that keeps the goal, however far from it.
void StepSearch::meet(bool from_within) {
    search_.unsettle();
    StepGuess guess = this->guess();
    std::optional<double> step = step_;
    bool settled = false;
    for (int trial = 0; step && trial < kTrials; ++trial) {
        const Outcome outcome = attempt(*step);
        if (close()) break;
        step = guess.after(*step, outcome.figure);
        const bool near = std::abs(std::log(std::max(1e-9, outcome.figure) / value())) < kNear || trial + 1 == kLooseTrials;
        if (settled || !(from_within ? outcome.meets : near)) continue;
        // How many components pay changes by leaps: near the goal their number stays and the search begins anew.
        search_.settle(outcome.components);
        settled = true;
        guess.begin_anew();
    }
}

// The cut by rate and distortion takes components one at a time, at one step: it does not see that others would take over some of
// what one has done, nor what the bits it cost would do for the step. So fewer and more are tried.
void StepSearch::vary_components() {
    for (const double ratio : {0.87, 1.15}) {
        bool moved = false;
        for (;;) {
            const auto now = Eigen::Index(best_->trial.basis.size()), other = Eigen::Index(std::lround(double(now) * ratio));
            if (other == now || !try_components(other)) break;
            moved = true;
        }
        if (moved) break;
    }
}

// Whether so many components do better; given up as soon as they do not promise to.
bool StepSearch::try_components(Eigen::Index components) {
    constexpr double kAnswer = 0.8;     // bits fall about so much as errors grow, in logarithms
    constexpr double kGain = 0.005;     // less is not worth a trial
    search_.settle(components);
    StepGuess guess = this->guess();
    std::optional<double> step = double(best_->trial.basis.step);
    bool improved = false;
    for (int trial = 0; step && trial < kVariedTrials; ++trial) {
        const Outcome outcome = attempt(*step);
        improved = improved || outcome.improves;
        if (outcome.improves && close()) break;
        const double ratio = outcome.figure / value();
        const double promised = goal_.rms ? outcome.bits * std::pow(ratio, kAnswer) / best_->trial.bits()
                                          : outcome.rms * std::pow(ratio, 1 / kAnswer) / best_->errors.rms;
        if (promised > 1 - kGain && !outcome.improves) break;
        step = guess.after(*step, outcome.figure);
    }
    return improved;
}

// Corrections make any step keep the asked peak: a coarse one needs many of them, a fine one none. The cheapest step is looked for,
// beginning with the one that keeps the RMS error, beyond which a larger one is of no use.
void StepSearch::refine() {
    constexpr double kLittle = 0.03;   // of all bits: fewer corrections than that cannot save much
    if (best_ && 8 * best_->trial.correction_bytes < kLittle * best_->trial.bits()) return;
    search_.unsettle();
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

Error StepSearch::unmet(const std::string& why) const {
    const char* what = goal_.kbps ? "bitrate" : goal_.rms ? "RMS error" : "peak error";
    const char* unit = goal_.kbps ? " kbit/s" : goal_.kind == MotionKind::weights ? "" : " mm";
    const char* advice = goal_.kbps                        ? "ask for a higher one"
                         : goal_.kind == MotionKind::weights ? "ask for a larger one"
                                                             : "ask for a larger one, if the clip's unit is right and its points are those of the face model";
    const double value = goal_.kbps ? *goal_.kbps : goal_.rms ? *goal_.rms : *goal_.peak;
    return Error{ErrorCode::invalid, fmt::format("the asked {} of {:g}{} cannot be met{}; {}", what, value, unit, why, advice)};
}

}  // namespace

Result<MotionAnswer> meet(const MotionGoal& goal, const Clip& clip, const MotionTask& task, PointsRef reference, const Progress& progress) {
    return StepSearch(goal, clip, task, reference, progress).run();
}

}  // namespace mien::encoder
