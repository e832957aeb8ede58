#pragma once

#include "coding/motion_values.hpp"
#include "decoder/motion_decoder.hpp"
#include "encoder/motion_encoder.hpp"

namespace mien::motion_test {

/// A coded clip as what other frames may be coded with.
inline encoder::TrainingTake take_of(const encoder::EncodedMotion& motion) {
    encoder::TrainingTake take;
    take.info = motion.info;
    take.basis = *coding::read_motion_basis(take.shape(), motion.basis, {});
    auto decoder = decoder::MotionDecoder::create(motion.info, motion.basis);
    std::vector<Eigen::VectorXd> columns;
    for (const auto& group : motion.groups) {
        decoder->begin_group();
        std::int64_t frame = group.first_time;
        for (const auto& object : group.objects) {
            const auto motions = decoder->decode(object, frame);
            frame += object.frames;
            for (const model::Motion& m : *motions) {
                Eigen::VectorXd& column = columns.emplace_back(take.basis.channels(take.shape()));
                int row = 0;
                if (take.info.has_pose)
                    for (const double v : coding::pose_steps(take.basis, m.pose)) column[row] = v - take.basis.side_mean[std::size_t(row)], ++row;
                column.tail(m.coefficients.size()) = m.coefficients.cast<double>() / 16;
            }
        }
    }
    take.samples.resize(columns.front().size(), Eigen::Index(columns.size()));
    for (std::size_t f = 0; f < columns.size(); ++f) take.samples.col(Eigen::Index(f)) = columns[f];
    return take;
}

}  // namespace mien::motion_test
