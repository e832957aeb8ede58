#include "bench/inputs.hpp"

#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "io/npy.hpp"
#include "io/obj.hpp"

namespace mien::bench {
namespace {

std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> fields;
    std::stringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) {
        while (!field.empty() && (field.back() == '\r' || field.back() == ' ')) field.pop_back();
        fields.push_back(field);
    }
    return fields;
}

}  // namespace

Result<Clip> ict_clip(const std::filesystem::path& folder, const std::filesystem::path& csv, std::int64_t first,
                      std::int64_t count, std::int64_t vertices) {
    MIEN_TRY(mesh, io::read_obj(folder / "generic_neutral_mesh.obj"));
    MIEN_TRY(deltas, io::read_npy(folder / "expression_deltas_f32.npy"));
    if (deltas.shape.size() != 3 || deltas.shape[2] != 3 || vertices > deltas.shape[1] ||
        mesh.positions.rows() != deltas.shape[1])
        return Error{ErrorCode::mismatch, "the expressions do not fit the neutral mesh"};

    std::map<std::string, std::int64_t> expression;
    std::ifstream names(folder / "expression_names.txt");
    for (std::string line; std::getline(names, line);) {
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        if (!line.empty()) expression.emplace(line, std::int64_t(expression.size()));
    }
    std::ifstream rows(csv);
    std::string line;
    std::getline(rows, line);
    std::map<std::string, std::size_t> column;
    const auto header = split(line);
    for (std::size_t i = 0; i < header.size(); ++i) column[header[i]] = i;
    std::vector<std::pair<std::size_t, std::int64_t>> map;
    std::ifstream pairs(folder / "arkit_to_ict_map.csv");
    std::getline(pairs, line);
    while (std::getline(pairs, line)) {
        const auto fields = split(line);
        if (fields.size() == 2 && column.count(fields[0]) && expression.count(fields[1]))
            map.emplace_back(column[fields[0]], expression[fields[1]]);
    }
    if (map.empty()) return Error{ErrorCode::missing, "no column of the take names an expression"};

    Clip clip;
    clip.name = "ict";
    clip.frame_rate = {30, 1};
    Mesh neutral;
    neutral.positions = mesh.positions.topRows(vertices) * 10.0f;
    for (const Triangle& t : mesh.triangles)
        if (t[0] < vertices && t[1] < vertices && t[2] < vertices) neutral.triangles.push_back(t);
    clip.vertices = PointSequence(count, vertices);
    std::int64_t frame = -first;
    while (std::getline(rows, line) && frame < count) {
        if (frame >= 0) {
            const auto fields = split(line);
            PointsMap points = clip.vertices->frame(frame);
            points = neutral.positions;
            for (const auto& [from, to] : map) {
                const float weight = std::stof(fields.at(from));
                if (weight == 0) continue;
                const ConstPointsMap delta(deltas.values.data() + to * deltas.shape[1] * 3, vertices, 3);
                points += weight * 10.0f * delta;
            }
        }
        ++frame;
    }
    if (frame < count) return Error{ErrorCode::truncated, "the take has fewer rows than asked for"};
    clip.neutral = std::move(neutral);
    return clip;
}

}  // namespace mien::bench
