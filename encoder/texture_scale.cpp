#include "encoder/texture_scale.hpp"

#include <algorithm>

#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

/// One output pixel's share of a row or column of `from` pixels that becomes `to`: first <= i < end, in units of 1 / to.
struct Span {
    int first, end, from, to, place;
    Span(int at, int from_size, int to_size)
        : first(int(std::int64_t(at) * from_size / to_size)),
          end(int((std::int64_t(at + 1) * from_size + to_size - 1) / to_size)), from(from_size), to(to_size), place(at) {}
    std::uint64_t share(int i) const {
        const std::int64_t low = std::max(std::int64_t(i) * to, std::int64_t(place) * from);
        const std::int64_t high = std::min(std::int64_t(i + 1) * to, std::int64_t(place + 1) * from);
        return std::uint64_t(high - low);
    }
};

}  // namespace

Image scaled_down(const Image& picture, int width, int height) {
    assert(width >= 1 && height >= 1 && width <= picture.width && height <= picture.height);
    Image small(width, height, picture.channels);
    parallel_for(height, [&](std::int64_t y) {
        const Span rows(int(y), picture.height, height);
        for (int x = 0; x < width; ++x) {
            const Span columns(x, picture.width, width);
            for (int c = 0; c < picture.channels; ++c) {
                std::uint64_t sum = 0;
                for (int v = rows.first; v < rows.end; ++v)
                    for (int u = columns.first; u < columns.end; ++u)
                        sum += picture.at(u, v)[c] * rows.share(v) * columns.share(u);
                const std::uint64_t whole = std::uint64_t(picture.width) * std::uint64_t(picture.height);
                small.at(x, int(y))[c] = std::uint8_t((sum + whole / 2) / whole);
            }
        }
    });
    return small;
}

}  // namespace mien::encoder
