#include "io/scan_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <mutex>

#include "core/environment_error.hpp"
#include "core/parallel.hpp"
#include "io/file.hpp"
#include "io/image_file.hpp"
#include "io/index_ranges.hpp"
#include "io/numbered_files.hpp"
#include "io/texture_file.hpp"
#include "media/float_picture.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

constexpr float kUnseen = std::numeric_limits<float>::quiet_NaN();

/// A numbered set of maps of one size, three channels each.
class Maps {
public:
    static Result<Maps> open(const fs::path& pattern, std::vector<Error>& faults) {
        Maps maps;
        MIEN_TRY(files, open_numbered(pattern, {".exr"}));
        if (files.fault) faults.push_back(*files.fault);
        maps.paths_ = std::move(files.paths);
        MIEN_TRY(first, read_exr(maps.paths_[0]));
        maps.size_ = first.width;
        MIEN_CHECK(maps.check(first, maps.paths_[0]));
        return maps;
    }

    std::int64_t frames() const { return std::int64_t(paths_.size()); }
    int size() const { return size_; }
    const fs::path& first() const { return paths_[0]; }
    Result<FloatMap> read(std::int64_t frame, float scale) const {
        const fs::path& path = paths_[std::size_t(frame)];
        MIEN_TRY(map, read_exr(path));
        MIEN_CHECK(check(map, path));
        IndexRanges infinite;
        for (std::size_t i = 0; i < map.values.size(); ++i) {
            if (std::isinf(map.values[i])) infinite.add(std::int64_t(i / 3));
            map.values[i] *= scale;
        }
        if (infinite.empty()) return map;
        const std::int64_t first = infinite.first(), others = infinite.count() - 1;
        return Error{ErrorCode::invalid, fmt::format("{}: texel ({}, {}) {} infinite", path.string(), first % size_, first / size_,
                                                     others > 0 ? fmt::format("and {} more are", others) : "is")};
    }

private:
    Result<void> check(const FloatMap& map, const fs::path& path) const {
        const auto wrong = [&](std::string why) { return Error{ErrorCode::mismatch, fmt::format("{} {}", path.string(), why)}; };
        if (map.channels != 3) return wrong("is grey, but three channels are wanted");
        if (map.width != map.height) return wrong(fmt::format("is {} x {}, but maps are square", map.width, map.height));
        if (map.width != size_) return wrong(fmt::format("is {0} x {0}, but the first map is {1} x {1}", map.width, size_));
        return {};
    }

    std::vector<fs::path> paths_;
    int size_ = 0;
};

class ScanFiles : public ScanSource {
public:
    static OpenedScans open(const ScanPaths& paths, double unit) {
        OpenedScans opened;
        bool usable = true;
        const auto unusable = [&](Error error) {
            opened.faults.push_back(std::move(error));
            usable = false;
        };
        const auto maps_of = [&](const fs::path& pattern) -> std::optional<Maps> {
            auto maps = Maps::open(pattern, opened.faults);
            if (maps) return std::move(*maps);
            unusable(maps.error());
            return std::nullopt;
        };
        auto medium = maps_of(paths.medium), fine = maps_of(paths.fine), albedo = paths.albedo ? maps_of(*paths.albedo) : std::nullopt;
        std::vector<fs::path> masks;
        if (paths.masks) {
            auto files = open_numbered(*paths.masks, image_endings());
            if (!files) unusable(files.error());
            else if (files->fault) opened.faults.push_back(*files->fault);
            if (files) masks = std::move(files->paths);
        }
        const auto same_frames = [&](const fs::path& what, std::size_t there) {
            if (medium && std::int64_t(there) != medium->frames())
                unusable({ErrorCode::mismatch, fmt::format("{} has {} frames, but {} has {}", what.string(), there, paths.medium.string(), medium->frames())});
        };
        if (fine) same_frames(paths.fine, std::size_t(fine->frames()));
        if (albedo) same_frames(*paths.albedo, std::size_t(albedo->frames()));
        if (!masks.empty()) same_frames(*paths.masks, masks.size());
        if (fine && albedo && albedo->size() != fine->size())
            unusable({ErrorCode::mismatch, fmt::format("{0} is {1} x {1}, but {2} is {3} x {3}", albedo->first().string(), albedo->size(), fine->first().string(), fine->size())});
        if (!usable) return opened;
        auto scans = std::make_shared<ScanFiles>();
        scans->medium_ = std::move(*medium);
        scans->fine_ = std::move(*fine);
        scans->albedo_ = std::move(albedo);
        scans->masks_ = std::move(masks);
        scans->scale_ = float(unit);
        opened.source = std::move(scans);
        return opened;
    }

