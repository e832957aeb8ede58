#pragma once

#include <vector>

#include "samples/performance.hpp"
#include "samples/noise.hpp"

namespace mien::samples {

/// A stressed syllable: the head nods and the brows may rise.
struct Accent {
    double time = 0;      ///< s
    float strength = 0;   ///< 0 .. 1
    bool brows = false;
};

/// A stretch of speech between two breaths.
struct Phrase {
    double start = 0, end = 0;  ///< s
    bool ends_sentence = false;
};

/// What a face does by itself: blinks, glances, breath, a head that is never quite still, and what goes with speech.
/// A continuous function of time, so it is the same at every frame rate.
class Liveliness {
public:
    Liveliness(double seconds, std::vector<Accent> accents, std::vector<Phrase> phrases, std::uint64_t seed);

    /// Adds to the weights, turns the head and the eyes. The eyes keep to what they look at while the head moves.
    void add(double time, Instant& instant) const;
    /// Times at which the lids begin to close, s.
    const std::vector<double>& blinks() const { return blink_times_; }

private:
    /// Smooth noise: a sum of sinusoids with random phases; standard deviation about one.
    class Drift {
    public:
        Drift() = default;
        Drift(Random& random, double low_hz, double high_hz);
        float operator()(double time) const;

    private:
        std::array<double, 5> frequency_{}, phase_{};
    };
    struct Blink {
        double start, closing, closed, opening;  // s
        float depth, lag;                        // lag: the left lid follows the right by so many seconds
    };
    struct Fixation {
        double start;
        float yaw, pitch;
    };

    float lid(const Blink& blink, double time) const;
    void add_head(double time, Instant& instant) const;
    void add_eyes(double time, Instant& instant) const;
    void add_face(double time, Instant& instant) const;

    double seconds_;
    std::vector<Accent> accents_;
    std::vector<Phrase> phrases_;
    std::vector<Blink> blinks_;
    std::vector<double> blink_times_;
    std::vector<Fixation> fixations_;
    Drift yaw_, pitch_, roll_, sway_, rise_, smile_, brow_, squint_, tremor_;
    double breath_phase_;
    std::array<float, kArkitCount> uneven_;  // no face is symmetric
};

/// Sets the EyeLook weights that go with a gaze, so that the lids follow the eyes.
void look(const Gaze& gaze, std::array<float, kArkitCount>& weights);
/// The gaze that EyeLook weights stand for.
Gaze gaze_of(const std::array<float, kArkitCount>& weights);

/// The pose of a head turned about the top of its neck.
RigidPose turned_on_neck(const Eigen::Quaternionf& rotation);

}  // namespace mien::samples
