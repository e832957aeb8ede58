#include "coding/motion_frames.hpp"

namespace mien::coding {

MotionFrames::MotionFrames(const MotionBasis& basis, const MotionShape& shape)
    : basis_(basis), shape_(shape), layout_(shape, basis), start_(layout_.make_model()), model_(start_) {
    const MotionStart& start = basis.start;
    for (const MotionStart::Chance& chance : start.chances) {
        AdaptiveBit& bit = start_.bits()[chance.at];
        bit.p = std::uint16_t(logistic(chance.level * MotionStart::kLevelUnit));
        bit.n = start.confidence;
    }
    for (std::size_t i = 0; i < start.weights.size(); ++i) start_.weight(i) += start.weights[i] * 2048;
    begin_group();
}

void MotionFrames::begin_group() {
    model_ = start_;
    split_ = {};
    last_split_ = 0;
    presence_changes_ = {};
    presence_flips_ = {};
    present_.assign(shape_.presence ? shape_.points : 0, 1);
    past_.assign(std::size_t(layout_.total()), {});
    age_ = 0;
}

void MotionFrames::begin_object(std::uint32_t frames) {
    numbers_.assign(std::size_t(layout_.total()) * frames, 0);
    zeros_.assign(frames, 0);
    splits_.assign(std::size_t(layout_.total()), 0);
    samples_.assign(std::size_t(layout_.total()) * frames, 0);
}

void MotionFrames::store_frame(std::uint32_t frame, std::uint32_t frames) {
    for (int c = 0; c < layout_.total(); ++c)
        samples_[std::size_t(c) * frames + frame] = past_[std::size_t(c)].sample[0];
}

std::int64_t MotionFrames::predict(int channel) const {
    if (age_ == 0) return 0;
    const Past& past = past_[std::size_t(channel)];
    std::int64_t sum = 128;
    for (std::size_t i = 0; i < past.sample.size(); ++i) sum += past.sample[i] * basis_.predictors[std::size_t(channel)][i];
    return sum >> 8;
}

}  // namespace mien::coding
