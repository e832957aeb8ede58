#include "io/gltf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/byte_io.hpp"
#include "io/file.hpp"
#include "io/index_ranges.hpp"
#include "io/limits.hpp"
#include "io/surface_names.hpp"

namespace mien::io {
namespace {

using Json = nlohmann::json;

constexpr std::uint32_t kGlbMagic = 0x46546c67, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
constexpr std::uint64_t kMaxGltfValues = 1 << 28;  // 400 morph targets of 200 000 vertices

Error damaged(std::string what) { return {ErrorCode::damaged, std::move(what)}; }

/// json[key] as a whole number that is not negative; `missing` when it is not there.
Result<std::uint64_t> number(const Json& json, const char* key, std::optional<std::uint64_t> missing = std::nullopt) {
    const auto at = json.is_object() ? json.find(key) : json.end();
    if (!json.is_object() || at == json.end()) {
        if (missing) return *missing;
        return damaged(fmt::format("the glTF lacks \"{}\"", key));
    }
    if (!at->is_number_unsigned()) return damaged(fmt::format("the glTF's \"{}\" is not a whole number", key));
    return at->get<std::uint64_t>();
}

const Json* entry(const Json& json, const char* list, std::uint64_t index) {
    const auto at = json.find(list);
    if (at == json.end() || !at->is_array() || index >= at->size() || !(*at)[index].is_object()) return nullptr;
    return &(*at)[index];
}

std::optional<Bytes> decode_base64(std::string_view text) {
    Bytes bytes;
    std::uint32_t held = 0;
    int bits = 0;
    for (const char c : text) {
        int value;
        if (c >= 'A' && c <= 'Z') value = c - 'A';
        else if (c >= 'a' && c <= 'z') value = c - 'a' + 26;
        else if (c >= '0' && c <= '9') value = c - '0' + 52;
        else if (c == '+') value = 62;
        else if (c == '/') value = 63;
        else if (c == '=') break;
        else return std::nullopt;
        held = held << 6 | std::uint32_t(value);
        bits += 6;
        if (bits >= 8) bytes.push_back(static_cast<std::byte>(held >> (bits -= 8) & 255));
    }
    return bytes;
}

struct Values {
    std::int64_t count = 0, width = 0;
    std::vector<double> values;
    double at(std::int64_t i, std::int64_t c) const { return values[std::size_t(i * width + c)]; }
};

class Document {
public:
    Result<void> open(ByteView bytes, const std::filesystem::path& folder) {
        ByteView text = bytes;
        ByteReader in(bytes);
        if (in.u32() == kGlbMagic && in.ok()) {
            if (in.u32() != 2) return Error{ErrorCode::unsupported_version, "only glTF 2.0 is known"};
            in.u32();
            text = {};
            while (in.ok() && in.remaining() >= 8) {
                const std::uint32_t size = in.u32(), kind = in.u32();
                const ByteView chunk = in.bytes(size);
                if (!in.ok()) return Error{ErrorCode::truncated, "the GLB file ends inside a chunk"};
                if (kind == kJsonChunk && text.empty()) text = chunk;
                if (kind == kBinaryChunk && binary_.empty()) binary_ = chunk;
            }
            if (text.empty()) return damaged("the GLB file has no JSON chunk");
        }
        const auto* begin = reinterpret_cast<const char*>(text.data());
        int depth = 0;
        for (std::size_t i = 0; i < text.size(); ++i) {
            depth += begin[i] == '[' || begin[i] == '{' ? 1 : begin[i] == ']' || begin[i] == '}' ? -1 : 0;
            if (depth > 256) return damaged("the glTF's JSON is nested too deeply");
        }
        json_ = Json::parse(begin, begin + text.size(), nullptr, false);
        if (!json_.is_object() || !json_.contains("asset")) return Error{ErrorCode::bad_magic, "this is not a glTF file"};
        if (const auto required = json_.find("extensionsRequired"); required != json_.end() && required->is_array())
            for (const Json& extension : *required) {
                if (extension == "EXT_meshopt_compression" || extension == "KHR_draco_mesh_compression")
                    return Error{ErrorCode::invalid, fmt::format("its geometry is compressed ({}); save it without, for example with: gltf-transform copy IN OUT",
                                                                 extension.get<std::string>())};
            }
        return open_buffers(folder);
    }

