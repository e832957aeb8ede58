#include "encoder/texture_fill.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "core/texel_map.hpp"

namespace mien::encoder {
namespace {

/// The two cells of the next coarser level that cell `x` lies between; the nearer one weighs 3, the other 1.
struct Between {
    int near, far;
};
Between between(int x, int coarse_size) {
    const int near = x / 2;
    return {near, std::clamp(x & 1 ? near + 1 : near - 1, 0, coarse_size - 1)};
}

/// Calls body(i) for 0 <= i < count in pieces large enough to be worth a thread.
template <class Body>
void for_each(std::size_t count, const Body& body) {
    constexpr std::size_t kPiece = 1 << 15;
    parallel_for(std::int64_t((count + kPiece - 1) / kPiece), [&](std::int64_t piece) {
        const std::size_t end = std::min(count, std::size_t(piece + 1) * kPiece);
        for (std::size_t i = std::size_t(piece) * kPiece; i < end; ++i) body(i);
    });
}

constexpr int kFraction = 6;  // bits below one grey level inside the pyramid

}  // namespace

std::vector<std::uint8_t> used_texels(const Clip& clip, int width, int height) {
    std::vector<std::uint8_t> used(std::size_t(width) * height, 1);
    if (clip.mask && clip.mask->width > 0 && clip.mask->height > 0) {
        const Image& mask = *clip.mask;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                used[std::size_t(y) * width + x] =
                    *mask.at(int((2LL * x + 1) * mask.width / (2LL * width)),
                             int((2LL * y + 1) * mask.height / (2LL * height))) > 0;
    } else if (clip.neutral && clip.neutral->has_texcoords()) {
        const TexelMap map = make_texel_map(*clip.neutral, width, height);
        for (std::size_t i = 0; i < used.size(); ++i) used[i] = map.texels[i].triangle != TexelMap::kNone;
    }
    return used;
}

TextureFill::TextureFill(int width, int height, const std::vector<std::uint8_t>& used) {
    assert(used.size() == std::size_t(width) * height);
    const auto gaps = std::size_t(std::count(used.begin(), used.end(), 0));
    if (gaps == 0 || gaps == used.size()) return;

    // From fine to coarse: what is covered, and what the gaps ask for.
    std::vector<std::vector<std::uint8_t>> covered{std::vector<std::uint8_t>(used.size())},
        needed{std::vector<std::uint8_t>(used.size())};
    for (std::size_t i = 0; i < used.size(); ++i) covered[0][i] = used[i] != 0, needed[0][i] = used[i] == 0;
    levels_.push_back({width, height, {}, {}, {}});
    for (std::size_t l = 0;; ++l) {
        Level& level = levels_[l];
        for (std::uint32_t i = 0; i < needed[l].size(); ++i)
            if (needed[l][i] && !covered[l][i]) level.pushes.push_back(i);
        if (level.pushes.empty()) break;
        const int w = level.width, h = level.height, cw = (w + 1) / 2, ch = (h + 1) / 2;
        covered.emplace_back(std::size_t(cw) * ch);
        needed.emplace_back(std::size_t(cw) * ch);
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x)
                covered[l + 1][std::size_t(y / 2) * cw + x / 2] |= covered[l][std::size_t(y) * w + x];
        for (const std::uint32_t i : level.pushes) {
            const Between x = between(int(i) % w, cw), y = between(int(i) / w, ch);
            for (const int cy : {y.near, y.far})
                for (const int cx : {x.near, x.far}) needed[l + 1][std::size_t(cy) * cw + cx] = 1;
        }
        levels_.push_back({cw, ch, {}, {}, std::vector<std::uint16_t>(std::size_t(cw) * ch * 3)});
    }
    // From coarse to fine: the means that the needed covered cells are made of.
    for (std::size_t l = levels_.size() - 1; l >= 1; --l) {
        Level& level = levels_[l];
        const int fw = levels_[l - 1].width, fh = levels_[l - 1].height;
        for (std::uint32_t i = 0; i < needed[l].size(); ++i) {
            if (!needed[l][i] || !covered[l][i]) continue;
            Pull pull{i, {}, 0};
            const int x0 = int(i) % level.width * 2, y0 = int(i) / level.width * 2;
            for (int y = y0; y < std::min(y0 + 2, fh); ++y)
                for (int x = x0; x < std::min(x0 + 2, fw); ++x) {
                    const auto child = std::uint32_t(y * fw + x);
                    if (!covered[l - 1][child]) continue;
                    needed[l - 1][child] = 1;
                    pull.children[pull.count++] = child;
                }
            level.pulls.push_back(pull);
        }
    }
}

void TextureFill::apply(Image& picture) {
    if (empty()) return;
    assert(picture.width == levels_[0].width && picture.height == levels_[0].height && picture.channels == 3);
    std::uint8_t* pixels = picture.pixels.data();

    for (std::size_t l = 1; l < levels_.size(); ++l) {
        Level& level = levels_[l];
        const std::uint16_t* fine = levels_[l - 1].rgb.data();
        for_each(level.pulls.size(), [&](std::size_t n) {
            const Pull& pull = level.pulls[n];
            for (int c = 0; c < 3; ++c) {
                std::uint32_t sum = 0;
                for (std::uint32_t k = 0; k < pull.count; ++k) {
                    const std::size_t at = std::size_t(pull.children[k]) * 3 + c;
                    sum += l == 1 ? std::uint32_t(pixels[at]) << kFraction : fine[at];
                }
                level.rgb[std::size_t(pull.cell) * 3 + c] =
                    std::uint16_t((sum + pull.count / 2) / pull.count);
            }
        });
    }
    for (std::size_t l = levels_.size() - 1; l-- > 0;) {
        Level& level = levels_[l];
        const Level& coarse = levels_[l + 1];
        for_each(level.pushes.size(), [&](std::size_t n) {
            const std::uint32_t i = level.pushes[n];
            const Between x = between(int(i) % level.width, coarse.width),
                          y = between(int(i) / level.width, coarse.height);
            const std::uint16_t* near_row = coarse.rgb.data() + std::size_t(y.near) * coarse.width * 3;
            const std::uint16_t* far_row = coarse.rgb.data() + std::size_t(y.far) * coarse.width * 3;
            for (int c = 0; c < 3; ++c) {
                const std::uint32_t sum = 9u * near_row[x.near * 3 + c] +
                                          3u * (near_row[x.far * 3 + c] + far_row[x.near * 3 + c]) +
                                          far_row[x.far * 3 + c];
                const std::size_t at = std::size_t(i) * 3 + c;
                if (l == 0)
                    pixels[at] = std::uint8_t((sum + (8u << kFraction)) >> (4 + kFraction));
                else
                    level.rgb[at] = std::uint16_t((sum + 8) >> 4);
            }
        });
    }
}

}  // namespace mien::encoder
