#include "encoder/motion_search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "coding/motion_frames.hpp"
#include "coding/motion_values.hpp"
#include "coding/static_code.hpp"
#include "coding/vector_quantiser.hpp"
#include "encoder/motion_peaks.hpp"

namespace mien::encoder {
namespace {

using coding::MotionBasis;
using coding::MotionScheme;
using coding::PointOrder;

constexpr std::array<std::uint8_t, PointOrder::kLevels> kLevelSteps{32, 22, 14, 10, 7, 6, 6, 6};
constexpr int kRounds = 5;  // of the vectors' quantiser
// Step of a vector as a part of what would weigh equally with the coefficients'. Without a mesh that predicts them vectors take
// more of the bits, and fitting the coefficients to what came of them takes back more of their error (measured).
constexpr double kMeshPrecision = 1.0, kPointPrecision = 1.3;

// Earlier point whose row of scaled basis vectors is nearest, or the point itself when none is nearer than zero.
std::vector<std::uint32_t> nearest_parents(const MotionComponents& c, std::uint32_t points, std::uint32_t coordinates) {
    constexpr std::uint32_t kMost = 2048;
    std::vector<std::uint32_t> parents(points);
    const Eigen::VectorXf weight =
        (c.coefficients.rowwise().squaredNorm() / double(std::max<Eigen::Index>(1, c.coefficients.cols()))).cwiseSqrt().cast<float>();
    const Eigen::MatrixXf rows = (c.vectors * weight.asDiagonal()).transpose();
    for (std::uint32_t i = 0; i < points; ++i) {
        parents[i] = i;
        const auto own = rows.middleCols(Eigen::Index(i) * coordinates, coordinates);
        float best = own.squaredNorm();
        for (std::uint32_t p = i > kMost ? i - kMost : 0; p < i; ++p) {
            const float apart = (own - rows.middleCols(Eigen::Index(p) * coordinates, coordinates)).squaredNorm();
            if (apart < best) best = apart, parents[i] = p;
        }
    }
    return parents;
}

}  // namespace

MotionSearch::MotionSearch(const MotionTask& task)
    : task_(task), most_components_(task.components.vectors.cols()), shared_(task.below ? Eigen::Index(task.below->size()) : 0),
      block_(task.below ? task.below->block : 64) {
    if (task.below) {
        parents_ = task.below->parents;
        order_ = basis_order(*task.below, task.shape, task.triangles, task.mirror);
    } else if (task.scheme == MotionScheme::guenter98) {
        order_ = coding::plain_order(task.shape.points);
    } else if (!task.triangles.empty()) {
        order_ = coding::mesh_order(task.shape.points, task.triangles, task.mirror);
    } else if (most_components_ > 0 && task.shape.points > 1 && task.shape.points <= 20000) {
        parents_ = nearest_parents(task.components, task.shape.points, task.shape.coordinates);
        order_ = coding::parent_order(parents_);
    } else {
        order_ = coding::plain_order(task.shape.points);
    }
}

void MotionSearch::quantise_basis(MotionTrial& trial, double step, double lambda, std::vector<double>& vector_bits) const {
    MotionBasis& basis = trial.basis;
    const MotionComponents& c = task_.components;
    const double frames = double(task_.plan.frames);
    const double precision = task_.triangles.empty() ? kPointPrecision : kMeshPrecision;
    const double unit = precision * step / std::sqrt(frames) / kLevelSteps[0];   // mm
    basis.mean_step = float(unit);
    basis.across_mesh = !task_.triangles.empty();
    basis.parents = parents_;
    basis.mirrored = !task_.mirror.empty();
    basis.level_steps = basis.across_mesh ? kLevelSteps : MotionBasis::kEvenSteps;
    // A squared unit costs frames * unit^2 of squared error over the clip.
    const double per_bit = lambda / (frames * unit * unit);
    if (task_.below) {
        MotionBasis common = refining(*task_.below);
        basis.refines = true;
        basis.shared = common.shared;
        basis.components = std::move(common.components);
        basis.across_mesh = common.across_mesh;
        basis.mirrored = common.mirrored;
        basis.level_steps = common.level_steps;
    }
    coding::VectorQuantiser quantiser(task_.shape, order_, basis.level_steps);
    quantiser.learn(basis.components);
    std::vector<double> values(std::size_t(task_.shape.dimension()));
    for (Eigen::Index i = 0; i < Eigen::Index(values.size()); ++i) values[std::size_t(i)] = c.mean[i] / double(basis.mean_step);
    basis.mean = quantiser.quantise(values, per_bit, kRounds);
    vector_bits.assign(std::size_t(shared_) + 1, quantiser.bits());
    // More than twice what paid at a step not much larger will not pay now.
    const Eigen::Index most = settled_                                  ? kept_
                              : kept_at_ > 0 && step > 0.6 * kept_at_ ? std::min(most_components_, 2 * kept_ + 8)
                                                                      : most_components_;
    for (Eigen::Index j = shared_; j < most; ++j) {
        const double size = std::sqrt(c.coefficients.row(j).squaredNorm() / frames) / unit;
        for (Eigen::Index i = 0; i < Eigen::Index(values.size()); ++i) values[std::size_t(i)] = c.vectors(i, j) * size;
        std::vector<std::int32_t> vector = quantiser.quantise(values, per_bit, kRounds);
        if (coding::length_of(vector) == 0) break;
        basis.components.push_back(std::move(vector));
        vector_bits.push_back(quantiser.bits());
    }
}

Eigen::MatrixXd MotionSearch::project(const MotionBasis& basis, double step, Eigen::MatrixXd& cross, Eigen::MatrixXd& gram,
                                      double& mean_error) const {
    const MotionComponents& c = task_.components;
    const Eigen::MatrixXf columns = coding::components_of(basis) * float(MotionBasis::kFraction / step);
    const Eigen::VectorXf mean_left = c.mean - coding::mean_of(basis);
    gram = (columns.transpose() * columns).cast<double>();
    cross = (columns.transpose() * c.vectors).cast<double>() * c.coefficients;
    cross.colwise() += (columns.transpose() * mean_left).cast<double>();
    mean_error = mean_left.cast<double>().squaredNorm() * double(task_.plan.frames);
    if (basis.size() == 0) return cross;
    Eigen::MatrixXd regular = gram;
    regular.diagonal().array() += 1e-9;
    return regular.ldlt().solve(cross);
}

MotionTrial MotionSearch::run(double step) {
    if (task_.scheme == MotionScheme::guenter98) return guenter(step);
    MotionTrial trial;
    trial.basis = task_.sides;
    trial.basis.scheme = task_.scheme;
    trial.basis.step = float(step);
    trial.basis.block = std::uint8_t(block_);
    trial.basis.start = start_;
    step = trial.basis.step;
    const double lambda = slope_ * step * step;
    std::vector<double> vector_bits;
    quantise_basis(trial, step, lambda, vector_bits);

    const int sides = task_.shape.side_channels();
    GroupOptions options{.lambda = slope_, .choose_splits = true, .train = true, .settled = &task_.side_numbers,
                         .settled_channels = sides, .below = task_.below_numbers, .below_sides = task_.below_sides};
    const double coefficient_energy = task_.components.coefficients.squaredNorm();
    const int passes = start_.chances.empty() ? 3 : 2;
    for (int pass = 0; pass < passes; ++pass) {
        Eigen::MatrixXd cross, gram;
        double mean_error = 0;
        const Eigen::MatrixXd wanted = project(trial.basis, step, cross, gram, mean_error);
        Eigen::MatrixXd targets(sides + wanted.rows(), task_.plan.frames);
        targets.topRows(sides) = task_.side_targets;
        targets.bottomRows(wanted.rows()) = wanted / step;
        if (task_.scheme == MotionScheme::causal) train_predictors(trial.basis, task_.plan, targets);
        options.whole_bytes = pass > 0;
        trial.coded = code_groups(trial.basis, task_.shape, task_.plan, targets, task_.presence, options);
        const Eigen::MatrixXd got = trial.coded.samples.bottomRows(wanted.rows()) * step;
        const Eigen::MatrixXd mixed = gram * got;
        trial.squared_error = task_.components.left_out + coefficient_energy + mean_error;
        Eigen::VectorXd gain(got.rows());
        for (Eigen::Index j = 0; j < got.rows(); ++j) {
            gain[j] = 2 * got.row(j).dot(cross.row(j)) - got.row(j).dot(mixed.row(j));
            trial.squared_error -= gain[j];
        }
        // Keep the components that are worth their bits; what follows the best cut is not.
        Eigen::Index keep = 0;
        double sum = 0, best = 0;
        keep = std::min(shared_, gain.size());
        for (Eigen::Index j = shared_; j < gain.size(); ++j) {
            const double bits = vector_bits[std::size_t(j + 1)] - vector_bits[std::size_t(j)] + trial.coded.bits[sides + j];
            sum += gain[j] - lambda * bits;
            if (sum > best) best = sum, keep = j + 1;
        }
        if (settled_) {
            keep = std::min(kept_, gain.size());
        } else if (pass + 2 == passes) {
            kept_ = keep;
            kept_at_ = step;
        }
        const bool last = pass + 1 == passes;
        if (last && (tuned_at_ == 0 || step < 0.7 * tuned_at_ || step > 1.4 * tuned_at_)) {
            choose_fewest(trial, targets, options);
            tuned_at_ = step;
        }
        start_ = train_start(trial.coded, task_.plan.count(), fewest_);
        if (last) break;
        trial.basis.start = start_;
        if (keep < gain.size()) {
            trial.basis.components.resize(std::size_t(keep));
            if (!trial.basis.predictors.empty()) trial.basis.predictors.resize(std::size_t(sides + keep));
        }
    }
    trial.stored = write_motion_basis(trial.basis, task_.shape, order_);
    return trial;
}

void MotionSearch::correct(MotionTrial& trial, double peak) const {
    constexpr double kChangeBits = 12;   // about what a change costs
    const double step = double(trial.basis.step);
    CorrectionPlan plan = plan_corrections(task_.motion, trial.basis, trial.coded, task_.plan, task_.shape.coordinates, peak, kChangeBits * slope_ * step * step,
                                           task_.scheme != MotionScheme::causal);
    if (plan.points.empty()) return;
    const double before = trial.bits();
    trial.basis.corrected = std::move(plan.points);
    trial.basis.correction_step = float(plan.step);
    trial.changes = std::move(plan.changes);
    const SettledNumbers numbers = std::move(trial.coded.numbers);
    const GroupOptions options{.lambda = 0, .choose_splits = false, .settled = &numbers,
                               .settled_channels = trial.basis.channels(task_.shape), .below = task_.below_numbers,
                               .below_sides = task_.below_sides, .corrections = &trial.changes};
    trial.coded = code_groups(trial.basis, task_.shape, task_.plan,
                              Eigen::MatrixXd::Zero(trial.basis.channels(task_.shape), task_.plan.frames), task_.presence, options);
    trial.stored = write_motion_basis(trial.basis, task_.shape, order_);
    trial.correction_bytes = (trial.bits() - before) / 8;
}

MotionTrial MotionSearch::guenter(double step) {
    // Levels of every basis vector from the deviation of its coefficients; no prediction of vectors, no re-projection.
    MotionTrial trial;
    const MotionComponents& c = task_.components;
    MotionBasis& basis = trial.basis;
    basis = task_.sides;
    basis.scheme = MotionScheme::guenter98;
    basis.step = float(step);
    step = basis.step;
    const double frames = double(task_.plan.frames);
    const double unit = step / std::sqrt(frames);
    basis.mean_step = float(unit);
    for (float m : c.mean) basis.mean.push_back(std::int32_t(std::lround(m / unit)));
    for (Eigen::Index j = 0; j < c.vectors.cols(); ++j) {
        const double size = std::sqrt(c.coefficients.row(j).squaredNorm() / frames) / unit;
        // A component that no coefficient reaches is none.
        if (c.coefficients.row(j).cwiseAbs().maxCoeff() < step / 2) break;
        std::vector<std::int32_t> vector;
        for (float u : c.vectors.col(j)) vector.push_back(std::int32_t(std::lround(u * size)));
        if (coding::length_of(vector) == 0) break;
        basis.components.push_back(std::move(vector));
    }
    const int sides = task_.shape.side_channels();
    const Eigen::Index k = Eigen::Index(basis.size());
    Eigen::MatrixXd targets(sides + k, task_.plan.frames);
    targets.topRows(sides) = task_.side_targets;
    targets.bottomRows(k) = c.coefficients.topRows(k) / step;
    basis.static_codes.assign(std::size_t(sides + k) + std::size_t(k) + 1, {});
    const GroupOptions options{.lambda = 0, .choose_splits = false, .train = false, .settled = &task_.side_numbers,
                               .settled_channels = sides};
    trial.coded = code_groups(basis, task_.shape, task_.plan, targets, task_.presence, options);
    for (std::size_t channel = 0; channel < std::size_t(sides + k); ++channel) {
        coding::StaticCounter counter;
        for (std::int32_t v : trial.coded.numbers.numbers[channel]) counter.add(v);
        basis.static_codes[channel] = counter.row();
    }
    for (std::size_t j = 0; j <= std::size_t(k); ++j) {
        coding::StaticCounter counter;
        for (std::int32_t v : j ? basis.components[j - 1] : basis.mean) counter.add(v);
        basis.static_codes[std::size_t(sides + k) + j] = counter.row();
    }
    trial.coded = code_groups(basis, task_.shape, task_.plan, targets, task_.presence, options);
    Eigen::MatrixXd cross, gram;
    double mean_error = 0;
    static_cast<void>(project(basis, step, cross, gram, mean_error));
    const Eigen::MatrixXd got = trial.coded.samples.bottomRows(k) * step;
    trial.squared_error = c.left_out + c.coefficients.squaredNorm() + mean_error - 2 * got.cwiseProduct(cross).sum() +
                          got.cwiseProduct(gram * got).sum();
    trial.stored = write_motion_basis(basis, task_.shape, order_);
    return trial;
}

// Starting chances cost bits in the basis and save some in every group: how many observations make one worth sending
// depends on the clip, so it is tried.
void MotionSearch::choose_fewest(const MotionTrial& trial, const Eigen::MatrixXd& targets, const GroupOptions& options) {
    double best = 1e300;
    GroupOptions again = options;
    again.train = false;
    again.choose_splits = false;
    SettledNumbers splits = trial.coded.numbers;
    again.settled = &splits;
    for (const int fewest : {40, 160, 640, 2560, 1 << 30}) {
        MotionTrial tried;
        tried.basis = trial.basis;
        tried.basis.start = train_start(trial.coded, task_.plan.count(), fewest);
        tried.coded = code_groups(tried.basis, task_.shape, task_.plan, targets, task_.presence, again);
        MotionBasis alone = tried.basis;  // the vectors cost the same whatever the start
        alone.components.assign(alone.components.size(), std::vector<std::int32_t>(std::size_t(task_.shape.dimension()), 0));
        alone.mean.assign(std::size_t(task_.shape.dimension()), 0);
        const double bytes = double(write_motion_basis(alone, task_.shape, order_).probabilities + tried.coded.bytes);
        if (bytes < best) best = bytes, fewest_ = fewest;
    }
}

}  // namespace mien::encoder