    const Json& json() const { return json_; }

    /// An accessor's values as doubles, normalised integers already divided.
    Result<Values> values(std::uint64_t index) const {
        const Json* accessor = entry(json_, "accessors", index);
        if (!accessor) return damaged(fmt::format("the glTF has no accessor {}", index));
        MIEN_TRY(kind, number(*accessor, "componentType"));
        MIEN_TRY(count, number(*accessor, "count"));
        MIEN_TRY(start, number(*accessor, "byteOffset", 0));
        const std::string type = accessor->contains("type") && (*accessor)["type"].is_string() ? (*accessor)["type"].get<std::string>() : "";
        Values result;
        result.width = type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 0;
        const std::uint64_t size = kind == 5120 || kind == 5121 ? 1 : kind == 5122 || kind == 5123 ? 2 : kind == 5125 || kind == 5126 ? 4 : 0;
        if (result.width == 0 || size == 0) return damaged("a glTF accessor's type is unknown");
        if (count > std::uint64_t(kMaxTriangles) * 3) return Error{ErrorCode::limit_exceeded, "a glTF accessor is too large"};
        result.count = std::int64_t(count);
        // Accessors may share bytes or have none at all, so the file's size alone bounds nothing.
        values_read_ += count * std::uint64_t(result.width);
        if (values_read_ > kMaxGltfValues) return Error{ErrorCode::limit_exceeded, "the glTF's accessors are too large together"};
        const bool normalized = accessor->value("normalized", Json(false)) == true;
        const std::uint64_t packed = size * std::uint64_t(result.width);
        if (accessor->contains("bufferView")) {
            MIEN_TRY(view_index, number(*accessor, "bufferView"));
            MIEN_TRY(view, view_bytes(view_index));
            const std::uint64_t stride = view.stride ? view.stride : packed;
            if (count > 0 && (start > view.bytes.size() || view.bytes.size() - start < packed || (count - 1) > (view.bytes.size() - start - packed) / stride))
                return Error{ErrorCode::truncated, "a glTF accessor reaches past its buffer"};
            result.values.reserve(count * std::uint64_t(result.width));
            for (std::uint64_t i = 0; i < count; ++i)
                for (std::uint64_t c = 0; c < std::uint64_t(result.width); ++c)
                    result.values.push_back(component(view.bytes.data() + start + i * stride + c * size, kind, normalized));
        } else {
            result.values.resize(count * std::uint64_t(result.width));
        }
        if (accessor->contains("sparse")) MIEN_CHECK(apply_sparse((*accessor)["sparse"], kind, size, normalized, result));
        return result;
    }

private:
    struct View {
        ByteView bytes;
        std::uint64_t stride = 0;
    };

    Result<void> open_buffers(const std::filesystem::path& folder) {
        const auto list = json_.find("buffers");
        if (list == json_.end() || !list->is_array()) return {};
        for (const Json& buffer : *list) {
            if (!buffer.is_object() || !buffer.contains("uri")) {
                buffers_.push_back(binary_);
                continue;
            }
            const std::string uri = buffer["uri"].is_string() ? buffer["uri"].get<std::string>() : "";
            if (const auto comma = uri.find(";base64,"); uri.starts_with("data:") && comma != std::string::npos) {
                auto bytes = decode_base64(std::string_view(uri).substr(comma + 8));
                if (!bytes) return damaged("a glTF buffer is not base64");
                owned_.push_back(std::move(*bytes));
            } else {
                const std::filesystem::path name = std::filesystem::path(uri).lexically_normal();
                if (folder.empty() || name.empty() || name.is_absolute() || *name.begin() == "..")
                    return damaged(fmt::format("the glTF's buffer \"{}\" is not a file beside it", uri.substr(0, 80)));
                MIEN_TRY(bytes, read_bytes(folder / name));
                owned_.push_back(std::move(bytes));
            }
            buffers_.push_back(owned_.back());
        }
        return {};
    }

