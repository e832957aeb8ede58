#include "encoder/motion_components.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

constexpr Eigen::Index kGramSide = 700;    // larger sides go through the range finder
constexpr Eigen::Index kStrip = 64;

// Every product is split the same way whatever the thread count, so sums come out the same.
template <class Body>
void strips(Eigen::Index size, const Body& body) {
    const Eigen::Index count = (size + kStrip - 1) / kStrip;
    parallel_for(count, [&](std::int64_t i) { body(i * kStrip, std::min<Eigen::Index>(kStrip, size - i * kStrip)); });
}

// (values - mean 1') * right, right: F x n
Eigen::MatrixXf times(const Eigen::MatrixXf& values, const Eigen::VectorXf& mean, const Eigen::MatrixXf& right) {
    Eigen::MatrixXf out(values.rows(), right.cols());
    const Eigen::RowVectorXf sums = right.colwise().sum();
    strips(values.rows(), [&](Eigen::Index at, Eigen::Index n) {
        out.middleRows(at, n).noalias() = values.middleRows(at, n) * right;
        out.middleRows(at, n).noalias() -= mean.segment(at, n) * sums;
    });
    return out;
}

// left' * (values - mean 1'), left: d x n
Eigen::MatrixXf transposed_times(const Eigen::MatrixXf& left, const Eigen::MatrixXf& values, const Eigen::VectorXf& mean) {
    Eigen::MatrixXf out(left.cols(), values.cols());
    const Eigen::VectorXf shift = left.transpose() * mean;
    strips(values.cols(), [&](Eigen::Index at, Eigen::Index n) {
        out.middleCols(at, n).noalias() = left.transpose() * values.middleCols(at, n);
        out.middleCols(at, n).colwise() -= shift;
    });
    return out;
}

Eigen::MatrixXf orthonormal(const Eigen::MatrixXf& columns) {
    const Eigen::HouseholderQR<Eigen::MatrixXf> qr(columns);
    return qr.householderQ() * Eigen::MatrixXf::Identity(columns.rows(), columns.cols());
}

Eigen::Index enough_of(const Eigen::VectorXd& energies, double total, double enough, Eigen::Index most) {
    Eigen::Index count = 0;
    double left = total;
    const double floor = 1e-10 * std::max(total, 1e-30);
    while (count < std::min(most, energies.size()) && left > enough && energies[count] > floor) left -= energies[count++];
    return count;
}

// Signs are free; the largest entry is made positive so that they do not depend on chance.
void fix_signs(MotionComponents& c) {
    for (Eigen::Index j = 0; j < c.vectors.cols(); ++j) {
        Eigen::Index at = 0;
        c.vectors.col(j).cwiseAbs().maxCoeff(&at);
        if (c.vectors(at, j) < 0) {
            c.vectors.col(j) *= -1;
            c.coefficients.row(j) *= -1;
        }
    }
}

}  // namespace

MotionComponents find_components(const Eigen::MatrixXf& values, double enough, int most) {
    const Eigen::Index d = values.rows(), frames = values.cols();
    MotionComponents out;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(d);
    for (Eigen::Index f = 0; f < frames; ++f) mean += values.col(f).cast<double>();
    out.mean = (mean / double(std::max<Eigen::Index>(1, frames))).cast<float>();
    double total = 0;
    for (Eigen::Index f = 0; f < frames; ++f) total += (values.col(f) - out.mean).cast<double>().squaredNorm();

    const Eigen::Index side = std::min(d, frames);
    if (side <= kGramSide) {
        const bool wide = d <= frames;
        Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(side, side);
        // Strips over the long side, added up in order.
        const Eigen::Index longer = wide ? frames : d;
        const Eigen::Index parts = std::min<Eigen::Index>(16, (longer + 255) / 256);
        std::vector<Eigen::MatrixXd> sums(static_cast<std::size_t>(parts));
        parallel_for(parts, [&](std::int64_t i) {
            const Eigen::Index begin = longer * i / parts, end = longer * (i + 1) / parts;
            Eigen::MatrixXd& sum = sums[std::size_t(i)];
            sum = Eigen::MatrixXd::Zero(side, side);
            for (Eigen::Index at = begin; at < end; at += 256) {
                const Eigen::Index n = std::min<Eigen::Index>(256, end - at);
                if (wide) {
                    const Eigen::MatrixXd block = (values.middleCols(at, n).colwise() - out.mean).cast<double>();
                    sum.selfadjointView<Eigen::Lower>().rankUpdate(block);
                } else {
                    const Eigen::MatrixXd block = (values.middleRows(at, n).colwise() - out.mean.segment(at, n)).cast<double>();
                    sum.selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
                }
            }
        });
        for (const auto& sum : sums) gram += sum;
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
        const Eigen::VectorXd energies = eigen.eigenvalues().reverse().cwiseMax(0);
        const Eigen::Index k = enough_of(energies, total, enough, most);
        const Eigen::MatrixXd vectors = eigen.eigenvectors().rowwise().reverse().leftCols(k);
        if (wide) {
            out.vectors = vectors.cast<float>();
            out.coefficients = transposed_times(out.vectors, values, out.mean).cast<double>();
        } else {
            const Eigen::VectorXd scale = energies.head(k).cwiseSqrt();
            out.vectors = times(values, out.mean, (vectors * scale.cwiseInverse().asDiagonal()).cast<float>());
            out.coefficients = scale.asDiagonal() * vectors.transpose();
        }
        out.left_out = std::max(0.0, total - energies.head(k).sum());
        fix_signs(out);
        return out;
    }

    std::mt19937 random(1998);
    Eigen::Index wanted = std::min<Eigen::Index>(std::min<Eigen::Index>(most, side), 48);
    for (;; wanted = std::min<Eigen::Index>(std::min<Eigen::Index>(most, side), wanted * 2)) {
        const Eigen::Index sampled = std::min<Eigen::Index>(side, wanted + 12);
        Eigen::MatrixXf omega(frames, sampled);
        for (float& x : omega.reshaped()) x = float(random()) / 4294967296.0f * 2 - 1;
        Eigen::MatrixXf range = orthonormal(times(values, out.mean, omega));
        for (int power = 0; power < 2; ++power) {
            const Eigen::MatrixXf back = orthonormal(transposed_times(range, values, out.mean).transpose());
            range = orthonormal(times(values, out.mean, back));
        }
        const Eigen::MatrixXd inner = transposed_times(range, values, out.mean).cast<double>();
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(inner * inner.transpose());
        const Eigen::VectorXd energies = eigen.eigenvalues().reverse().cwiseMax(0);
        const Eigen::Index k = enough_of(energies, total, enough, wanted);
        const bool done = k < wanted || wanted >= std::min<Eigen::Index>(most, side);
        if (!done) continue;
        const Eigen::MatrixXd turn = eigen.eigenvectors().rowwise().reverse().leftCols(k);
        out.vectors = range * turn.cast<float>();
        out.coefficients = turn.transpose() * inner;
        out.left_out = std::max(0.0, total - energies.head(k).sum());
        fix_signs(out);
        return out;
    }
}

}  // namespace mien::encoder
