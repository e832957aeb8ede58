#include "io/clip_reader.hpp"

#include <fmt/format.h>

#include <cmath>

#include "io/fault_list.hpp"
#include "io/limits.hpp"
#include "io/marker_file.hpp"
#include "io/npy.hpp"
#include "io/number_table.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

bool is_index(double value, std::size_t below) { return value >= 0 && value < double(below) && value == std::floor(value); }

}  // namespace

void ClipReader::read_markers_file() {
    if (!description_.markers) return;
    sources_.markers = description_.markers->string();
    auto markers = take(read_markers(*description_.markers));
    if (!markers) return;
    if (markers->points.points > kMaxMarkers || markers->points.frames > kMaxFrames)
        return problem(ErrorCode::limit_exceeded, fmt::format("{} has more markers or frames than a clip may have", sources_.markers));
    for (const std::string& warning : markers->warnings) findings_.warn(fmt::format("{}: {}", sources_.markers, warning));
    if (const PointFaults& partly = markers->partly_missing; !partly.empty())
        findings_.warn_of_list([&](std::size_t most) {
            return fmt::format("{}: {} time{} a marker lacks one or two of its coordinates, and is missing in that frame: {}", sources_.markers, partly.count(),
                               partly.count() == 1 ? "" : "s", partly.text(most));
        });
    if (markers->frame_rate) rates_.emplace_back(sources_.markers, *markers->frame_rate);
    if (markers->unit) {
        marker_unit_ = markers->unit;
        if (description_.unit && *description_.unit != *marker_unit_)
            findings_.warn(fmt::format("{} says its unit is {}, which counts for it; the clip's is {}", sources_.markers, name_of(*marker_unit_),
                                       name_of(*description_.unit)));
    }
    clip_.markers = std::move(markers->points);
}

std::optional<std::vector<std::vector<double>>> ClipReader::rows_of(const ClipDescription::Numbers& numbers) {
    if (!numbers.file) return numbers.rows;
    const fs::path& path = *numbers.file;
    const auto table = take(read_number_table(path));
    if (!table) return std::nullopt;
    std::vector<std::vector<double>> rows;
    for (std::int64_t r = 0; r < table->rows; ++r) {
        rows.emplace_back();
        for (std::int64_t c = 0; c < table->columns; ++c) rows.back().push_back(table->at(r, c));
        while (!rows.back().empty() && std::isnan(rows.back().back())) rows.back().pop_back();  // a shorter row
    }
    return rows;
}

void ClipReader::read_sites() {
    if (!description_.marker_sites.given()) return;
    const auto rows = rows_of(description_.marker_sites);
    if (!rows) return;
    if (!clip_.neutral && unread("neutral")) return;
    if (!clip_.neutral) return problem(ErrorCode::missing, "marker_sites are places on the neutral mesh, which is not there");
    if (description_.marker_sites.file) sources_.marker_sites = description_.marker_sites.file->string();
    const auto V = std::size_t(clip_.neutral->positions.rows()), T = clip_.neutral->triangles.size();
    // An entry that is wrong keeps its place, so that the others are not counted wrong.
    const auto wrong = [&](std::size_t i, std::string what) {
        problem(ErrorCode::invalid, fmt::format("{}: entry {} {}", sources_.marker_sites, i, what));
        clip_.marker_sites.push_back(Site::at_vertex(0));
    };
    for (std::size_t i = 0; i < rows->size(); ++i) {
        const std::vector<double>& row = (*rows)[i];
        if (row.size() == 1) {
            if (is_index(row[0], V)) clip_.marker_sites.push_back(Site::at_vertex(std::uint32_t(row[0])));
            else wrong(i, fmt::format("names vertex {} of {}", row[0], V));
        } else if (row.size() == 4) {
            const double sum = row[1] + row[2] + row[3];
            if (!is_index(row[0], T)) {
                wrong(i, fmt::format("names triangle {} of {}", row[0], T));
            } else if (!(std::abs(sum - 1) < 1e-3)) {
                wrong(i, fmt::format("has barycentric coordinates that sum up to {}, not 1", sum));
            } else {
                const Triangle& t = clip_.neutral->triangles[std::size_t(row[0])];
                clip_.marker_sites.push_back({{t[0], t[1], t[2]}, {float(row[1] / sum), float(row[2] / sum), float(row[3] / sum)}});
            }
        } else {
            wrong(i, fmt::format("has {} numbers; a vertex, or a triangle and three weights are wanted", row.size()));
        }
    }
}