    Result<View> view_bytes(std::uint64_t index) const {
        const Json* view = entry(json_, "bufferViews", index);
        if (!view) return damaged(fmt::format("the glTF has no buffer view {}", index));
        MIEN_TRY(buffer, number(*view, "buffer"));
        MIEN_TRY(start, number(*view, "byteOffset", 0));
        MIEN_TRY(size, number(*view, "byteLength"));
        MIEN_TRY(stride, number(*view, "byteStride", 0));
        if (buffer >= buffers_.size()) return damaged(fmt::format("the glTF has no buffer {}", buffer));
        if (start > buffers_[buffer].size() || size > buffers_[buffer].size() - start)
            return Error{ErrorCode::truncated, "a glTF buffer view reaches past its buffer"};
        return View{buffers_[buffer].subspan(start, size), stride};
    }

    static double component(const std::byte* at, std::uint64_t kind, bool normalized) {
        const auto load = [at](auto value, double scale) {
            std::memcpy(&value, at, sizeof value);
            return scale > 0 ? std::max(double(value) / scale, -1.0) : double(value);
        };
        switch (kind) {
            case 5120: return load(std::int8_t(), normalized ? 127 : 0);
            case 5121: return load(std::uint8_t(), normalized ? 255 : 0);
            case 5122: return load(std::int16_t(), normalized ? 32767 : 0);
            case 5123: return load(std::uint16_t(), normalized ? 65535 : 0);
            case 5125: return load(std::uint32_t(), 0);
            default: return load(float(), 0);
        }
    }

    Result<void> apply_sparse(const Json& sparse, std::uint64_t kind, std::uint64_t size, bool normalized, Values& result) const {
        if (!sparse.is_object() || !sparse.contains("indices") || !sparse.contains("values")) return damaged("a sparse glTF accessor is incomplete");
        MIEN_TRY(count, number(sparse, "count"));
        MIEN_TRY(index_kind, number(sparse["indices"], "componentType"));
        MIEN_TRY(index_view, number(sparse["indices"], "bufferView"));
        MIEN_TRY(index_start, number(sparse["indices"], "byteOffset", 0));
        MIEN_TRY(value_view, number(sparse["values"], "bufferView"));
        MIEN_TRY(value_start, number(sparse["values"], "byteOffset", 0));
        MIEN_TRY(indices, view_bytes(index_view));
        MIEN_TRY(values, view_bytes(value_view));
        const std::uint64_t index_size = index_kind == 5121 ? 1 : index_kind == 5123 ? 2 : index_kind == 5125 ? 4 : 0;
        const std::uint64_t packed = size * std::uint64_t(result.width);
        if (index_size == 0) return damaged("a sparse glTF accessor's index type is unknown");
        if (index_start > indices.bytes.size() || count > (indices.bytes.size() - index_start) / index_size || value_start > values.bytes.size() ||
            count > (values.bytes.size() - value_start) / packed)
            return Error{ErrorCode::truncated, "a sparse glTF accessor reaches past its buffer"};
        for (std::uint64_t i = 0; i < count; ++i) {
            const double index = component(indices.bytes.data() + index_start + i * index_size, index_kind, false);
            if (index >= double(result.count)) return damaged("a sparse glTF accessor's index is out of range");
            for (std::uint64_t c = 0; c < std::uint64_t(result.width); ++c)
                result.values[std::size_t(index) * std::size_t(result.width) + c] =
                    component(values.bytes.data() + value_start + i * packed + c * size, kind, normalized);
        }
        return {};
    }

