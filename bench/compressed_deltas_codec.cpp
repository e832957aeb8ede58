#include <zstd.h>
#ifdef MIEN_BENCH_XZ
#include <lzma.h>
#endif

#include <cassert>

#include "bench/geometry_codec.hpp"
#include "bench/quantised_points.hpp"

// General compressors on quantised changes from frame to frame: zigzag numbers as planes of bytes, x of all points before y
// and z, which both compress best.
namespace mien::bench {
namespace {

constexpr int kZstdLevel = 19;

/// Byte planes of one frame: for every byte of a number, x of all points, then y, then z.
class Planes {
public:
    explicit Planes(const GeometryInput& input, const QuantisedPoints& points)
        : points_(input.points), dimension_(input.dimension), width_(points.narrow ? 2 : 4) {}

    std::size_t size() const { return std::size_t(points_) * std::size_t(dimension_) * std::size_t(width_); }
    void write(const QuantisedPoints& points, std::int64_t frame, std::uint8_t* out) const {
        const std::int64_t n = points_ * dimension_;
        for (std::int64_t p = 0; p < points_; ++p)
            for (int c = 0; c < dimension_; ++c) {
                std::uint32_t v = zigzag(points.delta(frame, p * dimension_ + c));
                // Sixteen bits wrap as the decoder's sums do.
                if (width_ == 2) v = std::uint16_t(zigzag(std::int16_t(points.delta(frame, p * dimension_ + c))));
                for (int b = 0; b < width_; ++b) out[b * n + c * points_ + p] = std::uint8_t(v >> 8 * b);
            }
    }

private:
    std::int64_t points_;
    int dimension_, width_;
};

/// Adds up planes and turns x.. y.. z.. into points.
class PlaneSums {
public:
    PlaneSums(const GeometryInput& input, const QuantisedPoints& points)
        : points_(std::size_t(input.points)),
          dimension_(std::size_t(input.dimension)),
          step_(points.step),
          narrow_(points.narrow),
          floats_(points_ * dimension_) {
        restart();
    }
    void restart() {
        narrow_sums_.assign(narrow_ ? floats_.size() : 0, 0);
        wide_sums_.assign(narrow_ ? 0 : floats_.size(), 0);
    }
    void add(const std::uint8_t* planes, std::span<float> out) {
        float* into = dimension_ == 1 ? out.data() : floats_.data();
        narrow_ ? add_planes(narrow_sums_, planes, step_, into) : add_planes(wide_sums_, planes, step_, into);
        if (dimension_ == 1) return;
        for (std::size_t p = 0; p < points_; ++p)
            for (std::size_t c = 0; c < 3; ++c) out[3 * p + c] = floats_[c * points_ + p];
    }

private:
    std::size_t points_, dimension_;
    float step_;
    bool narrow_;
    std::vector<std::int16_t> narrow_sums_;
    std::vector<std::int32_t> wide_sums_;
    std::vector<float> floats_;
};

/// One zstd stream over the clip, flushed after every frame: a packet a frame that leans on all earlier ones.
class ZstdStream final : public GeometryStream {
public:
    ZstdStream(const GeometryInput& input, const QuantisedPoints& points, std::vector<Bytes> packets, std::size_t frame_bytes)
        : sums_(input, points), packets_(std::move(packets)), frame_(frame_bytes), decoder_(ZSTD_createDCtx()) {
        std::uint64_t size = 0;
        for (const Bytes& packet : packets_) size += packet.size();
        parts = {{"packets", size}};
    }
    ~ZstdStream() override { ZSTD_freeDCtx(decoder_); }
    Result<void> start() override {
        ZSTD_DCtx_reset(decoder_, ZSTD_reset_session_only);
        sums_.restart();
        return {};
    }
    Result<void> decode(std::int64_t frame, std::span<float> out) override {
        const Bytes& packet = packets_[std::size_t(frame)];
        ZSTD_inBuffer from{packet.data(), packet.size(), 0};
        ZSTD_outBuffer into{frame_.data(), frame_.size(), 0};
        while (into.pos < into.size) {
            const std::size_t before = from.pos + into.pos;
            const std::size_t code = ZSTD_decompressStream(decoder_, &into, &from);
            if (ZSTD_isError(code) || from.pos + into.pos == before)
                return Error{ErrorCode::damaged, "zstd does not decode what it wrote"};
        }
        sums_.add(frame_.data(), out);
        return {};
    }

private:
    PlaneSums sums_;
    std::vector<Bytes> packets_;
    std::vector<std::uint8_t> frame_;
    ZSTD_DCtx* decoder_;
};

class ZstdCodec final : public GeometryCodec {
public:
    ZstdCodec() {
        name = "zstd-delta";
        what = "zstd 19 on quantised changes, one stream flushed after every frame";
        library = std::string("zstd ") + ZSTD_versionString();
    }
    Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double rms) const override {
        const QuantisedPoints points(input, rms);
        const Planes planes(input, points);
        std::vector<std::uint8_t> frame(planes.size());
        const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> encoder(ZSTD_createCCtx(), &ZSTD_freeCCtx);
        ZSTD_CCtx_setParameter(encoder.get(), ZSTD_c_compressionLevel, kZstdLevel);
        std::vector<Bytes> packets;
        Bytes buffer(ZSTD_compressBound(frame.size()) + 64);
        for (std::int64_t f = 0; f < points.frames; ++f) {
            planes.write(points, f, frame.data());
            ZSTD_inBuffer from{frame.data(), frame.size(), 0};
            ZSTD_outBuffer into{buffer.data(), buffer.size(), 0};
            if (ZSTD_compressStream2(encoder.get(), &into, &from, ZSTD_e_flush) != 0)
                return Error{ErrorCode::unavailable, "zstd could not finish a frame"};
            packets.emplace_back(buffer.begin(), buffer.begin() + std::ptrdiff_t(into.pos));
        }
        return std::unique_ptr<GeometryStream>(std::make_unique<ZstdStream>(input, points, std::move(packets), frame.size()));
    }
};

#ifdef MIEN_BENCH_XZ
/// The whole clip as one xz stream, decoded a frame at a time.
class XzStream final : public GeometryStream {
public:
    XzStream(const GeometryInput& input, const QuantisedPoints& points, Bytes bytes, std::size_t frame_bytes)
        : sums_(input, points), bytes_(std::move(bytes)), frame_(frame_bytes) {
        parts = {{"stream", bytes_.size()}};
    }
    ~XzStream() override { lzma_end(&decoder_); }
    Result<void> start() override {
        lzma_end(&decoder_);
        decoder_ = LZMA_STREAM_INIT;
        if (lzma_stream_decoder(&decoder_, UINT64_MAX, 0) != LZMA_OK)
            return Error{ErrorCode::unavailable, "xz has no memory to decode"};
        decoder_.next_in = reinterpret_cast<const std::uint8_t*>(bytes_.data());
        decoder_.avail_in = bytes_.size();
        sums_.restart();
        return {};
    }
    Result<void> decode(std::int64_t, std::span<float> out) override {
        decoder_.next_out = frame_.data();
        decoder_.avail_out = frame_.size();
        while (decoder_.avail_out > 0) {
            const lzma_ret code = lzma_code(&decoder_, LZMA_RUN);
            if (code != LZMA_OK && !(code == LZMA_STREAM_END && decoder_.avail_out == 0))
                return Error{ErrorCode::damaged, "xz does not decode what it wrote"};
        }
        sums_.add(frame_.data(), out);
        return {};
    }

private:
    PlaneSums sums_;
    Bytes bytes_;
    std::vector<std::uint8_t> frame_;
    lzma_stream decoder_ = LZMA_STREAM_INIT;
};

class XzCodec final : public GeometryCodec {
public:
    XzCodec() {
        name = "xz-delta";
        what = "xz 9e on quantised changes, the whole clip in one stream";
        library = std::string("liblzma ") + lzma_version_string();
        mode = Mode::file;
    }
    Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double rms) const override {
        const QuantisedPoints points(input, rms);
        const Planes planes(input, points);
        std::vector<std::uint8_t> all(planes.size() * std::size_t(points.frames));
        for (std::int64_t f = 0; f < points.frames; ++f) planes.write(points, f, all.data() + std::size_t(f) * planes.size());
        Bytes bytes(lzma_stream_buffer_bound(all.size()));
        std::size_t size = 0;
        if (lzma_easy_buffer_encode(9 | LZMA_PRESET_EXTREME, LZMA_CHECK_NONE, nullptr, all.data(), all.size(),
                                    reinterpret_cast<std::uint8_t*>(bytes.data()), &size, bytes.size()) != LZMA_OK)
            return Error{ErrorCode::unavailable, "xz could not encode"};
        bytes.resize(size);
        return std::unique_ptr<GeometryStream>(std::make_unique<XzStream>(input, points, std::move(bytes), planes.size()));
    }
};
#endif

}  // namespace

void add_compressed_deltas(GeometryCodecs& list) {
    list.codecs.push_back(std::make_unique<ZstdCodec>());
#ifdef MIEN_BENCH_XZ
    list.codecs.push_back(std::make_unique<XzCodec>());
#else
    list.absent.emplace_back("xz-delta", "liblzma was not there when the bench was configured");
#endif
}

}  // namespace mien::bench
