#ifdef MIEN_BENCH_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif
#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <optional>

#include "bench/geometry_codec.hpp"
#include "bench/quantised_points.hpp"

namespace mien::bench {

#ifdef MIEN_BENCH_MESHOPTIMIZER
namespace {

constexpr int kZstdLevel = 19;

/// How a frame lies in memory for the vertex codec: points of three int16 and a padding one, or of int32.
struct RowLayout {
    RowLayout(const GeometryInput& input, const QuantisedPoints& points)
        : padded(points.narrow && input.dimension == 3),
          count(std::size_t(input.points)),
          dimension(std::size_t(input.dimension)) {}
    bool padded;
    std::size_t count, dimension;
    std::size_t stride() const { return padded ? 8 : 4 * dimension; }

    template <class Number>
    void write(std::vector<std::byte>& rows, const Number& number) const {
        rows.assign(count * stride(), std::byte{0});
        for (std::size_t p = 0; p < count; ++p)
            for (std::size_t c = 0; c < dimension; ++c) {
                const std::int32_t value = number(std::int64_t(p * dimension + c));
                if (padded) reinterpret_cast<std::int16_t*>(rows.data())[4 * p + c] = std::int16_t(value);
                else reinterpret_cast<std::int32_t*>(rows.data())[dimension * p + c] = value;
            }
    }
};

/// How the numbers are arranged before the vertex codec sees them; what makes the clip smallest is taken.
enum class Numbers { positions, changes, zigzag_changes };

class MeshoptimizerStream final : public GeometryStream {
public:
    MeshoptimizerStream(const GeometryInput& input, const QuantisedPoints& points, Numbers numbers, bool zstd,
                        std::vector<Bytes> packets)
        : layout_(input, points),
          step_(points.step),
          numbers_(numbers),
          packets_(std::move(packets)),
          rows_(layout_.count * layout_.stride()) {
        std::uint64_t size = 0;
        for (const Bytes& packet : packets_) size += packet.size();
        parts = {{"packets", size}};
        if (!zstd) return;
        decoder_.reset(ZSTD_createDCtx());
        unpacked_.resize(meshopt_encodeVertexBufferBound(layout_.count, layout_.stride()));
    }
    Result<void> start() override {
        sums16_.assign(layout_.padded ? 4 * layout_.count : 0, 0);
        sums32_.assign(layout_.padded ? 0 : layout_.dimension * layout_.count, 0);
        return {};
    }
    Result<void> decode(std::int64_t frame, std::span<float> out) override {
        const Bytes& packet = packets_[std::size_t(frame)];
        const auto* bytes = reinterpret_cast<const unsigned char*>(packet.data());
        std::size_t size = packet.size();
        if (decoder_) {
            size = ZSTD_decompressDCtx(decoder_.get(), unpacked_.data(), unpacked_.size(), packet.data(), packet.size());
            if (ZSTD_isError(size)) return Error{ErrorCode::damaged, "zstd does not decode what it wrote"};
            bytes = unpacked_.data();
        }
        if (meshopt_decodeVertexBuffer(rows_.data(), layout_.count, layout_.stride(), bytes, size) != 0)
            return Error{ErrorCode::damaged, "meshoptimizer does not decode what it wrote"};
        if (layout_.padded) {
            const auto* rows = reinterpret_cast<const std::int16_t*>(rows_.data());
            if (numbers_ == Numbers::positions) scale_rows(std::span(rows, 4 * layout_.count), step_, out.data());
            else add_rows(sums16_, rows, numbers_ == Numbers::zigzag_changes, step_, out.data());
        } else {
            const auto* rows = reinterpret_cast<const std::int32_t*>(rows_.data());
            if (numbers_ == Numbers::positions) scale_rows(std::span(rows, layout_.dimension * layout_.count), step_, out.data());
            else add_rows(sums32_, rows, numbers_ == Numbers::zigzag_changes, step_, out.data());
        }
        return {};
    }

private:
    struct FreeDecoder {
        void operator()(ZSTD_DCtx* decoder) const { ZSTD_freeDCtx(decoder); }
    };
    RowLayout layout_;
    float step_;
    Numbers numbers_;
    std::vector<Bytes> packets_;
    std::vector<std::byte> rows_;
    std::vector<unsigned char> unpacked_;
    std::unique_ptr<ZSTD_DCtx, FreeDecoder> decoder_;
    std::vector<std::int16_t> sums16_;
    std::vector<std::int32_t> sums32_;
};

Bytes encode_vertices(const std::vector<std::byte>& rows, const RowLayout& layout) {
    Bytes bytes(meshopt_encodeVertexBufferBound(layout.count, layout.stride()));
    auto* into = reinterpret_cast<unsigned char*>(bytes.data());
#if MESHOPTIMIZER_VERSION >= 1000
    const std::size_t size =
        meshopt_encodeVertexBufferLevel(into, bytes.size(), rows.data(), layout.count, layout.stride(), 3, -1);
#else
    const std::size_t size = meshopt_encodeVertexBuffer(into, bytes.size(), rows.data(), layout.count, layout.stride());
#endif
    bytes.resize(size);
    return bytes;
}

Result<std::vector<Bytes>> encode_frames(const GeometryInput& input, const QuantisedPoints& points, Numbers numbers, bool zstd) {
    const RowLayout layout(input, points);
    std::vector<Bytes> packets;
    std::vector<std::byte> rows;
    for (std::int64_t f = 0; f < points.frames; ++f) {
        layout.write(rows, [&](std::int64_t i) {
            if (numbers == Numbers::positions) return points.at(f, i);
            const std::int32_t delta = layout.padded ? std::int16_t(points.delta(f, i)) : points.delta(f, i);
            return numbers == Numbers::zigzag_changes ? std::int32_t(zigzag(delta)) : delta;
        });
        Bytes bytes = encode_vertices(rows, layout);
        if (bytes.empty()) return Error{ErrorCode::unavailable, "meshoptimizer could not encode a frame"};
        if (zstd) {
            Bytes packed(ZSTD_compressBound(bytes.size()));
            const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kZstdLevel);
            if (ZSTD_isError(size)) return Error{ErrorCode::unavailable, "zstd could not encode a frame"};
            packed.resize(size);
            bytes = std::move(packed);
        }
        packets.push_back(std::move(bytes));
    }
    return packets;
}

class MeshoptimizerCodec final : public GeometryCodec {
public:
    MeshoptimizerCodec(bool delta, bool zstd) : delta_(delta), zstd_(zstd) {
        name = std::string("meshopt-") + (delta ? "delta" : "intra") + (zstd ? "-zstd" : "");
        what = std::string("meshoptimizer's vertex codec on quantised ") +
               (delta ? "changes from frame to frame" : "positions, every frame alone") + (zstd ? ", then zstd 19" : "");
        library = fmt::format("meshoptimizer {}.{}", MESHOPTIMIZER_VERSION / 1000, MESHOPTIMIZER_VERSION % 1000 / 10);
    }
    Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double rms) const override {
        const QuantisedPoints points(input, rms);
        std::unique_ptr<GeometryStream> best;
        for (const Numbers numbers : {Numbers::positions, Numbers::changes, Numbers::zigzag_changes}) {
            if ((numbers == Numbers::positions) == delta_) continue;
            MIEN_TRY(packets, encode_frames(input, points, numbers, zstd_));
            auto stream = std::make_unique<MeshoptimizerStream>(input, points, numbers, zstd_, std::move(packets));
            if (!best || stream->bytes() < best->bytes()) best = std::move(stream);
        }
        return best;
    }

private:
    bool delta_, zstd_;
};

}  // namespace

void add_meshoptimizer(GeometryCodecs& list) {
    for (const bool delta : {false, true})
        for (const bool zstd : {false, true}) list.codecs.push_back(std::make_unique<MeshoptimizerCodec>(delta, zstd));
}
#else
void add_meshoptimizer(GeometryCodecs& list) {
    for (const char* name : {"meshopt-intra", "meshopt-intra-zstd", "meshopt-delta", "meshopt-delta-zstd"})
        list.absent.emplace_back(name, "meshoptimizer was not there when the bench was configured");
}
#endif

}  // namespace mien::bench