    Json json_;
    ByteView binary_;
    std::deque<Bytes> owned_;
    mutable std::uint64_t values_read_ = 0;
    std::vector<ByteView> buffers_;
};

using Transform = Eigen::Matrix4d;

Transform node_transform(const Json& node) {
    const auto list = [&](const char* key, std::size_t size) -> std::optional<std::vector<double>> {
        const auto at = node.find(key);
        if (at == node.end() || !at->is_array() || at->size() != size) return std::nullopt;
        std::vector<double> values;
        for (const Json& value : *at) values.push_back(value.is_number() ? value.get<double>() : 0);
        return values;
    };
    if (const auto m = list("matrix", 16)) return Eigen::Map<const Transform>(m->data());
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    if (const auto t = list("translation", 3)) transform.translate(Eigen::Vector3d((*t)[0], (*t)[1], (*t)[2]));
    if (const auto r = list("rotation", 4)) transform.rotate(Eigen::Quaterniond((*r)[3], (*r)[0], (*r)[1], (*r)[2]).normalized());
    if (const auto s = list("scale", 3)) transform.scale(Eigen::Vector3d((*s)[0], (*s)[1], (*s)[2]));
    return transform.matrix();
}

/// Gathers the primitives of all nodes into one mesh.
class Gatherer {
public:
    explicit Gatherer(const Document& document) : document_(document), json_(document.json()) {}

    Result<MeshFile> gather() {
        std::vector<std::uint64_t> roots;
        const Json* scene = entry(json_, "scenes", json_.value("scene", Json(0)).is_number_unsigned() ? json_.value("scene", Json(0)).get<std::uint64_t>() : 0);
        if (scene && scene->contains("nodes") && (*scene)["nodes"].is_array()) {
            for (const Json& node : (*scene)["nodes"])
                if (node.is_number_unsigned()) roots.push_back(node.get<std::uint64_t>());
        } else if (json_.contains("nodes") && json_["nodes"].is_array()) {
            for (std::uint64_t i = 0; i < json_["nodes"].size(); ++i) roots.push_back(i);
        }
        for (const std::uint64_t root : roots) MIEN_CHECK(add_node(root, Transform::Identity(), 0));
        if (xyz_.empty()) return damaged("the glTF shows no triangles");

        MeshFile file;
        file.mesh = std::move(mesh_);
        file.mesh.positions = Eigen::Map<const Points>(xyz_.data(), Eigen::Index(xyz_.size() / 3), 3);
        if (!textured_) {
            file.mesh.texcoords.clear();
        } else {
            file.mesh.texcoord_triangles = file.mesh.triangles;
        }
        if (shapes_.size() * xyz_.size() > kMaxGltfValues) return Error{ErrorCode::limit_exceeded, "the morph targets are too large together"};
        for (auto& [name, offsets] : shapes_) {
            offsets.resize(xyz_.size());
            file.blendshapes.push_back({name, Eigen::Map<const Points>(offsets.data(), Eigen::Index(offsets.size() / 3), 3)});
        }
        return file;
    }

private:
    Result<void> add_node(std::uint64_t index, const Transform& parent, int depth) {
        const Json* node = entry(json_, "nodes", index);
        if (!node) return damaged(fmt::format("the glTF has no node {}", index));
        // Nodes that contain each other would never end; nor may a small file name the same node very often.
        if (depth > 64 || ++visited_ > 100000) return damaged("the glTF's nodes contain each other");
        const Transform transform = parent * node_transform(*node);
        if (node->contains("mesh")) {
            MIEN_TRY(mesh, number(*node, "mesh"));
            MIEN_CHECK(add_mesh(mesh, node->value("name", Json("")), transform));
        }
        if (node->contains("children") && (*node)["children"].is_array())
            for (const Json& child : (*node)["children"])
                if (child.is_number_unsigned()) MIEN_CHECK(add_node(child.get<std::uint64_t>(), transform, depth + 1));
        return {};
    }

