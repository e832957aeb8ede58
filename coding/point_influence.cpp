#include "coding/point_influence.hpp"

#include <algorithm>
#include <functional>

namespace mien::coding {
namespace {

constexpr float kTail = 1.0f / 1024;     // shares below are left out
constexpr std::size_t kMostTerms = 256;  // of one point: along a chain of parents shares never fade

}  // namespace

PointInfluence::PointInfluence(const PointOrder& order) {
    const std::size_t N = order.order.size();
    // Rows first: from which surprises a point's value is made.
    struct Term {
        std::uint32_t position;
        float weight;
    };
    std::vector<Term> terms;
    std::vector<std::size_t> row(N + 1, 0);
    std::vector<std::uint32_t> position(N);
    std::vector<float> sum(N, 0);
    std::vector<std::uint32_t> touched;
    for (std::size_t at = 0; at < N; ++at) {
        position[order.order[at]] = std::uint32_t(at);
        float total = 0;
        for (const auto& reference : order.of(at)) total += float(reference.weight);
        touched.clear();
        for (const auto& reference : order.of(at)) {
            const std::size_t from = position[reference.point];
            const float share = float(reference.weight) / total;
            for (std::size_t i = row[from]; i < row[from + 1]; ++i) {
                float& here = sum[terms[i].position];
                if (here == 0) touched.push_back(terms[i].position);
                here += share * terms[i].weight;
            }
        }
        terms.push_back({std::uint32_t(at), 1});
        if (touched.size() > kMostTerms) {  // the latest are the nearest
            std::nth_element(touched.begin(), touched.begin() + kMostTerms, touched.end(), std::greater<>());
            for (auto p = touched.begin() + kMostTerms; p != touched.end(); ++p) sum[*p] = 0;
            touched.resize(kMostTerms);
        }
        for (const std::uint32_t p : touched) {
            if (sum[p] >= kTail) terms.push_back({p, sum[p]});
            sum[p] = 0;
        }
        row[at + 1] = terms.size();
    }
    first_.assign(N + 1, 0);
    for (const Term& term : terms) ++first_[term.position + 1];
    for (std::size_t i = 0; i < N; ++i) first_[i + 1] += first_[i];
    shares_.resize(terms.size());
    energy_.assign(N, 0);
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t at = 0; at < N; ++at)
        for (std::size_t i = row[at]; i < row[at + 1]; ++i) {
            shares_[next[terms[i].position]++] = {order.order[at], terms[i].weight};
            energy_[terms[i].position] += terms[i].weight * terms[i].weight;
        }
}

}  // namespace mien::coding
