#include "model/polynomial_map.hpp"

#include <cassert>

#include "model/polynomial_map_avx2.hpp"

namespace mien::model {

void evaluate_plain(const PolynomialMap& map, const DomainMap& domain, const DomainParameters& parameters, float* out) {
    assert(map.texels == domain.size());
    const int terms = term_count(map.order);
    for (const DomainMap::Run& run : domain.runs) {
        const auto &q1 = parameters.d1[run.triangle], &q2 = parameters.d2[run.triangle];
        for (std::uint32_t i = run.begin; i < run.end; ++i) {
            float x[kMaxTerms];
            polynomial_terms(q1.at(domain.b1[i], domain.b2[i]), q2.at(domain.b1[i], domain.b2[i]), x);
            for (int c = 0; c < map.channels; ++c) {
                float sum = 0;
                for (int k = 0; k < terms; ++k) sum += map.plane(c, k)[i] * x[k];
                out[std::size_t(c) * map.texels + i] = sum;
            }
        }
    }
}

void evaluate(const PolynomialMap& map, const DomainMap& domain, const DomainParameters& parameters, float* out) {
    static const bool fast = avx2_available();
    if (fast) evaluate_avx2(map, domain, parameters, out);
    else evaluate_plain(map, domain, parameters, out);
}

FloatMap spread(const DomainMap& domain, int channels, const float* values, float outside) {
    FloatMap picture(domain.width, domain.height, channels);
    picture.values.assign(picture.values.size(), outside);
    for (std::size_t i = 0; i < domain.size(); ++i)
        for (int c = 0; c < channels; ++c)
            picture.values[std::size_t(domain.place[i]) * std::size_t(channels) + std::size_t(c)] = values[std::size_t(c) * domain.size() + i];
    return picture;
}

}  // namespace mien::model
