#include "io/ply.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "io/file.hpp"
#include "io/index_ranges.hpp"
#include "io/limits.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

enum class Coding { ascii, little, big };

struct Number {
    char kind = 'f';  // i, u, f
    int size = 4;
};

std::optional<Number> number_named(std::string_view name) {
    for (const auto& [known, number] : std::initializer_list<std::pair<std::string_view, Number>>{
             {"char", {'i', 1}}, {"int8", {'i', 1}}, {"uchar", {'u', 1}}, {"uint8", {'u', 1}}, {"short", {'i', 2}}, {"int16", {'i', 2}},
             {"ushort", {'u', 2}}, {"uint16", {'u', 2}}, {"int", {'i', 4}}, {"int32", {'i', 4}}, {"uint", {'u', 4}}, {"uint32", {'u', 4}},
             {"float", {'f', 4}}, {"float32", {'f', 4}}, {"double", {'f', 8}}, {"float64", {'f', 8}}})
        if (name == known) return number;
    return std::nullopt;
}

struct Property {
    std::string name;
    Number value;
    std::optional<Number> length;  ///< of a list
};
struct Element {
    std::string name;
    std::int64_t count = 0;
    std::vector<Property> properties;
};
struct Header {
    Coding coding = Coding::ascii;
    std::vector<Element> elements;
    std::size_t size = 0;  ///< bytes
};

Result<Header> parse_header(std::string_view text) {
    if (!text.starts_with("ply\n") && !text.starts_with("ply\r")) return Error{ErrorCode::bad_magic, "this is not a PLY file"};
    Header header;
    bool has_format = false;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\n', at);
        if (end == std::string_view::npos) break;
        std::string_view line = trimmed(text.substr(at, end - at));
        at = end + 1;
        const auto word = take_word(line);
        if (word == "end_header") {
            header.size = at;
            if (!has_format) return Error{ErrorCode::damaged, "the PLY header has no format line"};
            return header;
        }
        if (word == "format") {
            const auto name = take_word(line);
            has_format = true;
            if (name == "ascii") header.coding = Coding::ascii;
            else if (name == "binary_little_endian") header.coding = Coding::little;
            else if (name == "binary_big_endian") header.coding = Coding::big;
            else return Error{ErrorCode::unsupported_version, fmt::format("the PLY format \"{}\" is unknown", name.substr(0, 40))};
        } else if (word == "element") {
            Element element;
            element.name = take_word(line);
            const auto count = parse_integer(take_word(line));
            if (!count || *count < 0) return Error{ErrorCode::damaged, "a PLY element has no count"};
            element.count = *count;
            header.elements.push_back(std::move(element));
            if (header.elements.size() > 64) return Error{ErrorCode::limit_exceeded, "the PLY header has too many elements"};
        } else if (word == "property") {
            if (header.elements.empty()) return Error{ErrorCode::damaged, "a PLY property belongs to no element"};
            Property property;
            auto type = take_word(line);
            if (type == "list") {
                property.length = number_named(take_word(line));
                if (!property.length || property.length->kind == 'f') return Error{ErrorCode::damaged, "a PLY list's length has no integer type"};
                type = take_word(line);
            }
            const auto value = number_named(type);
            if (!value) return Error{ErrorCode::damaged, fmt::format("the PLY type \"{}\" is unknown", type.substr(0, 40))};
            property.value = *value;
            property.name = lower_case(take_word(line));
            header.elements.back().properties.push_back(std::move(property));
            if (header.elements.back().properties.size() > 256) return Error{ErrorCode::limit_exceeded, "a PLY element has too many properties"};
        }
    }
    return Error{ErrorCode::truncated, "the PLY header does not end"};
}

/// Values one by one, from text or bytes. After a short or bad read every value is zero and ok() stays false.
class Values {
public:
    Values(ByteView bytes, Coding coding) : bytes_(bytes), coding_(coding) {}

