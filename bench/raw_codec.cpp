#include <cstring>

#include "bench/geometry_codec.hpp"

namespace mien::bench {
namespace {

class RawStream final : public GeometryStream {
public:
    explicit RawStream(const GeometryInput& input) : numbers_(std::size_t(input.numbers())), floats_(input.held) {
        parts = {{"floats", floats_.size() * sizeof(float)}};
    }
    Result<void> start() override { return {}; }
    Result<void> decode(std::int64_t frame, std::span<float> out) override {
        std::memcpy(out.data(), floats_.data() + std::size_t(frame) * numbers_, numbers_ * sizeof(float));
        return {};
    }

private:
    std::size_t numbers_;
    std::vector<float> floats_;
};

class RawCodec final : public GeometryCodec {
public:
    RawCodec() {
        name = "raw";
        what = "float32 as it is";
        lossless = true;
    }
    Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double) const override {
        return std::unique_ptr<GeometryStream>(std::make_unique<RawStream>(input));
    }
};

}  // namespace

void add_raw(GeometryCodecs& list) {
    list.codecs.push_back(std::make_unique<RawCodec>());
}

}  // namespace mien::bench
