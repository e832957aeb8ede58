#include "analysis/layer_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "core/wide.hpp"

namespace mien::analysis {
namespace {

constexpr std::size_t kSparse = 1500;
constexpr std::int64_t kBlock = 1024;  // texels that one thread takes at a time

/// Weighs n samples by their distance from what `planes` [value][term] say; those of weight 0 keep it. `left`: room for n numbers, twice.
MIEN_LOOP weigh_loop(const double* x, const double* y, const double* planes, int n, int terms, int values, double scale, double* left, double* weights) {
    double* const squares = left + n;
    for (int f = 0; f < n; ++f) squares[f] = 0;
    for (int v = 0; v < values; ++v) {
        for (int f = 0; f < n; ++f) left[f] = y[v * n + f];
        for (int k = 0; k < terms; ++k)
            for (int f = 0; f < n; ++f) left[f] -= planes[v * terms + k] * x[k * n + f];
        for (int f = 0; f < n; ++f) squares[f] += left[f] * left[f];
    }
    const double inverse = 1 / (scale * scale);
    for (int f = 0; f < n; ++f) weights[f] /= std::sqrt(1 + squares[f] * inverse);
}
MIEN_WIDE(weigh, (const double* x, const double* y, const double* planes, int n, int terms, int values, double scale, double* left, double* weights),
          (x, y, planes, n, terms, values, scale, left, weights))

}  // namespace

LayerFit::LayerFit(int predictors, int values, std::size_t texels, int folds)
    : equations_(predictors, values), texels_(texels), folds_(folds), sums_(texels * equations_.size()) {
    const std::size_t stride = std::max<std::size_t>(1, texels / kSparse);
    for (std::size_t i = stride / 2; i < texels; i += stride) sparse_.push_back(std::uint32_t(i));
    by_fold_.assign(std::size_t(folds) * sparse_.size() * equations_.size(), 0);
}

void LayerFit::add(const std::vector<Frame>& batch, const Drive& drive) {
    if (batch.empty()) return;
    const int values = equations_.values(), predictors = equations_.predictors(), n = NormalEquations::padded(batch.size());
    const auto texels = std::int64_t(texels_);
    parallel_for((texels + kBlock - 1) / kBlock, [&](std::int64_t block) {
        const auto sized = [](int size) { return std::vector<double>(static_cast<std::size_t>(size)); };
        auto x = sized(predictors * n), y = sized(values * n), weights = sized(n), room = sized(2 * n), planes = sized(values * terms_), one = sized(predictors), own = sized(values);
        for (std::int64_t i = block * kBlock; i < std::min(texels, (block + 1) * kBlock); ++i) {
            std::fill(weights.begin(), weights.begin() + std::ptrdiff_t(batch.size()), 1.0);
            for (int v = 0; v < values; ++v)
                for (std::size_t f = 0; f < batch.size(); ++f) {
                    const float value = batch[f].values[std::size_t(v) * texels_ + std::size_t(i)];
                    const bool seen = std::isfinite(value);
                    y[std::size_t(v * n) + f] = seen ? double(value) : 0.0;
                    weights[f] = seen ? weights[f] : 0.0;
                }
            if (std::none_of(weights.begin(), weights.end(), [](double w) { return w > 0; })) continue;
            drive(std::uint32_t(i), x.data());
            if (!planes_.empty()) {
                for (std::size_t k = 0; k < planes.size(); ++k) planes[k] = double(planes_[k * texels_ + std::size_t(i)]);
                weigh(x.data(), y.data(), planes.data(), n, terms_, values, scale_, room.data(), weights.data());
            }
            equations_.add_together({sums_.data() + std::size_t(i) * equations_.size(), equations_.size()}, n, x.data(), y.data(), weights.data());
            const auto sparse = std::lower_bound(sparse_.begin(), sparse_.end(), std::uint32_t(i));
            if (sparse == sparse_.end() || *sparse != std::uint32_t(i)) continue;
            for (std::size_t f = 0; f < batch.size(); ++f) {
                if (weights[f] == 0) continue;
                for (int k = 0; k < predictors; ++k) one[std::size_t(k)] = x[std::size_t(k * n) + f];
                for (int v = 0; v < values; ++v) own[std::size_t(v)] = y[std::size_t(v * n) + f];
                double* fold = by_fold_.data() + sparse_at(batch[f].fold, std::size_t(sparse - sparse_.begin()));
                equations_.add({fold, equations_.size()}, one.data(), own.data(), weights[f]);
            }
        }
    });
}

void LayerFit::keep(const std::vector<std::uint32_t>& texels) {
    const std::size_t size = equations_.size();
    std::vector<std::uint32_t> sparse;
    std::vector<std::size_t> from;
    for (std::size_t i = 0, k = 0; i < texels.size(); ++i) {
        std::copy_n(sums_.begin() + std::ptrdiff_t(texels[i] * size), size, sums_.begin() + std::ptrdiff_t(i * size));
        while (k < sparse_.size() && sparse_[k] < texels[i]) ++k;
        if (k < sparse_.size() && sparse_[k] == texels[i]) {
            sparse.push_back(std::uint32_t(i));
            from.push_back(k);
        }
    }
    std::vector<double> by_fold;
    for (int fold = 0; fold < folds_; ++fold)
        for (const std::size_t k : from)
            by_fold.insert(by_fold.end(), by_fold_.begin() + std::ptrdiff_t(sparse_at(fold, k)), by_fold_.begin() + std::ptrdiff_t(sparse_at(fold, k) + size));
    texels_ = texels.size();
    sums_.resize(texels_ * size);
    sparse_ = std::move(sparse);
    by_fold_ = std::move(by_fold);
}

void LayerFit::reweigh(std::vector<float> planes, int terms, double scale) {
    assert(planes.size() == std::size_t(values() * terms) * texels_ && scale > 0);
    planes_ = std::move(planes);
    terms_ = terms;
    scale_ = scale;
    std::fill(sums_.begin(), sums_.end(), 0.0);
    std::fill(by_fold_.begin(), by_fold_.end(), 0.0);
}

std::vector<double> LayerFit::errors(int terms, const std::vector<int>& degrees, const Ridge& ridge) const {
    std::vector<double> errors;
    std::vector<double> coefficients(std::size_t(values() * terms));
    for (const std::uint32_t texel : sparse_) {
        if (equations_.count(sums(texel)) == 0) continue;
        equations_.solve(sums(texel), terms, degrees, ridge, coefficients.data());
        double squares = 0;
        for (int v = 0; v < values(); ++v) squares += equations_.squared_error(sums(texel), v, terms, coefficients.data() + v * terms);
        errors.push_back(std::sqrt(squares / equations_.count(sums(texel))));
    }
    return errors;
}

double LayerFit::typical_error(int terms, const std::vector<int>& degrees, const Ridge& ridge) const {
    std::vector<double> left = errors(terms, degrees, ridge);
    if (left.empty()) return 0;
    const auto middle = left.begin() + std::ptrdiff_t(left.size() / 2);
    std::nth_element(left.begin(), middle, left.end());
    return *middle;
}

double LayerFit::noise_for(double share, int terms, const std::vector<int>& degrees, const Ridge& ridge) const {
    const std::vector<double> left = errors(terms, degrees, ridge);
    // Distances grow with the root of their mean square: sum sqrt(e^2 + noise^2) = (1 + share) sum e.
    const auto sum = [&](double noise) {
        double all = 0;
        for (const double e : left) all += std::hypot(e, noise);
        return all;
    };
    const double most = (1 + share) * sum(0);
    double low = 0, high = left.empty() ? 0 : most / double(left.size());
    for (int i = 0; i < 40; ++i) {
        const double middle = (low + high) / 2;
        (sum(middle) <= most ? low : high) = middle;
    }
    return low;
}

double LayerFit::left_out_error(int terms, const std::vector<int>& degrees, const Ridge& ridge) const {
    std::vector<double> errors(sparse_.size(), 0), counts(sparse_.size(), 0);
    parallel_for(std::int64_t(sparse_.size()), [&](std::int64_t k) {
        std::vector<double> rest(equations_.size()), coefficients(std::size_t(values() * terms));
        for (int fold = 0; fold < folds_; ++fold) {
            const std::span<const double> own(by_fold_.data() + sparse_at(fold, std::size_t(k)), equations_.size());
            if (equations_.count(own) == 0) continue;
            for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = sums(sparse_[std::size_t(k)])[i] - (folds_ > 1 ? own[i] : 0);
            equations_.solve(rest, terms, degrees, ridge, coefficients.data());
            for (int v = 0; v < values(); ++v) {
                errors[std::size_t(k)] += equations_.squared_error(own, v, terms, coefficients.data() + v * terms);
                counts[std::size_t(k)] += equations_.count(own);
            }
        }
    });
    // By texel: a few wild ones would decide over a mean of squares.
    double sum = 0, seen = 0;
    for (std::size_t k = 0; k < errors.size(); ++k)
        if (counts[k] > 0) sum += std::sqrt(errors[k] / counts[k]), seen += 1;
    return seen > 0 ? sum / seen : 0;
}

std::vector<float> LayerFit::solve(int terms, const std::vector<int>& degrees, const Ridge& ridge) const {
    std::vector<float> planes(std::size_t(values() * terms) * texels_);
    const auto n = std::int64_t(texels_);
    parallel_for((n + kBlock - 1) / kBlock, [&](std::int64_t block) {
        std::vector<double> coefficients(std::size_t(values() * terms));
        for (std::int64_t i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i) {
            equations_.solve(sums(std::size_t(i)), terms, degrees, ridge, coefficients.data());
            for (std::size_t k = 0; k < coefficients.size(); ++k) planes[k * texels_ + std::size_t(i)] = float(coefficients[k]);
        }
    });
    return planes;
}

Ridge choose_ridge(const LayerFit& fit, int terms, const std::vector<int>& degrees, int takes) {
    if (takes < 3) return kDefaultRidge;
    Ridge ridge{0, 0, 0, true};
    const auto choose = [&](int first_terms, double Ridge::* strength, std::initializer_list<double> candidates) {
        double least = std::numeric_limits<double>::infinity(), best = 0;
        for (const double candidate : candidates) {
            ridge.*strength = candidate;
            if (const double error = fit.left_out_error(first_terms, degrees, ridge); error < least) least = error, best = candidate;
        }
        ridge.*strength = best;
    };
    const auto up_to = [&](int degree) {
        int count = 0;
        while (count < terms && degrees[std::size_t(count)] <= degree) ++count;
        return count;
    };
    choose(up_to(1), &Ridge::linear, {1e-5, 1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.3});
    if (up_to(2) > up_to(1)) choose(up_to(2), &Ridge::quadratic, {0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30});
    if (up_to(3) > up_to(2)) choose(up_to(3), &Ridge::cubic, {0.1, 1, 10, 100, 1000});
    return ridge;
}

}  // namespace mien::analysis