    double next(Number number) {
        if (coding_ == Coding::ascii) return next_text();
        if (!ok_ || bytes_.size() - at_ < std::size_t(number.size)) return ok_ = false, 0;
        std::uint64_t bits = 0;
        for (int i = 0; i < number.size; ++i) {
            const auto byte = std::to_integer<std::uint64_t>(bytes_[at_ + std::size_t(coding_ == Coding::little ? i : number.size - 1 - i)]);
            bits |= byte << 8 * i;
        }
        at_ += std::size_t(number.size);
        if (number.kind == 'f')
            return number.size == 4 ? double(std::bit_cast<float>(std::uint32_t(bits))) : std::bit_cast<double>(bits);
        if (number.kind == 'u') return double(bits);
        const int unused = 64 - 8 * number.size;
        return double(static_cast<std::int64_t>(bits << unused) >> unused);
    }
    bool ok() const { return ok_; }
    std::size_t remaining() const { return bytes_.size() - at_; }

private:
    double next_text() {
        const auto* text = reinterpret_cast<const char*>(bytes_.data());
        const auto blank = [&](std::size_t i) { return text[i] == ' ' || text[i] == '\t' || text[i] == '\n' || text[i] == '\r'; };
        while (at_ < bytes_.size() && blank(at_)) ++at_;
        const std::size_t begin = at_;
        while (at_ < bytes_.size() && !blank(at_)) ++at_;
        const auto value = parse_double({text + begin, at_ - begin});
        if (!ok_ || !value) return ok_ = false, 0;
        return *value;
    }

    ByteView bytes_;
    Coding coding_;
    std::size_t at_ = 0;
    bool ok_ = true;
};

struct Reading {
    std::vector<float> xyz;
    std::vector<Vec2> vertex_uv;
    Mesh mesh;
    bool face_uv = false;
};

Error out_of_values(const Element& element, std::int64_t i) {
    return {ErrorCode::truncated, fmt::format("the PLY file ends or has no number at {} {} of {}", element.name, i, element.count)};
}

Result<void> read_vertices(const Element& element, Values& values, Reading& to) {
    int column[5] = {-1, -1, -1, -1, -1};  // x y z u v
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const std::string& name = element.properties[p].name;
        if (element.properties[p].length) continue;
        if (name == "x" || name == "y" || name == "z") column[name[0] - 'x'] = int(p);
        if (name == "s" || name == "u" || name == "texture_u") column[3] = int(p);
        if (name == "t" || name == "v" || name == "texture_v") column[4] = int(p);
    }
    if (column[0] < 0 || column[1] < 0 || column[2] < 0) return Error{ErrorCode::invalid, "the PLY vertices lack x, y or z"};
    const bool textured = column[3] >= 0 && column[4] >= 0;
    std::vector<double> row(element.properties.size());
    IndexRanges not_finite;
    for (std::int64_t v = 0; v < element.count; ++v) {
        for (std::size_t p = 0; p < row.size(); ++p) {
            const Property& property = element.properties[p];
            if (property.length) {
                const double length = values.next(*property.length);
                for (double i = 0; i < length && values.ok(); ++i) values.next(property.value);
            } else {
                row[p] = values.next(property.value);
            }
        }
        if (!values.ok()) return out_of_values(element, v);
        for (int axis = 0; axis < 3; ++axis) {
            const auto value = static_cast<float>(row[std::size_t(column[axis])]);
            if (!std::isfinite(value)) not_finite.add(v);
            to.xyz.push_back(value);
        }
        if (textured) to.vertex_uv.emplace_back(float(row[std::size_t(column[3])]), float(row[std::size_t(column[4])]));
    }
    if (!not_finite.empty()) return Error{ErrorCode::invalid, not_finite.subject("vertex", "vertices") + " not finite"};
    return {};
}

