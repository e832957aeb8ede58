#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "io/frame_times.hpp"
#include "io/limits.hpp"
#include "io/marker_file.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

// C3D file format user guide (Motion Lab Systems): 512-byte blocks; a header block, parameters, then frames.
constexpr std::size_t kBlock = 512;
constexpr std::uint8_t kKey = 0x50;
enum Processor : std::uint8_t { kIntel = 84, kDec = 85, kMips = 86 };

/// Fields at fixed places, in the byte order of the machine that wrote the file. Reads past the end are zero and remembered.
class Fields {
public:
    Fields(ByteView bytes, Processor processor) : bytes_(bytes), processor_(processor) {}

    std::uint8_t u8(std::size_t at) {
        if (at >= bytes_.size()) return ok_ = false, std::uint8_t(0);
        return std::to_integer<std::uint8_t>(bytes_[at]);
    }
    std::uint16_t u16(std::size_t at) {
        const unsigned a = u8(at), b = u8(at + 1);
        return static_cast<std::uint16_t>(processor_ == kMips ? a << 8 | b : b << 8 | a);
    }
    std::int16_t i16(std::size_t at) { return static_cast<std::int16_t>(u16(at)); }
    float f32(std::size_t at) {
        std::uint32_t bits;
        if (processor_ == kDec) {
            // VAX F: the more significant half comes first, and its exponent is two higher than IEEE's.
            bits = std::uint32_t(u16(at)) << 16 | u16(at + 2);
            if ((bits >> 23 & 255) < 2) return 0;
            bits -= 2u << 23;
        } else {
            const std::uint32_t a = u16(at), b = u16(at + 2);
            bits = processor_ == kMips ? a << 16 | b : b << 16 | a;
        }
        float value;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }
    std::string text(std::size_t at, std::size_t size) {
        std::string s;
        for (std::size_t i = 0; i < size; ++i) s += static_cast<char>(u8(at + i));
        return s;
    }
    bool ok() const { return ok_; }
    std::size_t size() const { return bytes_.size(); }

private:
    ByteView bytes_;
    Processor processor_;
    bool ok_ = true;
};

struct Parameter {
    int type = 0;  ///< -1 characters, 1 bytes, 2 integers, 4 floats
    std::vector<std::size_t> sizes;
    std::size_t at = 0;  ///< of the first value
    std::size_t count() const {
        std::size_t n = 1;
        for (const std::size_t size : sizes) n *= size;
        return n;
    }
};

/// Parameters by "GROUP:NAME", upper case as the files have them.
std::map<std::string, Parameter> parse_parameters(Fields& fields, std::size_t begin, std::size_t end) {
    std::map<int, std::string> groups;
    std::map<std::pair<int, std::string>, Parameter> found;
    for (std::size_t at = begin + 4; at + 4 < end;) {
        const int name_size = std::abs(static_cast<std::int8_t>(fields.u8(at)));
        const int group = static_cast<std::int8_t>(fields.u8(at + 1));
        if (name_size == 0 || group == 0) break;
        const std::string name = fields.text(at + 2, std::size_t(name_size));
        const std::size_t link = at + 2 + std::size_t(name_size);
        const std::size_t offset = fields.u16(link);
        if (group < 0) {
            groups[-group] = name;
        } else {
            Parameter parameter;
            parameter.type = static_cast<std::int8_t>(fields.u8(link + 2));
            const int dimensions = std::min<int>(fields.u8(link + 3), 7);
            for (int d = 0; d < dimensions; ++d) parameter.sizes.push_back(fields.u8(link + 4 + std::size_t(d)));
            parameter.at = link + 4 + std::size_t(dimensions);
            const std::size_t bytes = std::size_t(std::abs(parameter.type));
            // At most 65535 bytes fit between two links; more is damage.
            if (parameter.count() <= 65535 && parameter.at + parameter.count() * bytes <= end) found[{group, name}] = parameter;
        }
        if (offset == 0 || !fields.ok()) break;
        at = link + offset;
    }
    std::map<std::string, Parameter> named;
    for (const auto& [key, parameter] : found) named[groups[key.first] + ":" + key.second] = parameter;
    return named;
}

std::vector<std::string> texts_of(Fields& fields, const Parameter& parameter) {
    std::vector<std::string> texts;
    if (parameter.type != -1 || parameter.sizes.empty() || parameter.sizes[0] == 0) return texts;
    const std::size_t length = parameter.sizes[0];
    for (std::size_t i = 0; i < parameter.count() / length; ++i)
        texts.emplace_back(trimmed(fields.text(parameter.at + i * length, length)));
    return texts;
}

}  // namespace

