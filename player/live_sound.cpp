#include "player/live_sound.hpp"

#include <algorithm>
#include <cmath>

namespace mien::player {
namespace {

constexpr double kLongestGap = 0.25;   // seconds that are bridged with silence
constexpr double kBacklog = 0.02;      // seconds: who joins gets the group that is under way at once, and begins with the last of it
constexpr double kDrift = 0.001;       // that clocks may run apart: followed in ten seconds
constexpr double kFarBehind = 0.12;    // seconds more than at first: what waits is dropped
constexpr double kSmoothing = 0.02;    // of a new level: half a second of packets
constexpr int kSettling = 100;         // packets until the level is what it was at first
constexpr double kMostPace = 0.005;    // by which the pitch is bent, less than anybody hears

}  // namespace

LiveSound::LiveSound(SoundOutput& output) : output_(output) { output_.set_prebuffer(kPrebuffer); }

void LiveSound::add(decoder::SoundDecoder::Block block, double now) {
    const double rate = block.sound.sample_rate, media = double(block.first_sample) / rate, gap = end_ ? double(block.first_sample - *end_) / rate : 0;
    const auto heard = output_.heard();
    const double level = heard && end_ ? double(*end_) / rate - *heard : 0;
    if (!end_ || gap < 0 || gap > kLongestGap || now - media < offset_ - kBacklog || (wanted_ && level > *wanted_ + kFarBehind)) begin(media, now - media);
    else if (heard) pace(level);
    offset_ += kDrift * (now - media - offset_);
    end_ = block.first_sample + block.sound.length();
    output_.push(block.first_sample, std::move(block.sound));
}

/// What is here is dropped.
void LiveSound::begin(double media, double offset) {
    output_.flush(media);
    output_.play();
    offset_ = offset;
    level_.reset();
    wanted_.reset();
    settled_ = 0;
    if (rate_ != 1) output_.set_rate(rate_ = 1);
}

void LiveSound::pace(double level) {
    level_ = level_ ? *level_ + kSmoothing * (level - *level_) : level;
    if (!wanted_ && ++settled_ >= kSettling) wanted_ = *level_;
    if (!wanted_) return;
    // A tenth of the difference in a second; steps too small to matter are not taken.
    const double rate = 1 + std::clamp(0.1 * (*level_ - *wanted_), -kMostPace, kMostPace);
    if (std::abs(rate - rate_) > kMostPace / 10) output_.set_rate(rate_ = rate);
}

}  // namespace mien::player
