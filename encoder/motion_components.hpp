#pragma once

#include <Eigen/Core>

namespace mien::encoder {

/// values ~ mean + vectors * coefficients, with orthonormal vectors in the order of their energy.
struct MotionComponents {
    Eigen::VectorXf mean;          ///< d
    Eigen::MatrixXf vectors;       ///< d x K
    Eigen::MatrixXd coefficients;  ///< K x F
    double left_out = 0;           ///< squared Frobenius norm of what is not covered
};

/// Principal components of the columns of `values` (d x F), at most `most`, until what is left out is at most `enough`.
/// Eigenvectors of the smaller Gram matrix; for large d and F the randomised range finder of Halko, Martinsson and Tropp
/// 2011 (algorithms 4.4 and 5.1) with a fixed seed. The same for any thread count.
MotionComponents find_components(const Eigen::MatrixXf& values, double enough, int most);

}  // namespace mien::encoder
