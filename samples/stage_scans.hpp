#pragma once

#include <memory>
#include <vector>

#include "core/scan.hpp"
#include "samples/performance.hpp"
#include "samples/skin.hpp"
#include "samples/skin_relief.hpp"

namespace mien::samples {

struct ScannerOptions {
    int medium_size = 512, fine_size = 1024;  ///< texels per side
    bool albedo = true;
    double noise = 0;   ///< standard deviation of every coordinate of a scanned position, mm
    double holes = 0;   ///< share of texels that a frame misses, in blotches, 0 .. 0.9
    std::uint64_t seed = 0;
};

/// Scans of a performance, made when they are read: the stage's perfect scanner, or one with faults. It sees the front of
/// the head: skin whose neutral normal does not point back, in front of the ears.
class StageScans : public ScanSource {
public:
    StageScans(std::shared_ptr<const Actor> actor, std::vector<Instant> instants, const ScannerOptions& options);

    std::int64_t frames() const override { return std::int64_t(instants_.size()); }
    int medium_size() const override { return options_.medium_size; }
    int fine_size() const override { return options_.fine_size; }
    bool has_albedo() const override { return options_.albedo; }
    Result<Scan> read(std::int64_t frame, ScanParts parts = {}) const override;

private:
    /// Positions of the medium surface, plus `height` along its normals if there is one.
    FloatMap positions(const TexelMap& texels, const std::vector<std::uint8_t>& seen, PointsRef points, PointsRef normals, const FloatMap* height) const;
    void spoil(std::int64_t frame, std::uint64_t kind, double noise, FloatMap& map) const;

    std::shared_ptr<const Actor> actor_;
    std::vector<Instant> instants_;
    ScannerOptions options_;
    TexelMap medium_texels_, fine_texels_;
    std::vector<std::uint8_t> medium_seen_, fine_seen_;
    SkinRelief relief_;
    std::unique_ptr<const Skin> skin_;
};

}  // namespace mien::samples
