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

/// Weights of samples of weight 1 by their distance from what `planes` [value][term] say; those of weight 0 keep it.
MIEN_LOOP weigh_loop(const double* x, const double* y, const double* planes, int terms, int values, double scale, double* weights) {
    constexpr int n = NormalEquations::kTogether;
    double squares[n] = {};
    for (int v = 0; v < values; ++v) {
        double left[n];
        for (int f = 0; f < n; ++f) left[f] = y[v * n + f];
        for (int k = 0; k < terms; ++k)
            for (int f = 0; f < n; ++f) left[f] -= planes[v * terms + k] * x[k * n + f];
        for (int f = 0; f < n; ++f) squares[f] += left[f] * left[f];
    }
    for (int f = 0; f < n; ++f) weights[f] /= std::sqrt(1 + squares[f] / (scale * scale));
}
MIEN_WIDE(weigh, (const double* x, const double* y, const double* planes, int terms, int values, double scale, double* weights),
          (x, y, planes, terms, values, scale, weights))

}  // namespace

LayerFit::LayerFit(int predictors, int values, std::size_t texels, int folds)
    : equations_(predictors, values), texels_(texels), folds_(folds), sums_(texels * equations_.size()) {
    const std::size_t stride = std::max<std::size_t>(1, texels / kSparse);
    for (std::size_t i = stride / 2; i < texels; i += stride) sparse_.push_back(std::uint32_t(i));
    by_fold_.assign(std::size_t(folds) * sparse_.size() * equations_.size(), 0);
}

void LayerFit::add(const std::vector<Frame>& batch) {
    constexpr int n = NormalEquations::kTogether;
    const int values = equations_.values(), predictors = equations_.predictors();
    const auto texels = std::int64_t(texels_);
    parallel_for((texels + kBlock - 1) / kBlock, [&](std::int64_t block) {
        const auto sized = [](int size) { return std::vector<double>(static_cast<std::size_t>(size)); };
        auto x = sized(predictors * n), y = sized(values * n), planes = sized(values * terms_), one = sized(predictors), own = sized(values);
        double weights[n];
        for (std::int64_t i = block * kBlock; i < std::min(texels, (block + 1) * kBlock); ++i) {
            const auto sparse = std::lower_bound(sparse_.begin(), sparse_.end(), std::uint32_t(i));
            const bool apart = sparse != sparse_.end() && *sparse == std::uint32_t(i);
            for (std::size_t k = 0; k < planes.size(); ++k) planes[k] = double(planes_[k * texels_ + std::size_t(i)]);
            for (std::size_t first = 0; first < batch.size(); first += n) {
                const int count = int(std::min<std::size_t>(n, batch.size() - first));
                bool any = false;
                for (int f = 0; f < n; ++f) {
                    weights[f] = f < count ? 1 : 0;
                    for (int v = 0; v < values && weights[f] > 0; ++v) {
                        const float value = batch[first + std::size_t(f)].values[std::size_t(v) * texels_ + std::size_t(i)];
                        y[std::size_t(v * n + f)] = double(value);
                        if (!std::isfinite(value)) weights[f] = 0;
                    }
                    if (weights[f] > 0) batch[first + std::size_t(f)].predictors(std::uint32_t(i), one.data()), any = true;
                    else std::fill(one.begin(), one.end(), 0.0);
                    for (int k = 0; k < predictors; ++k) x[std::size_t(k * n + f)] = one[std::size_t(k)];
                    for (int v = 0; v < values && weights[f] == 0; ++v) y[std::size_t(v * n + f)] = 0;
                }
                if (!any) continue;
                if (!planes.empty()) weigh(x.data(), y.data(), planes.data(), terms_, values, scale_, weights);
                equations_.add_together({sums_.data() + std::size_t(i) * equations_.size(), equations_.size()}, x.data(), y.data(), weights);
                if (!apart) continue;
                for (int f = 0; f < count; ++f) {
                    if (weights[f] == 0) continue;
                    for (int k = 0; k < predictors; ++k) one[std::size_t(k)] = x[std::size_t(k * n + f)];
                    for (int v = 0; v < values; ++v) own[std::size_t(v)] = y[std::size_t(v * n + f)];
                    double* fold = by_fold_.data() + sparse_at(batch[first + std::size_t(f)].fold, std::size_t(sparse - sparse_.begin()));
                    equations_.add({fold, equations_.size()}, one.data(), own.data(), weights[f]);
                }
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
    std::vector<double> coefficients(static_cast<std::size_t>(terms));
    for (const std::uint32_t texel : sparse_) {
        if (equations_.count(sums(texel)) == 0) continue;
        double squares = 0;
        for (int v = 0; v < values(); ++v) {
            equations_.solve(sums(texel), v, terms, degrees, ridge, coefficients.data());
            squares += equations_.squared_error(sums(texel), v, terms, coefficients.data());
        }
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
        std::vector<double> rest(equations_.size()), coefficients(static_cast<std::size_t>(terms));
        for (int fold = 0; fold < folds_; ++fold) {
            const std::span<const double> own(by_fold_.data() + sparse_at(fold, std::size_t(k)), equations_.size());
            if (equations_.count(own) == 0) continue;
            for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = sums(sparse_[std::size_t(k)])[i] - (folds_ > 1 ? own[i] : 0);
            for (int v = 0; v < equations_.values(); ++v) {
                equations_.solve(rest, v, terms, degrees, ridge, coefficients.data());
                errors[std::size_t(k)] += equations_.squared_error(own, v, terms, coefficients.data());
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
        std::vector<double> coefficients(static_cast<std::size_t>(terms));
        for (std::int64_t i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i)
            for (int v = 0; v < values(); ++v) {
                equations_.solve(sums(std::size_t(i)), v, terms, degrees, ridge, coefficients.data());
                for (int k = 0; k < terms; ++k)
                    planes[std::size_t(v * terms + k) * texels_ + std::size_t(i)] = float(coefficients[std::size_t(k)]);
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
