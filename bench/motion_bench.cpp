#include "bench/motion_bench.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "decoder/motion_decoder.hpp"
#include "encoder/reference_points.hpp"

namespace mien::bench {
namespace {

using protocol::MotionKind;

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Order-0 entropy of a run of integers, bits altogether.
double entropy(const std::vector<long>& values) {
    std::map<long, double> counts;
    for (long v : values) counts[v] += 1;
    double bits = 0;
    for (const auto& [value, count] : counts) bits -= count * std::log2(count / double(values.size()));
    return bits;
}

}  // namespace

Result<MotionRow> bench_motion(const Clip& clip, const encoder::MotionOptions& options, const std::string& name) {
    const auto start = std::chrono::steady_clock::now();
    MIEN_TRY(encoded, encoder::encode_motion(clip, options));
    MotionRow row;
    row.codec = name;
    row.encode_seconds = seconds_since(start);
    const std::span<const Triangle> triangles =
        clip.neutral && options.kind == MotionKind::vertices ? std::span<const Triangle>(clip.neutral->triangles)
                                                             : std::span<const Triangle>();
    const Points reference = encoder::reference_points(clip, options.kind);

    std::vector<model::Motion> motions;
    Eigen::VectorXf x;
    double bytes = double(encoded.basis.size());
    row.decode_seconds = 1e300;
    for (int run = 0; run < 3; ++run) {
        MIEN_TRY(decoder, decoder::MotionDecoder::create(encoded.info, encoded.basis, triangles));
        motions.clear();
        const auto begin = std::chrono::steady_clock::now();
        for (const auto& group : encoded.groups) {
            decoder.begin_group();
            std::int64_t frame = group.first_time;
            for (const auto& object : group.objects) {
                MIEN_TRY(decoded, decoder.decode(object, frame));
                frame += object.frames;
                for (auto& motion : decoded) {
                    x.noalias() = decoder.basis().components * motion.coefficients;
                    x += decoder.basis().mean;
                    if (options.kind != MotionKind::weights) {
                        PointsMap points(x.data(), reference.rows(), 3);
                        points += reference;
                        if (encoded.info.has_pose) apply_pose(motion.pose, points);
                    }
                    motions.push_back(std::move(motion));
                }
            }
        }
        row.decode_seconds = std::min(row.decode_seconds, seconds_since(begin));
        row.components = std::uint32_t(decoder.basis().size());
        if (run > 0) continue;
        double sum = 0, count = 0;
        for (const auto& motion : motions) {
            x = decoder.basis().mean + decoder.basis().components * motion.coefficients;
            if (options.kind == MotionKind::weights) {
                const Eigen::Map<const Eigen::VectorXf> truth(clip.weights->frame(motion.frame), clip.weights->count);
                sum += (x - truth).cast<double>().squaredNorm();
                row.peak = std::max(row.peak, double((x - truth).cwiseAbs().maxCoeff()));
                count += double(truth.size());
                continue;
            }
            PointsMap points(x.data(), reference.rows(), 3);
            points += reference;
            if (encoded.info.has_pose) apply_pose(motion.pose, points);
            const auto truth = options.kind == MotionKind::vertices ? clip.vertices->frame(motion.frame)
                                                                     : clip.markers->frame(motion.frame);
            for (Eigen::Index p = 0; p < points.rows(); ++p) {
                const double error = (points.row(p) - truth.row(p)).cast<double>().squaredNorm();
                if (std::isnan(error)) continue;
                sum += error;
                count += 1;
                row.peak = std::max(row.peak, std::sqrt(error));
            }
        }
        row.rms = std::sqrt(sum / count);
        if (options.preset == encoder::MotionPreset::guenter98) {
            // What the paper prints: entropies after order-1 prediction of the first 45 components, and of every basis vector.
            double bits = 0;
            for (Eigen::Index c = 0; c < decoder.basis().size(); ++c) {
                std::vector<long> numbers;
                for (std::size_t f = 0; f < motions.size(); ++f) {
                    const bool first = c >= 45 || f == 0;
                    numbers.push_back(std::lround((motions[f].coefficients[c] - (first ? 0 : motions[f - 1].coefficients[c])) / 16));
                }
                bits += entropy(numbers);
                const Eigen::VectorXf column = decoder.basis().components.col(c);
                float unit = 1e30f;
                for (float v : column)
                    if (v != 0) unit = std::min(unit, std::abs(v));
                numbers.clear();
                for (float v : column) numbers.push_back(std::lround(v / unit));
                bits += entropy(numbers);
            }
            row.entropy_kbps = bits;
        }
    }
    for (const auto& group : encoded.groups)
        for (const auto& object : group.objects) bytes += double(object.bytes.size());
    const double to_kbps = clip.frame_rate.value() / double(motions.size()) / 1000;
    row.basis = encoded.bits.basis * to_kbps;
    row.probabilities = encoded.bits.probabilities * to_kbps;
    row.coefficients = encoded.bits.coefficients * to_kbps;
    row.pose = encoded.bits.pose * to_kbps;
    row.kbps = bytes * 8 * to_kbps;
    row.entropy_kbps *= to_kbps;
    return row;
}

}  // namespace mien::bench
