#include "coding/masked_wavelet.hpp"

#include <algorithm>

namespace mien::coding {
namespace {

// Cohen, Daubechies, Feauveau 9/7 in lifting steps (Daubechies and Sweldens 1998).
constexpr float kSteps[4] = {-1.586134342f, -0.052980118f, 0.882911076f, 0.443506852f};
constexpr float kLow = 1.149604398f, kHigh = 0.869864452f;  // near orthonormal
constexpr float kLone = 1.414213562f;                       // what the low band makes of a constant

constexpr int kSmallest = 8;  // texels: a plane no larger is not split

/// Where a sample at x of a line of n goes.
int split(int x, int n, bool lone) { return lone || x % 2 == 0 ? x / 2 : (n + 1) / 2 + x / 2; }

/// Calls use(begin, end) for every run of set samples.
template <typename Use>
void each_run(const std::uint8_t* set, std::size_t stride, int n, const Use& use) {
    for (int x = 0; x < n;) {
        if (!set[std::size_t(x) * stride]) {
            ++x;
            continue;
        }
        const int begin = x;
        while (x < n && set[std::size_t(x) * stride]) ++x;
        use(begin, x);
    }
}

/// Adds `factor` times both neighbours to the samples of one parity; at an end the one neighbour counts twice.
void lift(float* line, int begin, int end, int parity, float factor) {
    for (int x = begin + ((begin ^ parity) & 1); x < end; x += 2) {
        const float left = line[x > begin ? x - 1 : x + 1], right = line[x + 1 < end ? x + 1 : x - 1];
        line[x] += factor * (left + right);
    }
}

void forward_line(float* line, float* out, const std::uint8_t* set, std::size_t stride, int n) {
    each_run(set, stride, n, [&](int begin, int end) {
        if (end - begin == 1) {
            out[split(begin, n, true)] = kLone * line[begin];
            return;
        }
        for (int k = 0; k < 4; ++k) lift(line, begin, end, 1 - k % 2, kSteps[k]);
        for (int x = begin; x < end; ++x) out[split(x, n, false)] = line[x] * (x % 2 ? kHigh : kLow);
    });
}

void inverse_line(const float* in, float* line, const std::uint8_t* set, std::size_t stride, int n) {
    each_run(set, stride, n, [&](int begin, int end) {
        if (end - begin == 1) {
            line[begin] = in[split(begin, n, true)] / kLone;
            return;
        }
        for (int x = begin; x < end; ++x) line[x] = in[split(x, n, false)] / (x % 2 ? kHigh : kLow);
        for (int k = 4; k-- > 0;) lift(line, begin, end, 1 - k % 2, -kSteps[k]);
    });
}

}  // namespace

MaskedWavelet::MaskedWavelet(const TexelMask& mask) : width_(mask.width), height_(mask.height) {
    for (std::uint32_t i = 0; i < mask.set.size(); ++i)
        if (mask.set[i]) texel_.push_back(i);
    std::vector<std::uint8_t> plane = mask.set;
    const auto pitch = std::size_t(width_);
    for (int w = width_, h = height_; std::max(w, h) > kSmallest; w = (w + 1) / 2, h = (h + 1) / 2) {
        Level level{w, h, {}, {}};
        const auto copy = [&] {
            std::vector<std::uint8_t> part;
            for (int y = 0; y < h; ++y) part.insert(part.end(), plane.begin() + std::ptrdiff_t(std::size_t(y) * pitch), plane.begin() + std::ptrdiff_t(std::size_t(y) * pitch) + w);
            return part;
        };
        level.rows = copy();
        for (int y = 0; y < h; ++y) {
            std::fill_n(plane.begin() + std::ptrdiff_t(std::size_t(y) * pitch), w, std::uint8_t(0));
            each_run(level.rows.data() + std::size_t(y) * std::size_t(w), 1, w, [&](int begin, int end) {
                for (int x = begin; x < end; ++x) plane[std::size_t(y) * pitch + std::size_t(split(x, w, end - begin == 1))] = 1;
            });
        }
        level.columns = copy();
        for (int y = 0; y < h; ++y) std::fill_n(plane.begin() + std::ptrdiff_t(std::size_t(y) * pitch), w, std::uint8_t(0));
        for (int x = 0; x < w; ++x)
            each_run(level.columns.data() + x, std::size_t(w), h, [&](int begin, int end) {
                for (int y = begin; y < end; ++y) plane[std::size_t(split(y, h, end - begin == 1)) * pitch + std::size_t(x)] = 1;
            });
        levels_.push_back(std::move(level));
    }
    number_.assign(plane.size(), kNone);
    const auto add = [&](int level, int orientation) {
        Band band{level, orientation, std::uint32_t(coefficient_.size()), 0};
        const Place p = place(band);
        for (int y = p.y0; y < p.y0 + p.height; ++y)
            for (int x = p.x0; x < p.x0 + p.width; ++x) {
                const std::size_t at = std::size_t(y) * pitch + std::size_t(x);
                if (!plane[at]) continue;
                number_[at] = std::uint32_t(coefficient_.size());
                coefficient_.push_back(std::uint32_t(at));
            }
        band.count = std::uint32_t(coefficient_.size()) - band.first;
        bands_.push_back(band);
    };
    const int last = int(levels_.size()) - 1;
    add(std::max(last, 0), 0);
    for (int level = last; level >= 0; --level)
        for (int orientation = 1; orientation < 4; ++orientation) add(level, orientation);
}

MaskedWavelet::Place MaskedWavelet::place(const Band& band) const {
    if (levels_.empty()) return {0, 0, width_, height_};
    const Level& level = levels_[std::size_t(band.level)];
    const int low_width = (level.width + 1) / 2, low_height = (level.height + 1) / 2;
    const bool right = band.orientation & 1, below = band.orientation & 2;
    return {right ? low_width : 0, below ? low_height : 0, right ? level.width - low_width : low_width, below ? level.height - low_height : low_height};
}

std::uint32_t MaskedWavelet::number(const Place& p, int x, int y) const {
    if (x < 0 || y < 0 || x >= p.width || y >= p.height) return kNone;
    return number_[std::size_t(p.y0 + y) * std::size_t(width_) + std::size_t(p.x0 + x)];
}

std::vector<MaskedWavelet::Around> MaskedWavelet::around(const Band& band) const {
    constexpr int kWays[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    const Place own = place(band);
    const bool has_parent = band.orientation > 0 && band.level + 1 < int(levels_.size());
    const Place above = has_parent ? place({band.level + 1, band.orientation, 0, 0}) : own;
    std::vector<Around> all(band.count);
    for (std::uint32_t i = 0; i < band.count; ++i) {
        const std::uint32_t at = coefficient_[band.first + i];
        const int x = int(at % std::uint32_t(width_)) - own.x0, y = int(at / std::uint32_t(width_)) - own.y0;
        for (int k = 0; k < 8; ++k) all[i].at[k] = number(own, x + kWays[k][0], y + kWays[k][1]);
        all[i].parent = has_parent ? number(above, x / 2, y / 2) : kNone;
    }
    return all;
}

void MaskedWavelet::forward(const float* samples, float* coefficients) const {
    const auto pitch = std::size_t(width_);
    std::vector<float> plane(pitch * std::size_t(height_)), line(std::size_t(std::max(width_, height_))), out(line.size());
    for (std::size_t i = 0; i < texel_.size(); ++i) plane[texel_[i]] = samples[i];
    for (const Level& level : levels_) {
        for (int y = 0; y < level.height; ++y) {
            float* row = plane.data() + std::size_t(y) * pitch;
            std::copy_n(row, level.width, line.data());
            forward_line(line.data(), row, level.rows.data() + std::size_t(y) * std::size_t(level.width), 1, level.width);
        }
        for (int x = 0; x < level.width; ++x) {
            for (int y = 0; y < level.height; ++y) line[std::size_t(y)] = plane[std::size_t(y) * pitch + std::size_t(x)];
            forward_line(line.data(), out.data(), level.columns.data() + x, std::size_t(level.width), level.height);
            for (int y = 0; y < level.height; ++y) plane[std::size_t(y) * pitch + std::size_t(x)] = out[std::size_t(y)];
        }
    }
    for (std::size_t i = 0; i < coefficient_.size(); ++i) coefficients[i] = plane[coefficient_[i]];
}

void MaskedWavelet::inverse(const float* coefficients, float* samples) const {
    const auto pitch = std::size_t(width_);
    std::vector<float> plane(pitch * std::size_t(height_)), line(std::size_t(std::max(width_, height_))), in(line.size());
    for (std::size_t i = 0; i < coefficient_.size(); ++i) plane[coefficient_[i]] = coefficients[i];
    for (std::size_t l = levels_.size(); l-- > 0;) {
        const Level& level = levels_[l];
        for (int x = 0; x < level.width; ++x) {
            for (int y = 0; y < level.height; ++y) in[std::size_t(y)] = plane[std::size_t(y) * pitch + std::size_t(x)];
            inverse_line(in.data(), line.data(), level.columns.data() + x, std::size_t(level.width), level.height);
            for (int y = 0; y < level.height; ++y) plane[std::size_t(y) * pitch + std::size_t(x)] = line[std::size_t(y)];
        }
        for (int y = 0; y < level.height; ++y) {
            float* row = plane.data() + std::size_t(y) * pitch;
            std::copy_n(row, level.width, in.data());
            inverse_line(in.data(), row, level.rows.data() + std::size_t(y) * std::size_t(level.width), 1, level.width);
        }
    }
    for (std::size_t i = 0; i < texel_.size(); ++i) samples[i] = plane[texel_[i]];
}

}  // namespace mien::coding
