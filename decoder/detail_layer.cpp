#include "decoder/detail_layer.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace mien::decoder {
namespace {

constexpr float kTurn = 1 << 14;  // one, of the rotation

int terms_of(const coding::MapHead& head) { return model::term_count(model::PolynomialOrder(head.order)); }

}  // namespace

DetailLayer::DetailLayer(std::string name, std::shared_ptr<const DetailDomain> domain, const coding::MapHead& head)
    : name_(std::move(name)), domain_(std::move(domain)), head_(head), values_(*domain_->wavelet, head.channels * terms_of(head)) {}

Result<void> DetailLayer::take(const coding::MapStage& stage) {
    if (complete() || !values_.decode(stage.coded)) return Error{ErrorCode::damaged, "stage " + std::to_string(stages_) + " of the " + name_ + " map does not decode"};
    lift_ = stage.lift;
    ++stages_;
    return {};
}

Result<model::PolynomialMap> DetailLayer::map(const std::vector<Triangle>& marker_triangles, const model::TermFactors& factors) const {
    const coding::MaskedWavelet& wavelet = *domain_->wavelet;
    const int terms = terms_of(head_);
    const float unit = std::ldexp(head_.step, head_.stages - stages_);
    std::vector<std::vector<float>> samples(static_cast<std::size_t>(values_.planes()));
    parallel_for(values_.planes(), [&](std::int64_t p) {
        std::vector<float> coefficients(wavelet.size());
        const std::int32_t* plane = values_.plane(int(p));
        for (std::size_t i = 0; i < coefficients.size(); ++i) {
            if (plane[i] == 0) continue;
            const int magnitude = std::abs(plane[i]);
            const float size = unit * (float(magnitude) + float(lift_[magnitude > 1]) / 128);
            coefficients[i] = plane[i] < 0 ? -size : size;
        }
        samples[std::size_t(p)].resize(wavelet.size());
        wavelet.inverse(coefficients.data(), samples[std::size_t(p)].data());
    });
    model::PolynomialMap map(head_.channels, model::PolynomialOrder(head_.order), domain_->map.size());
    parallel_for(map.channels * terms, [&](std::int64_t p) {
        const int channel = int(p) / terms, k = int(p) % terms;
        float* out = map.plane(channel, k);
        for (int c = 0; c < map.channels; ++c) {
            // Transposed: from the coded channels back to the map's.
            const float turn = map.channels == 3 ? float(head_.rotation[std::size_t(3 * c + channel)]) / kTurn : 1.0f;
            const std::vector<float>& from = samples[std::size_t(c * terms + k)];
            for (std::size_t i = 0; i < map.texels; ++i) out[i] += turn * from[domain_->rank[i]];
        }
    });
    model::from_trained_basis(map, domain_->map, marker_triangles, factors);
    if (!std::all_of(map.planes.begin(), map.planes.end(), [](float c) { return std::isfinite(c); })) return Error{ErrorCode::damaged, "the " + name_ + " map is not finite"};
    return map;
}

}  // namespace mien::decoder
