#include <gtest/gtest.h>

#include <random>

#include "encoder/motion_peaks.hpp"

namespace mien::encoder {
namespace {

/// One weight that the components do not tell at all: its value is its error.
struct OneWeight {
    explicit OneWeight(std::vector<float> errors) {
        motion.values = Eigen::Map<Eigen::MatrixXf>(errors.data(), 1, Eigen::Index(errors.size()));
        plan.frames = std::int64_t(errors.size());
        plan.group_frames = 0;
        basis.mean = {0};
        coded.samples = Eigen::MatrixXd::Zero(0, plan.frames);
    }

    struct Outcome {
        int changes = 0;
        double squared = 0, peak = 0;
    };
    Outcome correct(double peak, double price, bool look_ahead) {
        const CorrectionPlan corrections = plan_corrections(motion, basis, coded, plan, 1, peak, price, look_ahead);
        coding::MotionBasis corrected = basis;
        corrected.corrected = corrections.points;
        corrected.correction_step = float(corrections.step);
        const auto held = held_corrections(corrected, plan, 1, corrections.changes);
        Outcome out;
        for (std::size_t f = 0; f < held.size(); ++f) {
            double error = double(motion.values(0, Eigen::Index(f)));
            for (const auto& correction : held[f]) error -= double(correction.offset);
            out.changes += int(corrections.changes[f].size());
            out.squared += error * error;
            out.peak = std::max(out.peak, std::abs(error));
        }
        return out;
    }

    MotionMatrix motion;
    GroupPlan plan;
    coding::MotionBasis basis;
    CodedGroups coded;
};

std::vector<float> little_noise(std::size_t frames) {
    std::mt19937 random(7);
    std::normal_distribution<float> noise(0, 0.05f);
    std::vector<float> errors(frames);
    for (float& e : errors) e = 0.01f + std::min(std::abs(noise(random)), 0.2f);   // to one side, as a wrong mean leaves it
    return errors;
}

TEST(CorrectionsPlan, OneOutlierIsNotHeldToTheEndOfALongGroup) {
    std::vector<float> errors = little_noise(2000);
    const double noise = Eigen::Map<Eigen::VectorXf>(errors.data(), 2000).cast<double>().squaredNorm();
    errors[100] = 1.3f;   // held on, a correction of 0.3 keeps what follows within 1, too
    for (const bool look_ahead : {true, false}) {
        OneWeight weight(errors);
        const auto held = weight.correct(1, 1e9, look_ahead), released = weight.correct(1, 0.5, look_ahead);
        EXPECT_EQ(held.changes, 1);
        EXPECT_GT(held.squared, 4 * noise) << "or this shows nothing";
        EXPECT_EQ(released.changes, 2);
        EXPECT_LT(released.squared, noise + 3) << look_ahead;   // the outlier's rest, and what it takes to notice
        EXPECT_LE(released.peak, 1);
    }
}

TEST(CorrectionsPlan, WhatIsSoonNeededAgainIsHeld) {
    std::vector<float> errors = little_noise(400);
    for (std::size_t f = 50; f < 350; f += 5) errors[f] = 1.3f;
    OneWeight weight(errors);
    const auto outcome = weight.correct(1, 5, true);
    EXPECT_EQ(outcome.changes, 2) << "one to begin with, one to end";
    EXPECT_LE(outcome.peak, 1);
}

TEST(CorrectionsPlan, AnyPriceKeepsThePeakAndThePriceOfAllIsLower) {
    std::mt19937 random(3);
    std::normal_distribution<float> noise(0, 0.3f);
    double asked_cost = 0, never_cost = 0;
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<float> errors(300);
        float drift = 0;
        for (float& e : errors) e = (drift = 0.95f * drift + 0.3f * noise(random)) + noise(random) * (random() % 40 == 0 ? 6.0f : 0.3f);
        OneWeight weight(errors);
        const double price = 0.01 * double(1 << (trial % 10));
        for (const bool look_ahead : {true, false}) {
            const auto asked = weight.correct(0.5, price, look_ahead), never = weight.correct(0.5, 1e9, look_ahead);
            EXPECT_LE(asked.peak, 0.5);
            EXPECT_LE(never.peak, 0.5);
            if (!look_ahead) continue;
            asked_cost += asked.squared + price * asked.changes;
            never_cost += never.squared + price * never.changes;
        }
    }
    EXPECT_LT(asked_cost, never_cost);
}

}  // namespace
}  // namespace mien::encoder