    Result<void> add_mesh(std::uint64_t index, const Json& node_name, const Transform& transform) {
        const Json* mesh = entry(json_, "meshes", index);
        if (!mesh || !mesh->contains("primitives") || !(*mesh)["primitives"].is_array()) return damaged(fmt::format("the glTF has no mesh {}", index));
        for (const Json& primitive : (*mesh)["primitives"]) {
            if (!primitive.is_object() || !primitive.contains("attributes")) return damaged("a glTF primitive has no attributes");
            MIEN_TRY(mode, number(primitive, "mode", 4));
            if (mode != 4) continue;  // points and lines show no surface
            MIEN_CHECK(add_primitive(primitive, *mesh, node_name, transform));
        }
        return {};
    }

    Result<void> add_primitive(const Json& primitive, const Json& mesh, const Json& node_name, const Transform& transform) {
        const Json& attributes = primitive["attributes"];
        MIEN_TRY(position, number(attributes, "POSITION"));
        MIEN_TRY(positions, document_.values(position));
        if (positions.width != 3) return damaged("glTF positions do not have three numbers");
        const std::size_t base = xyz_.size() / 3;
        if (std::int64_t(base) + positions.count > kMaxVertices) return Error{ErrorCode::limit_exceeded, "too many vertices"};
        IndexRanges not_finite;
        for (std::int64_t v = 0; v < positions.count; ++v) {
            const Eigen::Vector4d p = transform * Eigen::Vector4d(positions.at(v, 0), positions.at(v, 1), positions.at(v, 2), 1);
            for (int axis = 0; axis < 3; ++axis) {
                const auto value = static_cast<float>(p[axis]);
                if (!std::isfinite(value)) not_finite.add(std::int64_t(base) + v);
                xyz_.push_back(value);
            }
        }
        if (!not_finite.empty()) return Error{ErrorCode::invalid, not_finite.subject("vertex", "vertices") + " not finite"};
        MIEN_CHECK(add_texcoords(attributes, positions.count));
        MIEN_CHECK(add_triangles(primitive, positions.count, std::uint32_t(base), part_name(primitive, mesh, node_name)));
        return add_targets(primitive, mesh, base, positions.count, transform);
    }

    Result<void> add_texcoords(const Json& attributes, std::int64_t count) {
        if (!attributes.contains("TEXCOORD_0")) {
            mesh_.texcoords.resize(mesh_.texcoords.size() + std::size_t(count), Vec2::Zero());
            return {};
        }
        MIEN_TRY(index, number(attributes, "TEXCOORD_0"));
        MIEN_TRY(uv, document_.values(index));
        if (uv.width != 2 || uv.count != count) return damaged("glTF texture coordinates do not fit the positions");
        IndexRanges no_place;
        for (std::int64_t v = 0; v < count; ++v) {
            // glTF counts v from the top row of the image, we from the bottom.
            const Vec2 point(float(uv.at(v, 0)), float(1 - uv.at(v, 1)));
            if (!point.allFinite()) no_place.add(std::int64_t(mesh_.texcoords.size()));
            mesh_.texcoords.push_back(point);
        }
        if (!no_place.empty()) return Error{ErrorCode::invalid, no_place.subject("texture coordinate", "texture coordinates") + " not finite"};
        textured_ = true;
        return {};
    }

    Result<void> add_triangles(const Json& primitive, std::int64_t vertices, std::uint32_t base, const std::string& name) {
        const auto first = static_cast<std::uint32_t>(mesh_.triangles.size());
        std::vector<std::uint32_t> corners;
        if (primitive.contains("indices")) {
            MIEN_TRY(index, number(primitive, "indices"));
            MIEN_TRY(indices, document_.values(index));
            for (const double value : indices.values) {
                if (!(value >= 0 && value < double(vertices))) return damaged(fmt::format("a glTF triangle names vertex {} of {}", value, vertices));
                corners.push_back(base + std::uint32_t(value));
            }
        } else {
            for (std::int64_t v = 0; v < vertices; ++v) corners.push_back(base + std::uint32_t(v));
        }
        if (std::int64_t(mesh_.triangles.size() + corners.size() / 3) > kMaxTriangles) return Error{ErrorCode::limit_exceeded, "too many triangles"};
        for (std::size_t i = 0; i + 2 < corners.size(); i += 3) mesh_.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
        mesh_.parts.push_back({name, surface_from_name(name).value_or(Surface::skin), first, std::uint32_t(corners.size() / 3)});
        return {};
    }