    std::int64_t frames() const override { return medium_.frames(); }
    int medium_size() const override { return medium_.size(); }
    int fine_size() const override { return fine_.size(); }
    bool has_albedo() const override { return albedo_.has_value(); }
    Result<Scan> read(std::int64_t frame, ScanParts parts) const override {
        if (frame < 0 || frame >= frames()) return Error{ErrorCode::missing, fmt::format("there is no scan of frame {}", frame)};
        Scan scan;
        if (parts.medium) {
            MIEN_TRY(map, medium_.read(frame, scale_));
            scan.medium = std::move(map);
        }
        if (parts.fine) {
            MIEN_TRY(map, fine_.read(frame, scale_));
            scan.fine = std::move(map);
        }
        if (parts.albedo && albedo_) {
            MIEN_TRY(map, albedo_->read(frame, 1));
            scan.albedo = std::move(map);
        }
        if (!masks_.empty()) {
            MIEN_TRY(mask, read_image(masks_[std::size_t(frame)], 1));
            for (FloatMap* map : {&scan.medium, &scan.fine, &scan.albedo}) hide(mask, *map);
        }
        return scan;
    }

private:
    /// What lies under a texel of the mask that is 0 was not seen.
    static void hide(const Image& mask, FloatMap& map) {
        for (int y = 0; y < map.height; ++y)
            for (int x = 0; x < map.width; ++x)
                if (*mask.at(int((x + 0.5) * mask.width / map.width), int((y + 0.5) * mask.height / map.height)) == 0)
                    std::fill_n(map.at(x, y), map.channels, kUnseen);
    }

    Maps medium_, fine_;
    std::optional<Maps> albedo_;
    std::vector<fs::path> masks_;
    float scale_ = 1;
};

}  // namespace

Result<FloatMap> read_exr(const fs::path& path) {
    MIEN_TRY(bytes, read_bytes(path));
    auto map = media::decode_exr(bytes);
    if (!map) return in_file(path, map.error());
    return map;
}

OpenedScans open_scans(const ScanPaths& paths, double unit) { return ScanFiles::open(paths, unit); }

Result<void> write_scans(const fs::path& folder, const ScanSource& scans, std::int64_t frames, double unit, const Progress& progress) {
    const auto write = [&](const char* name, std::int64_t frame, FloatMap map, double scale, media::ExrNumbers numbers) -> Result<void> {
        if (scale != 1)
            for (float& value : map.values) value = float(value * scale);
        MIEN_TRY(bytes, media::encode_exr(map, numbers));
        write_file(folder / name / fmt::format("{:06}.exr", frame), bytes);
        return {};
    };
    std::error_code error;
    for (const char* name : {"positions_medium", "positions_fine", "albedo"}) {
        if (name == std::string("albedo") && !scans.has_albedo()) continue;
        fs::create_directory(folder / name, error);
        if (error) throw EnvironmentError(fmt::format("cannot make the folder {}: {}", (folder / name).string(), error.message()));
    }
    // A frame of full maps is some 30 MB, so only as many as there are threads are in memory.
    const std::int64_t at_once = std::max(1, thread_count());
    for (std::int64_t first = 0; first < frames; first += at_once) {
        const std::int64_t count = std::min(at_once, frames - first);
        std::vector<Result<void>> done(std::size_t(count), Result<void>{});
        parallel_for(count, [&](std::int64_t i) {
            done[std::size_t(i)] = [&]() -> Result<void> {
                const std::int64_t frame = first + i;
                MIEN_TRY(scan, scans.read(frame));
                MIEN_CHECK(write("positions_medium", frame, std::move(scan.medium), 1 / unit, media::ExrNumbers::float32));
                MIEN_CHECK(write("positions_fine", frame, std::move(scan.fine), 1 / unit, media::ExrNumbers::float32));
                if (scans.has_albedo()) MIEN_CHECK(write("albedo", frame, std::move(scan.albedo), 1, media::ExrNumbers::half));
                return {};
            }();
        });
        for (Result<void>& each : done)
            if (!each) return each.error();
        if (progress) progress("writing scans", first + count, frames);
    }
    return {};
}

}  // namespace mien::io
