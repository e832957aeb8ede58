#ifdef MIEN_BENCH_DRACO
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/point_cloud/point_cloud.h>

#include "bench/draco.hpp"
#include "bench/quantised_points.hpp"

namespace mien::bench {
namespace {

class DracoDeltaStream final : public GeometryStream {
public:
    DracoDeltaStream(const QuantisedPoints& points, std::vector<Bytes> packets)
        : step_(points.step), numbers_(std::size_t(points.numbers)), packets_(std::move(packets)) {
        std::uint64_t size = 0;
        for (const Bytes& packet : packets_) size += packet.size();
        parts = {{"packets", size}};
    }
    Result<void> start() override {
        sums_.assign(numbers_, 0);
        return {};
    }
    Result<void> decode(std::int64_t frame, std::span<float> out) override {
        const Bytes& packet = packets_[std::size_t(frame)];
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(packet.data()), packet.size());
        draco::Decoder decoder;
        auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
        if (!decoded.ok())
            return Error{ErrorCode::damaged, "Draco does not decode what it wrote: " + decoded.status().error_msg_string()};
        const draco::PointAttribute* deltas = decoded.value()->attribute(0);
        if (deltas->size() * 3 != numbers_ || deltas->data_type() != draco::DT_INT32)
            return Error{ErrorCode::mismatch, "Draco gives another number of points back"};
        add_rows(sums_, reinterpret_cast<const std::int32_t*>(deltas->GetAddress(draco::AttributeValueIndex(0))), false, step_,
                 out.data());
        return {};
    }

private:
    float step_;
    std::size_t numbers_;
    std::vector<Bytes> packets_;
    std::vector<std::int32_t> sums_;
};

class DracoDeltaCodec final : public GeometryCodec {
public:
    DracoDeltaCodec() {
        name = "draco-cloud-delta";
        what = "Draco's point cloud codec, order kept, level 10, on quantised changes from frame to frame";
        library = draco_library();
    }
    std::string refuses(const GeometryInput& input) const override {
        return input.dimension == 3 ? "" : "codes points, and weights are none";
    }
    Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double rms) const override {
        const QuantisedPoints points(input, rms);
        std::vector<Bytes> packets;
        for (std::int64_t f = 0; f < points.frames; ++f) {
            draco::PointCloud cloud;
            cloud.set_num_points(std::uint32_t(input.points));
            draco::GeometryAttribute attribute;
            attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_INT32, false, 12, 0);
            const int id = cloud.AddAttribute(attribute, true, cloud.num_points());
            for (std::int64_t p = 0; p < input.points; ++p) {
                const std::int32_t delta[3] = {points.delta(f, 3 * p), points.delta(f, 3 * p + 1), points.delta(f, 3 * p + 2)};
                cloud.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(std::uint32_t(p)), delta);
            }
            draco::Encoder encoder;
            encoder.SetSpeedOptions(0, 0);
            encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
            draco::EncoderBuffer buffer;
            const draco::Status status = encoder.EncodePointCloudToBuffer(cloud, &buffer);
            if (!status.ok()) return Error{ErrorCode::unavailable, "Draco could not encode: " + status.error_msg_string()};
            const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
            packets.emplace_back(bytes, bytes + buffer.size());
        }
        return std::unique_ptr<GeometryStream>(std::make_unique<DracoDeltaStream>(points, std::move(packets)));
    }
};

}  // namespace

std::unique_ptr<GeometryCodec> draco_delta_codec() {
    return std::make_unique<DracoDeltaCodec>();
}

}  // namespace mien::bench
#endif
