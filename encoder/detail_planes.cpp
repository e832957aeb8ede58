#include "encoder/detail_planes.hpp"

#include <algorithm>
#include <cmath>

#include <limits>

#include <Eigen/Eigenvalues>

#include "coding/coefficient_planes.hpp"
#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

constexpr float kRound = 0.4f;      // below one half: small values cost more than they say
constexpr int kRotationBits = 14;

std::int32_t quantise(float value, float inverse_step) {
    const auto magnitude = std::int32_t(std::abs(value) * inverse_step + kRound);
    return value < 0 ? -magnitude : magnitude;
}

/// Sums of `terms(plane)` over planes, added in order whatever the threads do.
template <typename Terms>
double sum_over(int planes, const Terms& terms) {
    std::vector<double> sums(static_cast<std::size_t>(planes));
    parallel_for(planes, [&](std::int64_t p) { sums[std::size_t(p)] = terms(int(p)); });
    double sum = 0;
    for (const double s : sums) sum += s;
    return sum;
}

}  // namespace

DetailPlanes::DetailPlanes(model::PolynomialMap map, const model::DomainMap& domain, const std::vector<Triangle>& marker_triangles, const model::TermFactors& factors,
                           const coding::MaskedWavelet& wavelet, const std::vector<std::uint32_t>& mask_rank)
    : wavelet_(wavelet), channels_(map.channels), order_(int(map.order)), planes_(map.channels * model::term_count(map.order)) {
    const int terms = model::term_count(map.order);
    const std::size_t n = map.texels;
    model::to_trained_basis(map, domain, marker_triangles, factors);
    Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
    if (channels_ == 3) {
        // The channels' own principal directions over all terms, rounded as they are stored.
        Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b <= a; ++b)
                moments(a, b) = moments(b, a) = sum_over(terms, [&](int k) {
                    double sum = 0;
                    for (std::size_t i = 0; i < n; ++i) sum += double(map.plane(a, k)[i]) * map.plane(b, k)[i];
                    return sum;
                });
        const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvectors().rowwise().reverse().transpose();
        for (int i = 0; i < 9; ++i) {
            rotation_[std::size_t(i)] = std::int16_t(std::lround(axes(i / 3, i % 3) * (1 << kRotationBits)));
            turn(i / 3, i % 3) = float(rotation_[std::size_t(i)]) / (1 << kRotationBits);
        }
    }
    coefficients_.resize(std::size_t(planes_) * n);
    parallel_for(planes_, [&](std::int64_t p) {
        const int channel = int(p) / terms, k = int(p) % terms;
        std::vector<float> samples(n);
        for (std::size_t i = 0; i < n; ++i) {
            float value = 0;
            for (int c = 0; c < channels_; ++c) value += (channels_ == 3 ? turn(channel, c) : 1.0f) * map.plane(c, k)[i];
            samples[mask_rank[i]] = value;
        }
        wavelet_.forward(samples.data(), coefficients_.data() + std::size_t(p) * n);
    });
}

double DetailPlanes::error(float step) const {
    const std::size_t n = wavelet_.size();
    const double squares = sum_over(planes_, [&](int p) {
        const float* c = coefficients_.data() + std::size_t(p) * n;
        double sum = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const float left = c[i] - step * float(quantise(c[i], 1 / step));
            sum += double(left) * left;
        }
        return sum;
    });
    return std::sqrt(squares / double(std::max<std::size_t>(n, 1)));
}

double DetailPlanes::largest(float step) const {
    float most = 0;
    for (const float c : coefficients_) most = std::isfinite(c) ? std::max(most, std::abs(c)) : std::numeric_limits<float>::infinity();
    return double(most) / step;
}

float DetailPlanes::step_for(double rms) const {
    double low = std::log2(rms), high = low + 8;  // a step of s leaves at most about s / 2 a plane, and far less where all is zero
    for (int i = 0; i < 12; ++i) {
        const double middle = (low + high) / 2;
        (error(float(std::exp2(middle))) <= rms ? low : high) = middle;
    }
    return float(std::exp2(low));
}

DetailPlanes::Coded DetailPlanes::code(float step, int stages) const {
    std::vector<std::int32_t> values(coefficients_.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = quantise(coefficients_[i], 1 / step);
    Coded coded{{channels_, order_, step, stages, rotation_}, {}};
    coding::CoefficientPlanes planes(wavelet_, planes_);
    for (int stage = 0; stage < stages; ++stage) {
        const int below = stages - 1 - stage;
        const double unit = std::ldexp(double(step), below);
        coding::MapStage out;
        // The mean place of what is known to lie in one interval.
        double sums[2] = {}, counts[2] = {};
        for (std::size_t i = 0; i < values.size(); ++i) {
            const std::int32_t known = std::abs(values[i]) >> below;
            if (known == 0) continue;
            sums[known > 1] += std::abs(coefficients_[i]) / unit - known;
            counts[known > 1] += 1;
        }
        for (int k = 0; k < 2; ++k) out.lift[std::size_t(k)] = std::int8_t(counts[k] > 0 ? std::clamp(std::lround(128 * sums[k] / counts[k]), -127l, 127l) : 0);
        out.coded = planes.encode(values, below);
        coded.stages.push_back(std::move(out));
    }
    return coded;
}

}  // namespace mien::encoder