Result<void> read_faces(const Element& element, Values& values, std::int64_t vertices, Reading& to) {
    std::vector<std::uint32_t> corners;
    std::vector<Vec2> uv;
    for (std::int64_t f = 0; f < element.count; ++f) {
        corners.clear();
        uv.clear();
        for (const Property& property : element.properties) {
            const double length = property.length ? values.next(*property.length) : 1;
            if (property.length && !(length >= 0 && length <= 65536))
                return Error{ErrorCode::limit_exceeded, fmt::format("face {} has {} corners", f, length)};
            const bool indices = property.length && (property.name == "vertex_indices" || property.name == "vertex_index");
            const bool texcoords = property.length && property.name == "texcoord";
            double held = 0;
            for (int i = 0; i < int(length); ++i) {
                const double value = values.next(property.value);
                if (!values.ok()) return out_of_values(element, f);
                if (indices) {
                    if (!(value >= 0 && value < double(vertices)))
                        return Error{ErrorCode::invalid, fmt::format("face {} names vertex {} of {}", f, value, vertices)};
                    corners.push_back(static_cast<std::uint32_t>(value));
                } else if (texcoords) {
                    if (i % 2 == 1) uv.emplace_back(float(held), float(value));
                    held = value;
                }
            }
        }
        if (!values.ok()) return out_of_values(element, f);
        if (corners.size() < 3) return Error{ErrorCode::invalid, fmt::format("face {} has fewer than three corners", f)};
        if (std::int64_t(to.mesh.triangles.size() + corners.size()) > kMaxTriangles)
            return Error{ErrorCode::limit_exceeded, "too many triangles"};
        const bool textured = uv.size() == corners.size();
        to.face_uv = to.face_uv || textured;
        const auto base = static_cast<std::uint32_t>(to.mesh.texcoords.size());
        if (textured) to.mesh.texcoords.insert(to.mesh.texcoords.end(), uv.begin(), uv.end());
        else to.mesh.texcoords.emplace_back(0, 0);
        for (std::uint32_t i = 2; i < corners.size(); ++i) {
            to.mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
            to.mesh.texcoord_triangles.push_back(textured ? Triangle{base, base + i - 1, base + i} : Triangle{base, base, base});
        }
    }
    return {};
}

}  // namespace

Result<Mesh> parse_ply(ByteView bytes) {
    MIEN_TRY(header, parse_header({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
    Values values(bytes.subspan(header.size), header.coding);
    Reading reading;
    bool has_vertices = false;
    for (const Element& element : header.elements) {
        // Every value takes at least a byte, so a count above the bytes left is damage; nothing is allocated for it.
        if (element.count > 0 && (element.properties.empty() || std::uint64_t(element.count) > values.remaining()))
            return Error{ErrorCode::truncated, fmt::format("the PLY file is too short for {} {}", element.count, element.name)};
        if (element.name == "vertex") {
            if (element.count > kMaxVertices) return Error{ErrorCode::limit_exceeded, "too many vertices"};
            if (has_vertices) return Error{ErrorCode::damaged, "the PLY file has two vertex elements"};
            has_vertices = true;
            MIEN_CHECK(read_vertices(element, values, reading));
        } else if (element.name == "face") {
            if (!has_vertices) return Error{ErrorCode::invalid, "the PLY faces come before the vertices"};
            MIEN_CHECK(read_faces(element, values, std::int64_t(reading.xyz.size() / 3), reading));
        } else {
            for (std::int64_t i = 0; i < element.count; ++i) {
                for (const Property& property : element.properties) {
                    const double length = property.length ? values.next(*property.length) : 1;
                    for (double k = 0; k < length && values.ok(); ++k) values.next(property.value);
                }
                if (!values.ok()) return out_of_values(element, i);
            }
        }
    }
    if (!has_vertices) return Error{ErrorCode::invalid, "the PLY file has no vertices"};
    Mesh mesh = std::move(reading.mesh);
    mesh.positions = Eigen::Map<const Points>(reading.xyz.data(), Eigen::Index(reading.xyz.size() / 3), 3);
    if (!reading.face_uv) {
        mesh.texcoords = std::move(reading.vertex_uv);
        mesh.texcoord_triangles = mesh.texcoords.empty() ? std::vector<Triangle>{} : mesh.triangles;
    }
    for (const Vec2& uv : mesh.texcoords)
        if (!uv.allFinite()) return Error{ErrorCode::invalid, "a texture coordinate is not finite"};
    return mesh;
}

Result<Mesh> read_ply(const std::filesystem::path& path) {
    MIEN_TRY(bytes, read_bytes(path));
    auto mesh = parse_ply(bytes);
    if (!mesh) return in_file(path, mesh.error());
    return mesh;
}

}  // namespace mien::io
