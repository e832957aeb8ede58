#include "model/term_basis.hpp"

#include <algorithm>
#include <cassert>

#include <Eigen/Cholesky>

#include "core/parallel.hpp"

namespace mien::model {
namespace {

/// Powers (i, j) of term k.
std::pair<int, int> powers(int k) {
    int degree = 0;
    while (term_count(PolynomialOrder(degree)) <= k) ++degree;
    const int j = k - degree * (degree + 1) / 2;
    return {degree - j, j};
}

/// Calls use(texel, L) with the factor of every texel, by rows.
template <typename Use>
void each_factor(const DomainMap& domain, const std::vector<Triangle>& marker_triangles, const TermFactors& factors, int terms, const Use& use) {
    assert(terms <= factors.terms && terms <= kMaxTerms);
    const std::size_t size = TermFactors::size(terms);
    parallel_for(std::int64_t(domain.runs.size()), [&](std::int64_t r) {
        const DomainMap::Run& run = domain.runs[std::size_t(r)];
        const Triangle& corners = marker_triangles[run.triangle];
        const float *f0 = factors.at(corners[0]), *f1 = factors.at(corners[1]), *f2 = factors.at(corners[2]);
        float L[TermFactors::size(kMaxTerms)];
        for (std::uint32_t i = run.begin; i < run.end; ++i) {
            const float b1 = domain.b1[i], b2 = domain.b2[i], b0 = 1 - b1 - b2;
            for (std::size_t k = 0; k < size; ++k) L[k] = b0 * f0[k] + b1 * f1[k] + b2 * f2[k];
            use(i, L);
        }
    });
}

}  // namespace

void add_term_moments(TermMoments& moments, const DomainAxes& axes, const Deformations& S, double weight) {
    const Eigen::Index M = S.rows();
    if (moments.rows() != M) moments = TermMoments::Zero(M, TermMoments::ColsAtCompileTime);
    for (Eigen::Index m = 0; m < M; ++m) {
        const double d1 = double(S.row(m).dot(axes.q.row(m))), d2 = double(S.row(m).dot(axes.r.row(m)));
        double by_d2[7] = {weight};
        for (int j = 1; j <= 6; ++j) by_d2[j] = by_d2[j - 1] * d2;
        for (int degree = 0; degree <= 6; ++degree) {
            double by_d1 = 1;
            for (int i = 0; i <= degree; ++i, by_d1 *= d1) moments(m, moment_column(i, degree - i)) += by_d1 * by_d2[degree - i];
        }
    }
}

TermFactors term_factors(const TermMoments& moments, PolynomialOrder order, double spread) {
    constexpr double normal[7] = {1, 0, 1, 0, 3, 0, 15};  // moments of a normal variable
    const int terms = term_count(order);
    TermFactors factors{terms, {}};
    for (Eigen::Index m = 0; m < moments.rows(); ++m) {
        Eigen::MatrixXd G(terms, terms);
        for (int k = 0; k < terms; ++k)
            for (int l = 0; l < terms; ++l) {
                const auto [i, j] = powers(k);
                const auto [p, q] = powers(l);
                G(k, l) = (moments(m, moment_column(i + p, j + q)) + spread * normal[i + p] * normal[j + q]) / (1 + spread);
            }
        const Eigen::LLT<Eigen::MatrixXd> cholesky(G);
        assert(cholesky.info() == Eigen::Success);
        const Eigen::MatrixXd L = cholesky.matrixL();
        for (int k = 0; k < terms; ++k)
            for (int l = 0; l <= k; ++l) factors.values.push_back(float(L(k, l)));
    }
    return factors;
}

void to_trained_basis(PolynomialMap& map, const DomainMap& domain, const std::vector<Triangle>& marker_triangles, const TermFactors& factors) {
    const int terms = term_count(map.order);
    each_factor(domain, marker_triangles, factors, terms, [&](std::uint32_t i, const float* L) {
        for (int channel = 0; channel < map.channels; ++channel)
            for (int l = 0; l < terms; ++l) {
                float sum = 0;  // row l of L' c: only terms from l on, so that it may be written in place
                for (int k = l; k < terms; ++k) sum += L[k * (k + 1) / 2 + l] * map.plane(channel, k)[i];
                map.plane(channel, l)[i] = sum;
            }
    });
}

void from_trained_basis(PolynomialMap& map, const DomainMap& domain, const std::vector<Triangle>& marker_triangles, const TermFactors& factors) {
    const int terms = term_count(map.order);
    each_factor(domain, marker_triangles, factors, terms, [&](std::uint32_t i, const float* L) {
        for (int channel = 0; channel < map.channels; ++channel)
            for (int l = terms; l-- > 0;) {
                float value = map.plane(channel, l)[i];
                for (int k = l + 1; k < terms; ++k) value -= L[k * (k + 1) / 2 + l] * map.plane(channel, k)[i];
                map.plane(channel, l)[i] = value / L[l * (l + 1) / 2 + l];
            }
    });
}

}  // namespace mien::model
