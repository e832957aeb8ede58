#include "io/obj.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iterator>

#include "io/fault_list.hpp"
#include "io/file.hpp"
#include "io/index_ranges.hpp"
#include "io/limits.hpp"
#include "io/surface_names.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

constexpr std::string_view kSurfaceMaterial = "mien_";

/// Walks the characters of one OBJ file. The terminating conditions are all in one place, because this loop is the speed.
class Cursor {
public:
    explicit Cursor(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {
        if (text.starts_with("\xef\xbb\xbf")) at_ += 3;
    }

    bool at_end() const { return at_ == end_; }
    bool at_line_end() const { return at_ == end_ || *at_ == '\n' || *at_ == '\r'; }
    std::size_t line() const { return line_; }

    void skip_blanks() {
        for (;; ++at_) {
            while (at_ != end_ && (*at_ == ' ' || *at_ == '\t')) ++at_;
            // A backslash before the line's end joins two lines.
            if (at_ == end_ || *at_ != '\\') return;
            const char* next = at_ + 1;
            if (next != end_ && *next == '\r') ++next;
            if (next == end_ || *next != '\n') return;
            at_ = next;
            ++line_;
        }
    }
    void next_line() {
        while (!at_line_end()) ++at_;
        if (at_ != end_ && *at_ == '\r') ++at_;
        if (at_ != end_ && *at_ == '\n') ++at_;
        ++line_;
    }
    std::string_view word() {
        skip_blanks();
        const char* begin = at_;
        while (!at_line_end() && *at_ != ' ' && *at_ != '\t') ++at_;
        return {begin, static_cast<std::size_t>(at_ - begin)};
    }
    std::string_view rest_of_line() {
        const char* begin = at_;
        while (!at_line_end()) ++at_;
        return trimmed({begin, static_cast<std::size_t>(at_ - begin)});
    }
    /// May be infinite or NaN.
    bool number(float& value) {
        skip_blanks();
        if (at_ != end_ && *at_ == '+') ++at_;
        const auto [next, error] = std::from_chars(at_, end_, value);
        if (error == std::errc::result_out_of_range) {
            // What is too small for float is zero, what is too large infinite.
            value = static_cast<float>(parse_double({at_, next}).value_or(0));
        } else if (error != std::errc()) {
            return false;
        }
        at_ = next;
        return true;
    }
    bool integer(std::int64_t& value) {
        if (at_ != end_ && *at_ == '+') ++at_;
        const auto [next, error] = std::from_chars(at_, end_, value);
        at_ = next;
        return error == std::errc();
    }
    bool take(char c) {
        if (at_ == end_ || *at_ != c) return false;
        ++at_;
        return true;
    }

private:
    const char* at_;
    const char* end_;
    std::size_t line_ = 1;
};

Error too_many(const Cursor& cursor, const char* what) { return {ErrorCode::limit_exceeded, fmt::format("line {}: too many {}", cursor.line(), what)}; }

/// The v lines as they come. One that is wrong keeps its place, so that faces name the others rightly.
class Vertices {
public:
    Vertices(std::size_t text_size, FaultList& faults) : faults_(faults) { xyz_.reserve(text_size / 24); }

