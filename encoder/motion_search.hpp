#pragma once

#include <vector>

#include "coding/motion_basis.hpp"
#include "core/mesh.hpp"
#include "encoder/motion_components.hpp"
#include "encoder/motion_groups.hpp"
#include "encoder/motion_matrix.hpp"

namespace mien::encoder {

/// Everything that stays the same while the step is searched for.
struct MotionTask {
    coding::MotionShape shape;
    coding::MotionScheme scheme = coding::MotionScheme::transform;
    coding::MotionBasis sides;              ///< steps, centre and means of pose and gaze
    MotionComponents components;            ///< of the motion vectors
    GroupPlan plan;
    std::vector<std::uint8_t> presence;
    MotionMatrix motion;                    ///< what the components are of, when a peak is asked for or rungs follow
    std::vector<RigidPose> poses;           ///< as decoded, one per frame; empty: none
    /// Of a rung that refines another: that one's basis and numbers, how many of its channels are pose and gaze, and all that the
    /// rungs below say, d x F.
    const coding::MotionBasis* below = nullptr;
    const SettledNumbers* below_numbers = nullptr;
    int below_sides = 0;
    Eigen::MatrixXf below_values;
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
    std::vector<std::vector<coding::MotionCorrections::Change>> changes;   ///< per frame; empty: nothing is corrected
    double correction_bytes = 0;            ///< what correct() has added
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

    /// Adds to a trial the corrections that hold every error within `peak`.
    void correct(MotionTrial& trial, double peak) const;

    /// From now on so many components are kept, so that errors and bits follow the step smoothly.
    void settle(Eigen::Index components) {
        kept_ = std::clamp(components, shared_, most_components_);
        settled_ = true;
    }
    /// As many as pay, again.
    void unsettle() { settled_ = false; }

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
    Eigen::Index shared_;       ///< components of the rung below
    int block_;
    Eigen::Index kept_ = 0;     ///< components kept ...
    double kept_at_ = 0;        ///< ... at this step
    bool settled_ = false;      ///< ... whatever the step
    double tuned_at_ = 0;       ///< step at which fewest_ was chosen
    int fewest_ = 300;          ///< observations that make a starting chance worth its bits
    double slope_ = 0.12;        ///< lambda in squared steps per bit
};

}  // namespace mien::encoder
