#pragma once

#include <vector>

#include "coding/motion_basis.hpp"
#include "core/mesh.hpp"
#include "encoder/motion_components.hpp"
#include "encoder/motion_groups.hpp"

namespace mien::encoder {

/// Everything that stays the same while the step is searched for.
struct MotionTask {
    coding::MotionShape shape;
    coding::MotionScheme scheme = coding::MotionScheme::transform;
    coding::MotionBasis sides;              ///< steps, centre and means of pose and gaze
    MotionComponents components;            ///< of the motion vectors
    GroupPlan plan;
    std::vector<std::uint8_t> presence;
    Eigen::MatrixXd side_targets;           ///< side channels x F, in steps
    SettledNumbers side_numbers;            ///< as they are coded, whatever the step
    std::span<const Triangle> triangles;    ///< of the neutral mesh, for vertex motion; empty: none
    std::span<const std::uint32_t> mirror;  ///< Mesh::mirror of that mesh, or empty
};

/// One way to code the whole clip.
struct MotionTrial {
    coding::MotionBasis basis;
    coding::BasisBytes stored;
    CodedGroups coded;
    double squared_error = 0;               ///< of the motion vectors, all frames together
    double bits() const { return 8.0 * double(stored.bytes.size() + coded.bytes); }
};

/// Codes a task at any step, carrying what one step teaches (starting probabilities, predictors, how many components pay)
/// to the next.
class MotionSearch {
public:
    explicit MotionSearch(const MotionTask& task);

    /// One trial with coefficients in steps of `step`.
    MotionTrial run(double step);

    /// From now on as many components are kept as in the last trial, so that errors and bits follow the step smoothly.
    void settle() { settled_ = true; }

private:
    MotionTrial guenter(double step);
    void choose_fewest(const MotionTrial& trial, const Eigen::MatrixXd& targets, const GroupOptions& options);
    void quantise_basis(MotionTrial& trial, double step, double lambda, std::vector<double>& vector_bits) const;
    Eigen::MatrixXd project(const coding::MotionBasis& basis, double step, Eigen::MatrixXd& cross, Eigen::MatrixXd& gram,
                            double& mean_error) const;

    const MotionTask& task_;
    coding::PointOrder order_;
    std::vector<std::uint32_t> parents_;
    coding::MotionStart start_;
    Eigen::Index most_components_;
    int block_;
    Eigen::Index kept_ = 0;     ///< components kept ...
    double kept_at_ = 0;        ///< ... at this step
    bool settled_ = false;      ///< ... whatever the step
    double tuned_at_ = 0;       ///< step at which fewest_ was chosen
    double precision_ = 1.0;    ///< basis step over the equal-slope one
    int fewest_ = 300;          ///< observations that make a starting chance worth its bits
    double slope_ = 0.12;        ///< lambda in squared steps per bit
};

}  // namespace mien::encoder