    Result<void> take(Cursor& cursor) {
        float xyz[3] = {};
        if (!cursor.number(xyz[0]) || !cursor.number(xyz[1]) || !cursor.number(xyz[2])) faults_.add(cursor.line(), fmt::format("vertex {} has no three numbers", count()));
        const bool finite = std::isfinite(xyz[0]) && std::isfinite(xyz[1]) && std::isfinite(xyz[2]);
        xyz_.insert(xyz_.end(), xyz, xyz + 3);
        if (count() > std::size_t(kMaxVertices)) return too_many(cursor, "vertices");
        if (!finite && not_finite_.empty()) first_line_ = cursor.line();
        if (!finite) not_finite_.add(std::int64_t(count()) - 1);
        return {};
    }
    std::size_t count() const { return xyz_.size() / 3; }
    /// After the last line: the points, or what was wrong on any line.
    Result<Points> points() const {
        if (!not_finite_.empty()) return faults_.error(fmt::format("line {}: {} not finite", first_line_, not_finite_.subject("vertex", "vertices")));
        if (!faults_.empty()) return faults_.error();
        return Points(Eigen::Map<const Points>(xyz_.data(), Eigen::Index(count()), 3));
    }

private:
    FaultList& faults_;
    std::vector<float> xyz_;
    IndexRanges not_finite_;
    std::size_t first_line_ = 0;  ///< of not_finite_
};

/// Names in force where faces stand, and the parts they make.
class Parts {
public:
    void set(std::string_view statement, std::string_view name) {
        (statement == "usemtl" ? material_ : statement == "g" ? group_ : object_) = std::string(name);
        changed_ = true;
    }
    void add_triangles(std::vector<MeshPart>& parts, std::uint32_t first, std::uint32_t count) {
        if (changed_ || parts.empty()) {
            const auto [name, surface] = current();
            if (parts.empty() || parts.back().name != name || parts.back().surface != surface)
                parts.push_back({name, surface, first, 0});
            changed_ = false;
        }
        parts.back().count += count;
    }

private:
    std::pair<std::string, Surface> current() const {
        const std::string* names[] = {&material_, &group_, &object_};
        if (material_.starts_with(kSurfaceMaterial))
            if (const auto surface = surface_from_name(std::string_view(material_).substr(kSurfaceMaterial.size())))
                return {group_.empty() ? object_ : group_, *surface};
        for (const std::string* name : names)
            if (const auto surface = surface_from_name(*name)) return {*name, *surface};
        for (const std::string* name : names)
            if (!name->empty()) return {*name, Surface::skin};
        return {"", Surface::skin};
    }

    std::string material_, group_, object_;
    bool changed_ = true;
};

constexpr std::uint32_t kNoTexcoord = 0xffffffffu;

struct Corner {
    std::uint32_t vertex, texcoord;
};

/// The corners of the faces. After a wrong one the rest of its line is left out.
class Corners {
public:
    Corners(Cursor& cursor, FaultList& faults) : cursor_(cursor), faults_(faults) {}

    bool take(std::size_t vertices, std::size_t texcoords, Corner& corner) {
        std::int64_t index = 0;
        if (!cursor_.integer(index)) return refuse("a face corner is not a number");
        if (!resolve(index, vertices, "vertex", corner.vertex)) return false;
        corner.texcoord = kNoTexcoord;
        if (cursor_.take('/')) {
            if (!cursor_.take('/')) {
                if (!cursor_.integer(index)) return refuse("a face's texture index is not a number");
                if (!resolve(index, texcoords, "texture coordinate", corner.texcoord)) return false;
                if (cursor_.take('/')) cursor_.integer(index);
            } else {
                cursor_.integer(index);  // the normal's index says nothing we keep
            }
        }
        return true;
    }

private:
    bool refuse(std::string_view what) { return faults_.add(cursor_.line(), what), false; }
    bool resolve(std::int64_t index, std::size_t count, const char* what, std::uint32_t& to) {
        const std::int64_t from_zero = index > 0 ? index - 1 : index + std::int64_t(count);
        if (index == 0 || from_zero < 0 || from_zero >= std::int64_t(count)) return refuse(fmt::format("{} {} does not exist ({} so far)", what, index, count));
        to = static_cast<std::uint32_t>(from_zero);
        return true;
    }

    Cursor& cursor_;
    FaultList& faults_;
};

}  // namespace

