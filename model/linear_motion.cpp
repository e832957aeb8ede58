#include "model/linear_motion.hpp"

#include <algorithm>

namespace mien::model {

Eigen::VectorXf motion_vector(const LinearMotion& basis, const Motion& motion) {
    Eigen::VectorXf x(basis.dimension());
    motion_vector(basis, motion, basis.mean, x);
    return x;
}

void motion_vector(const LinearMotion& basis, const Motion& motion, const Eigen::VectorXf& start, Eigen::Ref<Eigen::VectorXf> out) {
    if (basis.packed.empty()) {
        out = start;
        out.noalias() += basis.components * motion.coefficients;
    } else {
        const auto numbers = [](const Eigen::VectorXf& v) { return std::span(v.data(), std::size_t(v.size())); };
        basis.packed.sum(numbers(start), numbers(motion.coefficients), std::span(out.data(), std::size_t(out.size())));
    }
    for (const Correction& correction : motion.corrections) {
        if (basis.spread.size() == 0) out[correction.at] += correction.offset;
        else out += correction.offset * basis.spread.col(correction.at);
    }
}

void merge_corrections(std::vector<Correction>& corrections, std::span<const Correction> more) {
    if (more.empty()) return;
    corrections.insert(corrections.end(), more.begin(), more.end());
    std::stable_sort(corrections.begin(), corrections.end(), [](const Correction& a, const Correction& b) { return a.at < b.at; });
    std::size_t kept = 0;
    for (const Correction& next : corrections) {
        if (kept > 0 && corrections[kept - 1].at == next.at) corrections[kept - 1].offset += next.offset;
        else corrections[kept++] = next;
    }
    corrections.resize(kept);
}

std::vector<Correction> drawn_corrections(const Eigen::SparseMatrix<float>& spread, std::span<const Correction> corrections) {
    if (spread.size() == 0) return {corrections.begin(), corrections.end()};
    std::vector<Correction> all, drawn;
    for (const Correction& correction : corrections)
        for (Eigen::SparseMatrix<float>::InnerIterator entry(spread, correction.at); entry; ++entry)
            all.push_back({std::uint32_t(entry.row()), correction.offset * entry.value()});
    merge_corrections(drawn, all);
    return drawn;
}

}  // namespace mien::model