void ClipReader::read_rigid() {
    if (!description_.rigid.given()) return;
    const auto rows = rows_of(description_.rigid);
    if (!rows) return;
    if (description_.rigid.file) sources_.rigid = description_.rigid.file->string();
    FaultList faults;
    for (const auto& row : *rows)
        for (const double value : row) {
            const bool good = is_index(value, 0xffffffffu);
            if (!good) faults.add(fmt::format("entry {} is no index but {}", clip_.rigid.size(), value));
            clip_.rigid.push_back(good ? std::uint32_t(value) : 0);
        }
    if (!faults.empty()) problem(ErrorCode::invalid, fmt::format("{}: {}", sources_.rigid, faults.error().message));
}

void ClipReader::read_pose_and_gaze() {
    if (description_.head_pose) read_pose(*description_.head_pose);
    if (!description_.gaze) return;
    sources_.gaze = description_.gaze->string();
    const auto table = take(read_number_table(*description_.gaze));
    if (!table) return;
    if (table->columns != 4)
        return problem(ErrorCode::invalid, fmt::format("{} has {} columns; yaw and pitch of the right, then of the left eye are wanted", sources_.gaze, table->columns));
    for (std::int64_t f = 0; f < table->rows; ++f)
        clip_.gaze.push_back({{table->at(f, 0), table->at(f, 2)}, {table->at(f, 1), table->at(f, 3)}});
}

void ClipReader::read_pose(const fs::path& path) {
    sources_.head_pose = path.string();
    std::int64_t frames = 0, columns = 0;
    std::vector<float> values;
    if (lower_case(path.extension().string()) == ".npy") {
        auto array = take(read_npy(path));
        if (!array) return;
        const auto& shape = array->shape;
        const bool matrices = shape.size() == 3 && shape[1] == 4 && shape[2] == 4;
        if (!matrices && !(shape.size() == 2 && shape[1] == 7))
            return problem(ErrorCode::invalid, fmt::format("{} has shape {}; [frames, 7] or [frames, 4, 4] is wanted", path.string(), array->shape_text()));
        frames = shape[0];
        columns = matrices ? 16 : 7;
        values = std::move(array->values);
    } else {
        auto table = take(read_number_table(path));
        if (!table) return;
        if (table->columns != 7)
            return problem(ErrorCode::invalid, fmt::format("{} has {} columns; qw qx qy qz tx ty tz are wanted", path.string(), table->columns));
        frames = table->rows;
        columns = 7;
        values = std::move(table->values);
    }
    IndexRanges wrong;
    for (std::int64_t f = 0; f < frames; ++f) {
        const float* v = values.data() + f * columns;
        RigidPose pose;
        bool rigid;
        if (columns == 7) {
            pose.rotation = Eigen::Quaternionf(v[0], v[1], v[2], v[3]);
            rigid = std::abs(pose.rotation.norm() - 1) < 1e-2f;
            pose.translation = Vec3(v[4], v[5], v[6]);
        } else {
            const Eigen::Map<const Eigen::Matrix<float, 4, 4, Eigen::RowMajor>> matrix(v);
            const Eigen::Matrix3f rotation = matrix.topLeftCorner<3, 3>();
            rigid = (rotation * rotation.transpose() - Eigen::Matrix3f::Identity()).cwiseAbs().maxCoeff() < 1e-2f && rotation.determinant() > 0;
            pose.rotation = Eigen::Quaternionf(rotation);
            pose.translation = matrix.topRightCorner<3, 1>();
        }
        // What is not finite is for validate() to tell.
        if (!rigid && pose.rotation.coeffs().allFinite()) {
            wrong.add(f);
            pose.rotation.setIdentity();
        }
        pose.rotation.normalize();
        clip_.head_pose.push_back(pose);
    }
    if (!wrong.empty())
        findings_.problem_of_list(ErrorCode::invalid, [&](std::size_t most) {
            return fmt::format("{}: {} no rotation and translation", path.string(), wrong.subject("frame", "frames", most));
        });
}

}  // namespace mien::io