Result<Mesh> parse_obj(std::string_view text) {
    Mesh mesh;
    FaultList faults;
    Vertices vertices(text.size(), faults);
    std::vector<Corner> polygon;
    Parts parts;
    bool any_texcoord = false, any_without = false;

    for (Cursor cursor(text); !cursor.at_end(); cursor.next_line()) {
        const std::string_view word = cursor.word();
        if (word == "v") {
            MIEN_CHECK(vertices.take(cursor));
        } else if (word == "vt") {
            float u = 0, v = 0;
            bool good = cursor.number(u) && std::isfinite(u);
            cursor.skip_blanks();
            if (good && !cursor.at_line_end()) good = cursor.number(v) && std::isfinite(v);
            if (!good) faults.add(cursor.line(), fmt::format("texture coordinate {} has no finite numbers", mesh.texcoords.size()));
            mesh.texcoords.emplace_back(u, v);
            if (mesh.texcoords.size() > std::size_t(3 * kMaxTriangles)) return too_many(cursor, "texture coordinates");
        } else if (word == "f") {
            polygon.clear();
            Corner corner;
            bool good = true;
            Corners corners(cursor, faults);
            for (cursor.skip_blanks(); good && !cursor.at_line_end(); cursor.skip_blanks())
                if (good = corners.take(vertices.count(), mesh.texcoords.size(), corner); good) polygon.push_back(corner);
            if (good && polygon.size() < 3) faults.add(cursor.line(), "a face has fewer than three corners");
            if (!good || polygon.size() < 3) continue;
            if (mesh.triangles.size() + polygon.size() > std::size_t(kMaxTriangles)) return too_many(cursor, "triangles");
            parts.add_triangles(mesh.parts, std::uint32_t(mesh.triangles.size()), std::uint32_t(polygon.size() - 2));
            for (std::size_t i = 2; i < polygon.size(); ++i) {
                const Corner &a = polygon[0], &b = polygon[i - 1], &c = polygon[i];
                mesh.triangles.push_back({a.vertex, b.vertex, c.vertex});
                mesh.texcoord_triangles.push_back({a.texcoord, b.texcoord, c.texcoord});
                const bool textured = a.texcoord != kNoTexcoord && b.texcoord != kNoTexcoord && c.texcoord != kNoTexcoord;
                (textured ? any_texcoord : any_without) = true;
            }
        } else if (word == "usemtl" || word == "g" || word == "o") {
            parts.set(word, cursor.rest_of_line());
        }
    }
    MIEN_TRY(positions, vertices.points());
    mesh.positions = std::move(positions);
    if (!any_texcoord) {
        mesh.texcoords.clear();
        mesh.texcoord_triangles.clear();
    } else if (any_without) {
        const auto spare = static_cast<std::uint32_t>(mesh.texcoords.size());
        mesh.texcoords.emplace_back(0, 0);
        for (Triangle& t : mesh.texcoord_triangles)
            if (t[0] == kNoTexcoord || t[1] == kNoTexcoord || t[2] == kNoTexcoord) t = {spare, spare, spare};
    }
    if (mesh.parts.size() == 1 && mesh.parts[0].name.empty() && mesh.parts[0].surface == Surface::skin) mesh.parts.clear();
    return mesh;
}

Result<Points> parse_obj_positions(std::string_view text) {
    FaultList faults;
    Vertices vertices(text.size(), faults);
    for (Cursor cursor(text); !cursor.at_end(); cursor.next_line())
        if (cursor.word() == "v") MIEN_CHECK(vertices.take(cursor));
    return vertices.points();
}

Result<Mesh> read_obj(const std::filesystem::path& path) {
    MIEN_TRY(text, read_text(path));
    auto mesh = parse_obj(text);
    if (!mesh) return in_file(path, mesh.error());
    return mesh;
}

void write_obj(const std::filesystem::path& path, const Mesh& mesh, double unit_mm) {
    fmt::memory_buffer text;
    const auto out = std::back_inserter(text);
    OutputFile file(path);
    const auto flush = [&] {
        file.write(std::string_view(text.data(), text.size()));
        text.clear();
    };
    for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
        // The shortest text that reads back as the same float.
        const auto p = mesh.positions.row(v);
        fmt::format_to(out, "v {} {} {}\n", float(p.x() / unit_mm), float(p.y() / unit_mm), float(p.z() / unit_mm));
        if (text.size() > 1 << 20) flush();
    }
    for (const Vec2& vt : mesh.texcoords) {
        fmt::format_to(out, "vt {} {}\n", vt.x(), vt.y());
        if (text.size() > 1 << 20) flush();
    }
    auto part = mesh.parts.begin();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        while (part != mesh.parts.end() && part->first == t) {
            const auto guessed = surface_from_name(part->name).value_or(Surface::skin);
            fmt::format_to(out, "g {}\n", part->name);
            fmt::format_to(out, "usemtl {}\n",
                           guessed == part->surface ? part->name : std::string(kSurfaceMaterial) + name_of(part->surface));
            ++part;
        }
        const Triangle& v = mesh.triangles[t];
        if (mesh.has_texcoords()) {
            const Triangle& vt = mesh.texcoord_triangles[t];
            fmt::format_to(out, "f {}/{} {}/{} {}/{}\n", v[0] + 1, vt[0] + 1, v[1] + 1, vt[1] + 1, v[2] + 1, vt[2] + 1);
        } else {
            fmt::format_to(out, "f {} {} {}\n", v[0] + 1, v[1] + 1, v[2] + 1);
        }
        if (text.size() > 1 << 20) flush();
    }
    flush();
    file.commit();
}

}  // namespace mien::io
