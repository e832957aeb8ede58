#pragma once

namespace mien::player {

/// Where in the performance we are, in seconds. `now` is any steady time in seconds that the caller brings, so that tests
/// bring their own. Runs by itself, and follows the sound when there is one: what is heard is the truth.
class PlayClock {
public:
    /// Stands at `media` until run().
    void set(double media) { media_ = media, running_ = false; }
    void run(double now);
    void stop(double now);
    void set_rate(double now, double rate);

    double at(double now) const { return running_ ? media_ + (now - since_) * rate_ : media_; }
    bool running() const { return running_; }
    double rate() const { return rate_; }

    /// The sound heard at `now` is `heard`. Small differences are worked off gently, so that sound positions that come in
    /// steps do not shake the picture; beyond kJump the clock jumps.
    void follow(double now, double heard);
    static constexpr double kJump = 0.12;   ///< seconds: more than this a viewer sees as lips out of step
    static constexpr double kGentle = 0.05; ///< part of the difference taken back per call

private:
    double media_ = 0;   // at since_
    double since_ = 0;
    double rate_ = 1;
    bool running_ = false;
};

}  // namespace mien::player
