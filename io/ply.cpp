#include "io/ply.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "io/fault_list.hpp"
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
    std::size_t size = 0;   ///< bytes
    std::size_t lines = 0;
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
        ++header.lines;
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

/// Values one by one, from text or bytes. After the end every value is zero and ok() stays false. In text every entry of an element has a
/// line of its own, so that what is wrong with one leaves the others alone.
class Values {
public:
    Values(ByteView bytes, const Header& header, FaultList& faults) : bytes_(bytes.subspan(header.size)), coding_(header.coding), faults_(faults), line_(header.lines) {}

    void begin_entry() {
        good_ = ok_;
        if (coding_ != Coding::ascii) return;
        std::size_t begin = line_end_;
        for (words_ = {}; words_.empty() && begin < bytes_.size(); ++line_) {
            const std::string_view rest(reinterpret_cast<const char*>(bytes_.data()) + begin, bytes_.size() - begin);
            const std::size_t length = std::min(rest.find('\n'), rest.size());
            words_ = trimmed(rest.substr(0, length));
            begin = std::min(begin + length + 1, bytes_.size());
        }
        at_ = line_end_ = begin;
        good_ = ok_ = !words_.empty();
    }
    void end_entry() {
        if (good_ && !trimmed(words_).empty()) fault("more numbers than the header tells of");
    }
    double next(Number number) {
        if (coding_ == Coding::ascii) return next_word();
        if (!ok_ || bytes_.size() - at_ < std::size_t(number.size)) return good_ = ok_ = false, 0;
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
    /// Tells of a fault in this entry, whose other values then do not count.
    void fault(std::string what) {
        if (coding_ == Coding::ascii) faults_.add(line_, what);
        else faults_.add(std::move(what));
        good_ = false;
    }
    bool ok() const { return ok_; }
    bool good() const { return good_; }  ///< ok(), and no fault in this entry
    std::size_t remaining() const { return bytes_.size() - at_; }

private:
    double next_word() {
        if (!good_) return 0;
        const std::string_view word = take_word(words_);
        const auto value = parse_double(word);
        if (!value) fault(word.empty() ? "fewer numbers than the header tells of" : fmt::format("\"{}\" is not a number", word.substr(0, 40)));
        return value.value_or(0);
    }

    ByteView bytes_;
    Coding coding_;
    FaultList& faults_;
    std::size_t at_ = 0, line_end_ = 0, line_;
    std::string_view words_;  ///< what is left of the line
    bool ok_ = true, good_ = true;
};

struct Reading {
    std::vector<float> xyz;
    std::vector<Vec2> vertex_uv;
    Mesh mesh;
    IndexRanges not_finite;  ///< vertices
    bool face_uv = false;
};

Error out_of_values(const Element& element, std::int64_t i) {
    return {ErrorCode::truncated, fmt::format("the PLY file ends at {} {} of {}", element.name, i, element.count)};
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
    for (std::int64_t v = 0; v < element.count; ++v) {
        values.begin_entry();
        for (std::size_t p = 0; p < row.size(); ++p) {
            const Property& property = element.properties[p];
            if (property.length) {
                const double length = values.next(*property.length);
                for (double i = 0; i < length && values.good(); ++i) values.next(property.value);
            } else {
                row[p] = values.next(property.value);
            }
        }
        values.end_entry();
        if (!values.ok()) return out_of_values(element, v);
        for (int axis = 0; axis < 3; ++axis) {
            const auto value = static_cast<float>(row[std::size_t(column[axis])]);
            if (!std::isfinite(value)) to.not_finite.add(v);
            to.xyz.push_back(value);
        }
        if (textured) to.vertex_uv.emplace_back(float(row[std::size_t(column[3])]), float(row[std::size_t(column[4])]));
    }
    return {};
}

Result<void> read_faces(const Element& element, Values& values, std::int64_t vertices, Reading& to) {
    std::vector<std::uint32_t> corners;
    std::vector<Vec2> uv;
    for (std::int64_t f = 0; f < element.count; ++f) {
        corners.clear();
        uv.clear();
        values.begin_entry();
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
                    if (values.good() && !(value >= 0 && value < double(vertices))) values.fault(fmt::format("face {} names vertex {} of {}", f, value, vertices));
                    corners.push_back(values.good() ? static_cast<std::uint32_t>(value) : 0);
                } else if (texcoords) {
                    if (i % 2 == 1) uv.emplace_back(float(held), float(value));
                    held = value;
                }
            }
        }
        values.end_entry();
        if (!values.ok()) return out_of_values(element, f);
        if (values.good() && corners.size() < 3) values.fault(fmt::format("face {} has fewer than three corners", f));
        if (!values.good()) continue;
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
    FaultList faults;
    Values values(bytes, header, faults);
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
                values.begin_entry();
                for (const Property& property : element.properties) {
                    const double length = property.length ? values.next(*property.length) : 1;
                    for (double k = 0; k < length && values.good(); ++k) values.next(property.value);
                }
                values.end_entry();
                if (!values.ok()) return out_of_values(element, i);
            }
        }
    }
    if (!has_vertices) return Error{ErrorCode::invalid, "the PLY file has no vertices"};
    if (!reading.not_finite.empty()) return faults.error(reading.not_finite.subject("vertex", "vertices") + " not finite");
    if (!faults.empty()) return faults.error();
    Mesh mesh = std::move(reading.mesh);
    mesh.positions = Eigen::Map<const Points>(reading.xyz.data(), Eigen::Index(reading.xyz.size() / 3), 3);
    if (!reading.face_uv) {
        mesh.texcoords = std::move(reading.vertex_uv);
        mesh.texcoord_triangles = mesh.texcoords.empty() ? std::vector<Triangle>{} : mesh.triangles;
    }
    IndexRanges no_place;
    for (std::size_t i = 0; i < mesh.texcoords.size(); ++i)
        if (!mesh.texcoords[i].allFinite()) no_place.add(std::int64_t(i));
    if (!no_place.empty()) return Error{ErrorCode::invalid, no_place.subject("texture coordinate", "texture coordinates") + " not finite"};
    return mesh;
}

Result<Mesh> read_ply(const std::filesystem::path& path) {
    MIEN_TRY(bytes, read_bytes(path));
    auto mesh = parse_ply(bytes);
    if (!mesh) return in_file(path, mesh.error());
    return mesh;
}

}  // namespace mien::io