    /// The first of material, mesh and node names that tells a surface, else the first there is.
    std::string part_name(const Json& primitive, const Json& mesh, const Json& node_name) const {
        std::vector<std::string> names;
        const auto add = [&](const Json& name) {
            if (name.is_string() && !name.get<std::string>().empty()) names.push_back(name.get<std::string>());
        };
        if (primitive.contains("material") && primitive["material"].is_number_unsigned())
            if (const Json* material = entry(json_, "materials", primitive["material"].get<std::uint64_t>())) add(material->value("name", Json("")));
        add(mesh.value("name", Json("")));
        add(node_name);
        for (const std::string& name : names)
            if (surface_from_name(name)) return name;
        return names.empty() ? "" : names[0];
    }

    Result<void> add_targets(const Json& primitive, const Json& mesh, std::size_t base, std::int64_t count, const Transform& transform) {
        if (!primitive.contains("targets") || !primitive["targets"].is_array()) return {};
        const Json& targets = primitive["targets"];
        if (std::int64_t(targets.size()) > kMaxWeights) return Error{ErrorCode::limit_exceeded, "too many morph targets"};
        const Json extras = mesh.value("extras", Json::object());
        const Json names = extras.is_object() ? extras.value("targetNames", Json::array()) : Json::array();
        for (std::size_t t = 0; t < targets.size(); ++t) {
            const std::string name = t < names.size() && names[t].is_string() ? names[t].get<std::string>() : fmt::format("target{:03}", t);
            if (!targets[t].is_object()) return damaged("a glTF morph target is not an object");
            // Targets of the same name in several primitives and meshes are one shape of the whole head.
            auto at = std::find_if(shapes_.begin(), shapes_.end(), [&](const auto& shape) { return shape.first == name; });
            if (at == shapes_.end()) {
                if (std::int64_t(shapes_.size()) >= kMaxWeights) return Error{ErrorCode::limit_exceeded, "too many morph targets"};
                shapes_.emplace_back(name, std::vector<float>());
                at = shapes_.end() - 1;
            }
            if (!targets[t].contains("POSITION")) continue;
            MIEN_TRY(index, number(targets[t], "POSITION"));
            MIEN_TRY(offsets, document_.values(index));
            if (offsets.width != 3 || offsets.count != count) return damaged("a glTF morph target does not fit its positions");
            at->second.resize((base + std::size_t(count)) * 3);
            for (std::int64_t v = 0; v < count; ++v) {
                const Eigen::Vector4d d = transform * Eigen::Vector4d(offsets.at(v, 0), offsets.at(v, 1), offsets.at(v, 2), 0);
                for (int axis = 0; axis < 3; ++axis) at->second[(base + std::size_t(v)) * 3 + std::size_t(axis)] = static_cast<float>(d[axis]);
            }
        }
        return {};
    }

    const Document& document_;
    const Json& json_;
    Mesh mesh_;
    std::vector<float> xyz_;
    bool textured_ = false;
    std::vector<std::pair<std::string, std::vector<float>>> shapes_;
    int visited_ = 0;
};

}  // namespace

Result<MeshFile> parse_gltf(ByteView bytes, const std::filesystem::path& folder) {
    Document document;
    MIEN_CHECK(document.open(bytes, folder));
    return Gatherer(document).gather();
}

Result<MeshFile> read_gltf(const std::filesystem::path& path) {
    MIEN_TRY(bytes, read_bytes(path));
    auto file = parse_gltf(bytes, path.has_parent_path() ? path.parent_path() : ".");
    if (!file) return in_file(path, file.error());
    return file;
}

}  // namespace mien::io
