#include "coding/texel_mask.hpp"

#include <array>
#include <cassert>

#include "coding/integer_model.hpp"

namespace mien::coding {
namespace {

constexpr int kLimit = 255;
constexpr std::uint64_t kTexelsPerByte = 1 << 14;  // chances stay above 32 / 65536, so no texel costs less than 1 / 1400 bit

template <class Coder>
void code_texels(Coder& coder, TexelMask& mask) {
    std::array<AdaptiveBit, 1024> bits{};
    const auto at = [&](int x, int y) { return x >= 0 && y >= 0 && x < mask.width ? int(mask.set[std::size_t(y) * std::size_t(mask.width) + std::size_t(x)]) : 0; };
    for (int y = 0; y < mask.height && !coder.failed(); ++y)
        for (int x = 0; x < mask.width; ++x) {
            int context = 0;
            for (int dx = -1; dx <= 1; ++dx) context = context << 1 | at(x + dx, y - 2);
            for (int dx = -2; dx <= 2; ++dx) context = context << 1 | at(x + dx, y - 1);
            for (int dx = -2; dx < 0; ++dx) context = context << 1 | at(x + dx, y);
            std::uint8_t& texel = mask.set[std::size_t(y) * std::size_t(mask.width) + std::size_t(x)];
            int bit = texel;
            bits[std::size_t(context)].code(coder, bit, kLimit);
            texel = std::uint8_t(bit);
        }
}

}  // namespace

Bytes encode_mask(const TexelMask& mask) {
    assert(mask.width > 0 && mask.height > 0 && mask.width <= kMaxMaskSide && mask.height <= kMaxMaskSide);
    ByteWriter out;
    out.varint(std::uint64_t(mask.width));
    out.varint(std::uint64_t(mask.height));
    RangeEncoder coder;
    TexelMask copy = mask;
    code_texels(coder, copy);
    out.bytes(coder.finish());
    return out.take();
}

Result<TexelMask> decode_mask(ByteView bytes) {
    ByteReader in(bytes);
    const std::uint64_t width = in.varint(), height = in.varint();
    if (!in.ok() || width == 0 || height == 0) return Error{ErrorCode::damaged, "the texel mask blob does not decode"};
    if (width > kMaxMaskSide || height > kMaxMaskSide)
        return Error{ErrorCode::limit_exceeded, "the texel mask blob announces a map larger than 4096 x 4096"};
    if (width * height > kTexelsPerByte * (bytes.size() + 64)) return Error{ErrorCode::limit_exceeded, "the texel mask blob announces more texels than it can hold"};
    TexelMask mask{int(width), int(height), std::vector<std::uint8_t>(width * height)};
    RangeDecoder coder(in.bytes(in.remaining()));
    code_texels(coder, mask);
    if (!coder.complete()) return Error{ErrorCode::damaged, "the texel mask blob does not decode"};
    return mask;
}

}  // namespace mien::coding
