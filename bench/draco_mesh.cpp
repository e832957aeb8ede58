#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/motion_bench.hpp"

namespace mien::bench {
namespace {

void fill_mesh(draco::Mesh& mesh, const Clip& clip, std::int64_t frame) {
    const auto points = clip.vertices->frame(frame);
    mesh.set_num_points(std::uint32_t(points.rows()));
    draco::GeometryAttribute position;
    position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    const int id = mesh.AddAttribute(position, true, std::uint32_t(points.rows()));
    for (Eigen::Index p = 0; p < points.rows(); ++p) {
        const Vec3 at = points.row(p).transpose();
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(std::uint32_t(p)), at.data());
    }
    for (const Triangle& t : clip.neutral->triangles)
        mesh.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
}

}  // namespace

DracoTiming bench_draco(const Clip& clip, double rms, int frames) {
    DracoTiming out;
    // A grid of step s has an error of s / 2 in three dimensions (three times s^2 / 12).
    const auto first = clip.vertices->frame(0);
    const float extent = (first.colwise().maxCoeff() - first.colwise().minCoeff()).maxCoeff();
    out.quantisation_bits = std::clamp(int(std::ceil(std::log2(double(extent) / (2 * rms) + 1))), 1, 24);
    for (int i = 0; i < frames; ++i) {
        const std::int64_t frame = clip.vertices->frames * i / frames;
        draco::Encoder encoder;
        encoder.SetSpeedOptions(5, 5);
        encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, out.quantisation_bits);
        draco::Mesh mesh;
        fill_mesh(mesh, clip, frame);
        draco::EncoderBuffer buffer;
        if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return out;
        out.bytes_per_frame += double(buffer.size()) / frames;
        double best = 1e300;
        for (int run = 0; run < 3; ++run) {
            draco::DecoderBuffer coded;
            coded.Init(buffer.data(), buffer.size());
            draco::Decoder decoder;
            const auto begin = std::chrono::steady_clock::now();
            const auto decoded = decoder.DecodeMeshFromBuffer(&coded);
            best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
            if (!decoded.ok()) return out;
        }
        out.seconds_per_frame += best / frames;
    }
    return out;
}

}  // namespace mien::bench
