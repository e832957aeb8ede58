#ifdef MIEN_BENCH_DRACO
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "bench/draco.hpp"

// A mesh a frame. Draco sorts vertices as it walks the triangles; the triangles are the same in every frame, so the new order
// is too, and it is learnt once from a mesh whose positions spell each vertex's number.
namespace mien::bench {
namespace {

/// Positions on a grid of one step over the whole clip: the smallest cube of 2^bits - 1 steps around everything.
struct Grid {
    std::array<float, 3> origin{};
    float range = 1;
    int bits = 1;
};

Grid grid_of(const GeometryInput& input, double step) {
    Grid grid;
    const ConstPointsMap all(input.held.data(), input.frames * input.points, 3);
    const Vec3 low = all.colwise().minCoeff(), high = all.colwise().maxCoeff();
    grid.bits = std::clamp(int(std::ceil(std::log2(double((high - low).maxCoeff()) / step + 1))), 1, 30);
    grid.range = float(step * (std::exp2(grid.bits) - 1));
    for (int c = 0; c < 3; ++c) grid.origin[std::size_t(c)] = low[c];
    return grid;
}

void fill(draco::Mesh& mesh, const float* positions, std::int64_t points, std::span<const Triangle> triangles) {
    mesh.set_num_points(std::uint32_t(points));
    for (const Triangle& t : triangles) mesh.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
    draco::GeometryAttribute attribute;
    attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    const int id = mesh.AddAttribute(attribute, true, mesh.num_points());
    for (std::uint32_t p = 0; p < mesh.num_points(); ++p)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(p), positions + std::size_t(p) * 3);
}

Result<Bytes> encode_mesh(const draco::Mesh& mesh, const Grid& grid, int speed, int method = draco::MESH_EDGEBREAKER_ENCODING) {
    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(method);
    encoder.SetAttributeExplicitQuantization(draco::GeometryAttribute::POSITION, grid.bits, 3, grid.origin.data(), grid.range);
    draco::EncoderBuffer buffer;
    const draco::Status status = encoder.EncodeMeshToBuffer(mesh, &buffer);
    if (!status.ok()) return Error{ErrorCode::unavailable, "Draco could not encode: " + status.error_msg_string()};
    const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
    return Bytes(bytes, bytes + buffer.size());
}

Result<std::unique_ptr<draco::Mesh>> decode_mesh(const Bytes& bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok())
        return Error{ErrorCode::damaged, "Draco does not decode what it wrote: " + decoded.status().error_msg_string()};
    return std::move(decoded).value();
}

/// For every point as decoded, its vertex.
Result<std::vector<std::uint32_t>> decoded_order(const GeometryInput& input, int speed) {
    constexpr int kDigitBits = 12;
    constexpr std::uint32_t kDigits = 1u << kDigitBits;
    std::vector<float> numbers(std::size_t(input.points) * 3);
    for (std::uint32_t v = 0; v < std::uint32_t(input.points); ++v) {
        numbers[3 * std::size_t(v)] = float(v % kDigits);
        numbers[3 * std::size_t(v) + 1] = float(v / kDigits);
    }
    draco::Mesh mesh;
    fill(mesh, numbers.data(), input.points, input.triangles);
    const Grid grid{{}, float(kDigits - 1), kDigitBits};
    MIEN_TRY(bytes, encode_mesh(mesh, grid, speed));
    MIEN_TRY(decoded, decode_mesh(bytes));
    const draco::PointAttribute* stored = decoded->GetNamedAttribute(draco::GeometryAttribute::POSITION);
    std::vector<std::uint32_t> order(decoded->num_points());
    std::vector<std::uint8_t> seen(std::size_t(input.points));
    for (std::uint32_t p = 0; p < order.size(); ++p) {
        float digits[3];
        stored->GetMappedValue(draco::PointIndex(p), digits);
        order[p] = std::uint32_t(std::lround(digits[0])) + kDigits * std::uint32_t(std::lround(digits[1]));
        if (order[p] >= seen.size()) return Error{ErrorCode::damaged, "Draco gives vertex numbers back changed"};
        seen[order[p]] = 1;
    }
    if (const auto lost = std::count(seen.begin(), seen.end(), 0))
        return Error{ErrorCode::mismatch, "Draco drops " + std::to_string(lost) + " vertices that are in no triangle"};
    return order;
}

class DracoMeshStream final : public GeometryStream {
public:
    DracoMeshStream(std::vector<std::uint32_t> order, std::vector<Bytes> packets)
        : order_(std::move(order)), packets_(std::move(packets)) {
        std::uint64_t size = 0;
        for (const Bytes& packet : packets_) size += packet.size();
        parts = {{"meshes", size}};
    }
    Result<void> start() override { return {}; }
    Result<void> decode(std::int64_t frame, std::span<float> out) override {
        MIEN_TRY(mesh, decode_mesh(packets_[std::size_t(frame)]));
        if (mesh->num_points() != order_.size())
            return Error{ErrorCode::mismatch, "Draco splits vertices otherwise in other frames"};
        const draco::PointAttribute* position = mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
        for (std::uint32_t p = 0; p < order_.size(); ++p)
            position->GetMappedValue(draco::PointIndex(p), out.data() + std::size_t(order_[p]) * 3);
        return {};
    }

private:
    std::vector<std::uint32_t> order_;
    std::vector<Bytes> packets_;
};

class DracoMeshCodec final : public GeometryCodec {
public:
    explicit DracoMeshCodec(bool best) : speed_(best ? 0 : 3) {
        name = best ? "draco-mesh-best" : "draco-mesh-default";
        what = std::string("Draco's mesh codec, a mesh a frame with its triangles, compression level ") +
               (best ? "10" : "7, its tools' default");
        library = draco_library();
    }
    std::string refuses(const GeometryInput& input) const override {
        return input.triangles.empty() ? "codes meshes, and this motion has none" : "";
    }
    Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double rms) const override {
        const Grid grid = grid_of(input, input.step(rms));
        MIEN_TRY(order, decoded_order(input, speed_));
        std::vector<Bytes> packets;
        for (std::int64_t f = 0; f < input.frames; ++f) {
            draco::Mesh mesh;
            fill(mesh, input.frame(f), input.points, input.triangles);
            MIEN_TRY(bytes, encode_mesh(mesh, grid, speed_));
            packets.push_back(std::move(bytes));
        }
        return std::unique_ptr<GeometryStream>(std::make_unique<DracoMeshStream>(std::move(order), std::move(packets)));
    }

private:
    int speed_;
};

}  // namespace

std::unique_ptr<GeometryCodec> draco_mesh_codec(bool best) {
    return std::make_unique<DracoMeshCodec>(best);
}

std::uint64_t draco_connectivity_bytes(const Mesh& neutral, bool keep_order) {
    // All vertices in one place: what is left is the triangles and a few bytes of header.
    const std::vector<float> nowhere(std::size_t(neutral.vertex_count()) * 3);
    draco::Mesh mesh;
    fill(mesh, nowhere.data(), neutral.vertex_count(), neutral.triangles);
    const auto bytes =
        encode_mesh(mesh, Grid{}, 0, keep_order ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
    return bytes.ok() ? bytes->size() : 0;
}

}  // namespace mien::bench
#endif