Result<MarkerTake> parse_c3d(ByteView bytes) {
    if (bytes.size() < 2 || std::to_integer<std::uint8_t>(bytes[1]) != kKey || std::to_integer<std::uint8_t>(bytes[0]) == 0)
        return Error{ErrorCode::bad_magic, "this is not a C3D file"};
    const std::size_t parameters_at = (std::to_integer<std::size_t>(bytes[0]) - 1) * kBlock;
    if (bytes.size() < kBlock || parameters_at + 4 > bytes.size()) return Error{ErrorCode::truncated, "the C3D file ends inside its header"};
    const auto processor = static_cast<Processor>(std::to_integer<std::uint8_t>(bytes[parameters_at + 3]));
    if (processor != kIntel && processor != kDec && processor != kMips)
        return Error{ErrorCode::unsupported_version, fmt::format("the C3D file was written by an unknown processor ({})", int(processor))};

    Fields fields(bytes, processor);
    const std::size_t points = fields.u16(2), analog = fields.u16(4);
    const std::int64_t first = fields.u16(6), last = fields.u16(8);
    const float scale = fields.f32(12);
    std::size_t data_block = fields.u16(16);
    double rate = fields.f32(20);

    const std::size_t parameters_end = std::min(bytes.size(), parameters_at + fields.u8(parameters_at + 2) * kBlock);
    const auto parameters = parse_parameters(fields, parameters_at, parameters_end);
    const auto find = [&](const char* name) {
        const auto at = parameters.find(name);
        return at == parameters.end() ? nullptr : &at->second;
    };
    MarkerTake take;
    if (const auto* p = find("POINT:RATE"); p && p->type == 4) rate = fields.f32(p->at);
    if (const auto* p = find("POINT:DATA_START"); p && p->type == 2 && fields.u16(p->at) > 0) data_block = fields.u16(p->at);
    if (const auto* p = find("POINT:UNITS"))
        for (const auto& text : texts_of(fields, *p))
            for (const Unit unit : {Unit::mm, Unit::cm, Unit::m})
                if (lower_case(text) == name_of(unit)) take.unit = unit;
    for (int more = 1; more < 32 && take.names.size() < points; ++more) {
        const auto* p = find(more == 1 ? "POINT:LABELS" : fmt::format("POINT:LABELS{}", more).c_str());
        if (!p) break;
        for (auto& name : texts_of(fields, *p)) take.names.push_back(std::move(name));
    }
    if (take.names.size() < points) take.names.clear();
    take.names.resize(std::min(take.names.size(), points));
    take.frame_rate = usual_rate(rate);

    if (points == 0) return Error{ErrorCode::invalid, "the C3D file has no points (analog data only)"};
    if (data_block == 0) return Error{ErrorCode::damaged, "the C3D header does not say where the frames begin"};
    if (!std::isfinite(scale) || scale == 0) return Error{ErrorCode::damaged, "the C3D header's scale factor makes no sense"};
    const bool floats = scale < 0;
    const std::size_t frame_size = (points * 4 + analog) * (floats ? 4 : 2);
    const std::size_t begin = (data_block - 1) * kBlock;
    const std::int64_t there = begin < bytes.size() ? std::int64_t((bytes.size() - begin) / frame_size) : 0;
    // The header counts frames in 16 bits; longer takes say so in their parameters, and the file's size has the last word.
    std::int64_t frames = last - first + 1;
    if (const auto* p = find("POINT:FRAMES"); p && p->type == 2 && fields.u16(p->at) > frames) frames = fields.u16(p->at);
    if (const auto* p = find("POINT:LONG_FRAMES"); p && p->type == 4 && fields.f32(p->at) > float(frames)) {
        const float stated = fields.f32(p->at);
        if (stated < float(kMaxFrames)) frames = std::int64_t(stated);
    }
    const auto* start = find("TRIAL:ACTUAL_START_FIELD");
    const auto* end = find("TRIAL:ACTUAL_END_FIELD");
    if (start && end && start->type == 2 && end->type == 2 && start->count() >= 2 && end->count() >= 2) {
        const std::int64_t from = fields.u16(start->at) + 65536ll * fields.u16(start->at + 2);
        const std::int64_t to = fields.u16(end->at) + 65536ll * fields.u16(end->at + 2);
        if (to - from + 1 > frames) frames = to - from + 1;
    }
    if (frames < 1) return Error{ErrorCode::invalid, "the C3D file has no frames"};
    if (there < frames)
        return Error{ErrorCode::truncated, fmt::format("the C3D file ends after frame {} of {}", there, frames)};

    take.points = PointSequence(frames, std::int64_t(points));
    for (std::int64_t f = 0; f < frames; ++f)
        for (std::size_t p = 0; p < points; ++p) {
            const std::size_t at = begin + std::size_t(f) * frame_size + p * (floats ? 16 : 8);
            float* to = take.points.xyz.data() + (std::size_t(f) * points + p) * 3;
            const float residual = floats ? fields.f32(at + 12) : float(fields.i16(at + 6));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const float value = floats ? fields.f32(at + 4 * axis) : float(fields.i16(at + 2 * axis)) * scale;
                to[axis] = residual < 0 ? std::numeric_limits<float>::quiet_NaN() : value;
            }
        }
    if (!fields.ok()) return Error{ErrorCode::truncated, "the C3D file's parameters point past its end"};
    settle_missing(take);
    return take;
}

}  // namespace mien::io
